"""Local error of an increment in time, and the length of the next one that keeps it small: FORMULATION (28), (29).

With e the error that one increment adds to a position, C_u and C_v the leading terms that the scheme of
`hybrid.scheme` gets wrong in displacement and velocity,

    e   = (|C_u| + |C_v|) Δt² (v̇_{n+1} - v̇_n)              C_u = β - 1/6 - δ/2      C_v = γ - 1/2 - δ      δ = αf - αm
    e_Θ = (|C_u| + |C_v|) Δt² (Ẇ_{n+1} - Ẇ_n) - Δt³/12 W × Ẇ - |Θ|² Θ/12

δ Δt is the time by which the acceleration that generalised alpha carries lags behind v̇. In the error of a rotation the
second term appears because Θ is not the integral of W; the third only with energy-momentum, whose Cayley vector is
longer than the rotation vector. C_v Δt (v̇_{n+1} - v̇_n) is the error of the velocity, which acts for one increment; it
is zero except for Newmark's γ > 1/2. For every scheme of a scene C_u is at least 1/12, so the estimate never vanishes.

| symbol | meaning                                                                    | unit |
|--------|----------------------------------------------------------------------------|------|
| Δt, T  | increment, outer step                                                      | s    |
| E      | of soil: √(Σ m_p |e_p|² / Σ m_p); of a body: |e_c| + r |e_Θ|, r its radius | m    |
| A      | `time.accuracy` times the smallest cell                                    | m    |
| ρ      | E / (A Δt/T), accepted up to 1                                             | -    |

A limits what all increments of an outer step together add to the error of any position. It is measured in cells, the
resolution of the grid; a limit relative to the motion of the step could not be met by soil at rest. As E is
proportional to Δt³ and its share of A to Δt, the next increment is 0.9 ρ^(-1/2) times this one, and the error of a
whole run is proportional to A, for γ > 1/2 to √A. Only the increment is carried from one to the next.

v̇ of the soil is compared at the points, where both values come from the nodes of their own step. At the nodes, v̇_n
would have been transferred to the points and back, which changes it by an amount that does not vanish with Δt unless
transfer is affine. Components that guides hold or drive have no error.

Source: O. C. Zienkiewicz and Y. M. Xie, Earthquake Eng. Struct. Dyn. 20 (1991) 871-887 (e of Newmark's scheme); the
shift δ, and the terms of a turn, follow from Taylor series, of Θ by Magnus.
"""

from dataclasses import dataclass
from math import ceil

import numpy as np

from hybrid.body.attitude import cayley_vector
from hybrid.body.motion import updated
from hybrid.runtime.comm import total
from hybrid.soil.transfer import interpolate
from hybrid.step.joint_rates import engages

SAFETY = 0.9
SHRINK, GROW = 0.2, 2.0     # limits of the ratio of neighbouring increments


@dataclass(frozen=True)
class LocalError:
    """The largest error [m] that an increment adds to a position, and what it belongs to (`of`)."""

    length: float
    of: str


def leading_factor(scheme):
    """|C_u| + |C_v| [-] of the module's equations."""
    shift = scheme.alpha_f - scheme.alpha_m
    return abs(scheme.beta - 1 / 6 - shift / 2) + abs(scheme.gamma - 1 / 2 - shift)


def local_error(step, evaluation):
    """LocalError of a converged `evaluation` of `step`, over soil and bodies."""
    errors = [LocalError(0.0, "a scene without free components")]
    if step.soil is not None:
        errors.append(LocalError(_of_soil(step, evaluation), "the soil"))
    for b in () if engages(step, evaluation.joints) else step.bodies:   # an impulse has no acceleration
        errors.append(LocalError(_of_body(b, b.pose(evaluation.unknowns)), b.body.name))
    return max(errors, key=lambda error: error.length)


def _of_soil(step, evaluation):
    """E [m] of the soil at a converged evaluation."""
    soil, points = step.model.soil, step.soil.points
    new = interpolate(step.soil.basis, soil.grid.shape, evaluation.rates[1])
    mass = points.of_active(soil.constants.mass)
    square = np.sum((new - points.acceleration) ** 2, axis=1)
    return leading_factor(step.model.scheme) * step.dt**2 * np.sqrt(total(mass * square) / total(mass))


def _of_body(b, pose):
    """|e_c| + r |e_Θ| [m] of a BodyStep at its converged pose."""
    new = updated(b.body.mass.inertia, b.state, *pose, b.dt, b.scheme)
    factor = leading_factor(b.scheme) * b.dt**2
    displacement = factor * (new.acceleration - b.state.acceleration)
    rotation = b.state.rotation @ rotation_error(b.state, new, b.scheme, b.dt)
    return np.linalg.norm(displacement * b.free[:3]) + b.body.radius * np.linalg.norm(rotation * b.free[3:])


def rotation_error(old, new, scheme, dt):
    """e_Θ (3,) [rad] in the body frame, between the BodyStates at both ends of an increment `dt` [s]."""
    error = leading_factor(scheme) * dt**2 * (new.spin_rate - old.spin_rate)
    error = error - dt**3 / 12 * np.cross(old.spin, old.spin_rate)
    if scheme.rotation == "cayley":
        theta = cayley_vector(old.rotation.T @ new.rotation)
        error = error - theta @ theta / 12 * theta
    return error


def shorter(dt, ratio):
    """Increment [s] to try instead of `dt`, whose error is `ratio` > 1 times its limit."""
    return dt * max(SHRINK, SAFETY * ratio**-0.5)


def following(dt, ratio, grows):
    """Increment [s] after an accepted `dt` with `ratio` <= 1; longer only if it `grows`."""
    return dt * min(SAFETY * max(ratio, 1e-12) ** -0.5, GROW if grows else 1.0)


def even(dt, remaining):
    """The longest increment [s] up to `dt` that divides `remaining` [s], so that no tiny increment is left at the end."""
    return remaining / max(1, ceil(remaining / dt - 1e-9))
