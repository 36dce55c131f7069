"""Local error of an increment in time, and the length of the next one that keeps it small.

With e the error that one increment adds to a position, C_u and C_v the leading terms that the scheme of
`hybrid.scheme` gets wrong in displacement and velocity,

    e   = (|C_u| + |C_v|) Δt² (v̇_{n+1} - v̇_n)              C_u = β - 1/6 - δ/2      C_v = γ - 1/2 - δ      δ = αf - αm
    e_Θ = (|C_u| + |C_v|) Δt² (Ẇ_{n+1} - Ẇ_n) - Δt³/12 W × Ẇ - |Θ|² Θ/12

δ Δt is how much older than v̇ the acceleration is that generalised alpha carries. The second term of a turn comes
from Θ not being the integral of W, and the third is there only with energy-momentum, whose Cayley vector is longer
than the turn. C_v Δt (v̇_{n+1} - v̇_n) is the error of the velocity, and counts with the increment it acts in; it is
zero but for Newmark's γ > 1/2. For every scheme that a scene may ask for, C_u is at least 1/12, and the estimate not
degenerate.

| symbol | meaning                                                                    | unit |
|--------|----------------------------------------------------------------------------|------|
| Δt, T  | increment, outer step                                                      | s    |
| E      | of soil: √(Σ m_p |e_p|² / Σ m_p); of a body: |e_c| + r |e_Θ|, r its radius | m    |
| A      | `time.accuracy` times the smallest cell                                    | m    |
| ρ      | E / (A Δt/T), accepted up to 1                                             | -    |

A is what all increments of an outer step together may add to the error of any position. It is measured in cells, for
that is the size of what the grid can see; the motion of the step would ask for the impossible where things rest. As E
goes with Δt³ and its share of A with Δt, the next increment is 0.9 ρ^(-1/2) times this one, and the error of a whole
run goes with A, for γ > 1/2 with √A. Nothing but the increment is carried from one to the next.

v̇ of the soil is compared at the points, where both values come from the nodes of their own step; on the nodes, v̇_n
has been to the points and back, and what that changes does not vanish with Δt unless transfer is affine. Components
that guides hold or drive have no error.

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

SAFETY = 0.9
SHRINK, GROW = 0.2, 2.0     # limits of the ratio of neighbouring increments


@dataclass(frozen=True)
class LocalError:
    """The largest error [m] that an increment adds to a position, and whose it is."""

    length: float
    of: str


def leading_factor(scheme):
    """|C_u| + |C_v| [-] of the module's equations."""
    shift = scheme.alpha_f - scheme.alpha_m
    return abs(scheme.beta - 1 / 6 - shift / 2) + abs(scheme.gamma - 1 / 2 - shift)


def local_error(step, evaluation):
    """LocalError of a converged `evaluation` of `step`, over soil and bodies."""
    found = [LocalError(0.0, "nothing that moves")]
    if step.soil is not None:
        found.append(LocalError(_of_soil(step, evaluation), "the soil"))
    for body, state, pose in zip(step.model.bodies, step.state.bodies, evaluation.unknowns.poses):
        found.append(LocalError(_of_body(body, state, pose, step.model.scheme, step.dt), body.name))
    return max(found, key=lambda error: error.length)


def _of_soil(step, evaluation):
    soil, points = step.model.soil, step.soil.points
    new = interpolate(step.soil.basis, soil.grid.shape, evaluation.rates[1])
    mass = soil.constants.mass if points.inactive is None else np.where(points.inactive, 0.0, soil.constants.mass)
    square = np.sum((new - points.acceleration) ** 2, axis=1)
    return leading_factor(step.model.scheme) * step.dt**2 * np.sqrt(total(mass * square) / total(mass))


def _of_body(body, state, pose, scheme, dt):
    new = updated(body.mass.inertia, state, *pose, dt, scheme)
    factor = leading_factor(scheme) * dt**2
    way = factor * (new.acceleration - state.acceleration)
    turn = state.rotation @ turn_error(state, new, scheme, dt)
    return np.linalg.norm(way * body.free[:3]) + body.radius * np.linalg.norm(turn * body.free[3:])


def turn_error(old, new, scheme, dt):
    """e_Θ (3,) [rad] in the body frame, between the BodyStates at both ends of an increment `dt` [s]."""
    error = leading_factor(scheme) * dt**2 * (new.spin_rate - old.spin_rate)
    error = error - dt**3 / 12 * np.cross(old.spin, old.spin_rate)
    if scheme.rotation == "cayley":
        theta = cayley_vector(old.rotation.T @ new.rotation)
        error = error - theta @ theta / 12 * theta
    return error


def shorter(dt, ratio):
    """Increment [s] to try instead of `dt`, whose error is `ratio` > 1 times what it may be."""
    return dt * max(SHRINK, SAFETY * ratio**-0.5)


def following(dt, ratio, grows):
    """Increment [s] after an accepted `dt` with `ratio` <= 1; longer only if it `grows`."""
    return dt * min(SAFETY * max(ratio, 1e-12) ** -0.5, GROW if grows else 1.0)


def even(dt, rest):
    """The longest increment [s] up to `dt` of which a whole number makes `rest` [s]: no sliver is left at the end."""
    return rest / max(1, ceil(rest / dt - 1e-9))
