"""A free body tumbles about its intermediate axis: time integration of rotation alone, three unknowns.

    J = diag(1, 2, 3) kg m²       W(0) = (0.01, 1, 0) rad/s       J Ẇ + W × J W = Rᵀ (R r × F)       R' = R W̃

r is the arm of a weight F in the body frame, zero for the free body. Its spin has the period 4 K(m)/λ = 41.5092195 s
(Landau and Lifshitz, Mechanics, sec. 37); the attitude after a quarter of it is compared with an integration to
round-off.
"""

from dataclasses import dataclass
from time import process_time

import numpy as np
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from hybrid.body.attitude import exp_so3, log_so3, skew
from hybrid.body.motion import inertia_residual, updated
from hybrid.runtime.errors import StepError
from hybrid.scheme import Scheme
from hybrid.state import BodyState
from hybrid.study.precision.problem import Problem
from hybrid.study.precision.record import RunResult
from hybrid.study.precision.settings import PUBLISHED

SCHEMES = {
    "generalised α, ρ∞ = 0.5": Scheme.default().in_flight,      # the default of a scene
    "generalised α, ρ∞ = 0": Scheme.generalised_alpha(0.0),
    PUBLISHED: Scheme.newmark(),
    "Newmark (0.5625, 1)": Scheme.newmark(0.5625, 1.0),
    "generalised α, ρ∞ = 0.8": Scheme.generalised_alpha(0.8),
    "energy-momentum": Scheme.energy_momentum(),
}
COUNTS = (25, 50, 100, 200, 400, 800)


@dataclass(frozen=True)
class Top:
    """A body that rotates about a fixed point: inertia (3, 3) [kg m²] about it, force (3,) [N] constant in space, arm
    (3,) [m] of the force in the body frame, initial spin (3,) [rad/s] and rotation (3, 3)."""

    inertia: np.ndarray
    spin: np.ndarray
    rotation: np.ndarray
    arm: np.ndarray
    force: np.ndarray

    def moment(self, rotation):
        """(3,) [N m] in space."""
        return skew(rotation @ self.arm) @ self.force

    def spin_rate(self, spin, rotation):
        """(3,) [rad/s²] in the body frame."""
        return np.linalg.solve(
            self.inertia, rotation.T @ self.moment(rotation) - skew(spin) @ self.inertia @ spin)

    def start(self):
        """BodyState in equilibrium; its centre is the fixed point."""
        zero = np.zeros(3)
        return BodyState(zero, self.rotation, zero, zero, self.spin, self.spin_rate(self.spin, self.rotation))

    def energy(self, state):
        """Kinetic and potential [J]."""
        return 0.5 * state.spin @ self.inertia @ state.spin - self.force @ state.rotation @ self.arm

    def momentum(self, state):
        """Angular momentum (3,) [N m s] in space; under a force, only its component along the force."""
        whole = state.rotation @ self.inertia @ state.spin
        return whole @ self.force / np.linalg.norm(self.force) if self.force.any() else whole


TUMBLING = Top(np.diag([1.0, 2.0, 3.0]), np.array([0.01, 1.0, 0.0]), np.eye(3), np.zeros(3), np.zeros(3))
HEAVY = Top(np.diag([2.0, 2.0, 1.0]), np.array([0.0, 0.0, 10.0]), exp_so3([0.3, 0.0, 0.0]),
            np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, -8.0]))


def period(top):
    """Period [s] of the spin of a free body with L² = |J W|² < 2T J2, for which W1 never changes its sign."""
    (j1, j2, j3), spin = np.diag(top.inertia), top.spin
    momentum, energy = np.sum((top.inertia @ spin) ** 2), spin @ top.inertia @ spin
    assert j1 * energy < momentum < j2 * energy
    below, above = (j2 - j1) * (j3 * energy - momentum), (j3 - j2) * (momentum - j1 * energy)
    return 4 * ellipk(above / below) / np.sqrt(below / (j1 * j2 * j3))


def reference(top, duration):
    """Spin (3,) and rotation (3, 3) after `duration` [s], integrated to round-off."""
    def rates(_, x):
        spin, rotation = x[:3], x[3:].reshape(3, 3)
        return np.concatenate((top.spin_rate(spin, rotation), (rotation @ skew(spin)).ravel()))

    begin = np.concatenate((top.spin, top.rotation.ravel()))
    x = solve_ivp(rates, (0, duration), begin, method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    return x[:3], x[3:].reshape(3, 3)


def turned(top, state, dt, scheme, inertia_of=inertia_residual):
    """(State after a step `dt` [s], Newton updates). Newton's method is quadratic: after an update below 1e-8 only
    round-off is left. Raises StepError if it does not converge."""
    arm, force = top.arm, skew(top.force)
    rotation = state.rotation @ exp_so3(dt * state.spin + 0.5 * dt**2 * state.spin_rate)
    for count in range(1, 21):
        residual, tangent = inertia_of(1.0, top.inertia, state, state.position, rotation, dt, scheme)
        tangent = tangent[3:, 3:] - force @ skew(rotation @ arm)
        update = np.linalg.solve(tangent, top.moment(rotation) - residual[3:])
        rotation = exp_so3(update) @ rotation
        if np.linalg.norm(update) < 1e-8:
            return updated(top.inertia, state, state.position, rotation, dt, scheme), count
    raise StepError(f"no convergence: last update {np.linalg.norm(update):g} rad, limit 1e-8 rad; shorten the step")


def advance(*step, **how):
    """State after a step; arguments as for `turned`."""
    return turned(*step, **how)[0]


def after(top, duration, count, scheme, **how):
    """(State after `duration` [s] in `count` steps, Newton updates of all of them)."""
    state, newton = top.start(), 0
    for _ in range(count):
        state, updates = turned(top, state, duration / count, scheme, **how)
        newton += updates
    return state, newton


def apart(state, exact):
    """Angle [rad] between the attitude of a `state` and the exact one, and distance of the spins [rad/s]; `exact` is
    spin and rotation, as `reference` gives them."""
    spin, rotation = exact
    return np.linalg.norm(log_so3(rotation.T @ state.rotation)), np.linalg.norm(state.spin - spin)


def errors(top, duration, counts, scheme, **how):
    """Errors of attitude [rad] and spin [rad/s] after `duration` [s], a row for each number of steps."""
    exact = reference(top, duration)
    return np.array([apart(after(top, duration, count, scheme, **how)[0], exact) for count in counts])


def curves(quick):
    """Every scheme over Δt; the first one is the default of a scene."""
    quarter = period(TUMBLING) / 4
    counts, names = ((50, 100), list(SCHEMES)[:2]) if quick else (COUNTS, SCHEMES)
    found = {name: [(f"Δt = {quarter / count:.3g} s", {"scheme": name, "count": count}) for count in counts]
             for name in names}
    return {"default" if n == 0 else name: settings for n, (name, settings) in enumerate(found.items())}


def solve(scheme, count):
    """RunResult of a quarter of a period in `count` steps of a scheme by name; raises StepError if one fails."""
    quarter = period(TUMBLING) / 4
    begin = process_time()
    state, newton = after(TUMBLING, quarter, count, SCHEMES[scheme])
    seconds = process_time() - begin
    attitude, spin = apart(state, reference(TUMBLING, quarter))
    errors_found = {"attitude": float(attitude / np.pi), "spin": float(spin / np.linalg.norm(TUMBLING.spin))}
    return RunResult(errors_found, newton, 3, seconds)


PROBLEM = Problem(
    title="intermediate axis",
    errors={"attitude": "angle to the exact attitude after a quarter of a period, over π [-]",
            "spin": "|W - W_exact| / |W(0)| after a quarter of a period [-]"},
    shown=tuple(SCHEMES)[1:], curves=curves, solve=solve)
