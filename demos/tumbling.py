"""Which time integration for a body that turns? Order of the error, and what is kept over ten thousand steps.

      tumbling                                    heavy top
                                                       /
      ===O===    J = diag(1, 2, 3) kg m²         |   (O)    J = diag(2, 2, 1) kg m² about the tip, tilted
         |       W = (0.01, 1, 0) rad/s        F |   /      by 0.3 rad, W = (0, 0, 10) rad/s, weight 8 N
         |       about the intermediate          v  /       one metre up the axis: it precesses, and nods
                 axis: it turns over               V        every 1.9 s

    J Ẇ + W × J W = Rᵀ (R r × F)          R' = R W̃          r: arm of the weight F in the body frame

The free body's spin has the period 4 K(m)/λ = 41.5092195 s (Landau and Lifshitz, Mechanics, sec. 37); attitudes are
compared with an integration to round-off. Three unknowns, 100 000 steps, a figure: two minutes.

Error of the attitude [rad] after a quarter of that period and after 1.2 s of the top, at the longest and the shortest
step, and its order over the last halving:

                                   tumbling 0.208 s           0.0259 s        top 0.024 s            0.003 s
    Newmark (1/4, 1/2)                    8.4e-03     1.3e-04 (2.00)            1.1e-02     1.8e-04 (2.00)
    Newmark (0.5625, 1)                   2.9e-01     3.7e-02 (1.00)            1.7e-01     2.2e-02 (0.99)
    generalised α, ρ∞ = 0.8               8.8e-03     1.4e-04 (2.00)            1.2e-02     1.9e-04 (2.00)
    generalised α, ρ∞ = 0.5               1.2e-02     1.9e-04 (2.00)            1.6e-02     2.5e-04 (2.00)
    energy-momentum                       4.3e-02     6.8e-04 (2.00)            5.6e-02     8.9e-04 (2.00)

Largest relative change of energy E and angular momentum π (of the top: the vertical one) in 10 000 steps of 0.05 s
and of 0.01 s, a dozen periods and fifty nods:

                                         tumbling E                  π              top E                  π
    Newmark (1/4, 1/2)                      2e-04              5e-04              8e-06              6e-05
    Newmark (0.5625, 1)                     7e-01              4e-01              3e-01              2e+00
    generalised α, ρ∞ = 0.8                 2e-04              5e-04              1e-05              6e-05
    generalised α, ρ∞ = 0.5                 4e-04              8e-04              1e-04              7e-04
    energy-momentum                         5e-13              4e-13              2e-13              1e-13

Newmark's (1/4, 1/2) has the smallest error; its E and π waver by Δt² and do not drift. Energy-momentum keeps both to
round-off, at five times the error of attitude: a Cayley turn lags behind its angle. Generalised alpha costs hardly any
accuracy at ρ∞ = 0.8. The dissipative pair of Newmark's is for settling only: under it the top falls over.

    .venv/bin/python demos/tumbling.py
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from hybrid.body.attitude import exp_so3, log_so3, skew
from hybrid.body.motion import inertia_residual, updated
from hybrid.output.figures import convergence
from hybrid.scheme import Scheme
from hybrid.state import BodyState

OUT = Path("out/tumbling")
SCHEMES = {
    "Newmark (1/4, 1/2)": Scheme.newmark(),
    "Newmark (0.5625, 1)": Scheme.newmark(0.5625, 1.0),
    "generalised α, ρ∞ = 0.8": Scheme.generalised_alpha(0.8),
    "generalised α, ρ∞ = 0.5": Scheme.generalised_alpha(0.5),
    "energy-momentum": Scheme.energy_momentum(),
}
ORDERS = (2, 1, 2, 2, 2)


@dataclass(frozen=True)
class Top:
    """A body that turns about a fixed point: inertia (3, 3) [kg m²] about it, force (3,) [N] constant in space at the
    end of an arm (3,) [m] of the body, and how it starts: spin (3,) [rad/s], rotation (3, 3)."""

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
        """Angular momentum [N m s] in space; of a top under a force its component along that."""
        whole = state.rotation @ self.inertia @ state.spin
        return whole @ self.force / np.linalg.norm(self.force) if self.force.any() else whole


TUMBLING = Top(np.diag([1.0, 2.0, 3.0]), np.array([0.01, 1.0, 0.0]), np.eye(3), np.zeros(3), np.zeros(3))
HEAVY = Top(np.diag([2.0, 2.0, 1.0]), np.array([0.0, 0.0, 10.0]), exp_so3([0.3, 0.0, 0.0]),
            np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, -8.0]))


def period(top):
    """Of the spin of a free body [s], for L² = |J W|² < 2T J2: W1 then never changes its sign."""
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


def advance(top, state, dt, scheme, inertia_of=inertia_residual):
    """State after a step `dt` [s]. Newton's method is quadratic: after an update below 1e-8 only round-off is left."""
    arm, force = top.arm, skew(top.force)
    rotation = state.rotation @ exp_so3(dt * state.spin + 0.5 * dt**2 * state.spin_rate)
    for _ in range(20):
        residual, tangent = inertia_of(1.0, top.inertia, state, state.position, rotation, dt, scheme)
        tangent = tangent[3:, 3:] - force @ skew(rotation @ arm)
        update = np.linalg.solve(tangent, top.moment(rotation) - residual[3:])
        rotation = exp_so3(update) @ rotation
        if np.linalg.norm(update) < 1e-8:
            return updated(top.inertia, state, state.position, rotation, dt, scheme)
    raise AssertionError(f"no convergence: last update {np.linalg.norm(update):g} rad")


def errors(top, duration, counts, scheme, inertia_of=inertia_residual):
    """Errors of attitude [rad] and spin [rad/s] after `duration` [s], a row for each number of steps."""
    spin, rotation = reference(top, duration)
    rows = []
    for count in counts:
        state = top.start()
        for _ in range(count):
            state = advance(top, state, duration / count, scheme, inertia_of)
        rows.append((np.linalg.norm(log_so3(rotation.T @ state.rotation)), np.linalg.norm(state.spin - spin)))
    return np.array(rows)


def drift(top, dt, steps, scheme):
    """Largest relative changes of energy and momentum on the way, (2,), and those at the end, (2,)."""
    state = top.start()
    energy, momentum = top.energy(state), top.momentum(state)
    largest = np.zeros(2)
    for _ in range(steps):
        state = advance(top, state, dt, scheme)
        change = np.array([(top.energy(state) - energy) / abs(energy),
                           np.linalg.norm(top.momentum(state) - momentum) / np.linalg.norm(momentum)])
        largest = np.maximum(largest, np.abs(change))
    return largest, change


def order(counts, error):
    """Observed order in the step: slope of the error over the last refinement."""
    return np.log(error[-2] / error[-1]) / np.log(counts[-1] / counts[-2])


def table(rows, headings):
    """Lines of a table with a first column of text."""
    yield f"    {'':26}" + "".join(f"{heading:>19}" for heading in headings)
    for name, cells in rows.items():
        yield f"    {name:26}" + "".join(f"{cell:>19}" for cell in cells)


if __name__ == "__main__":
    assert abs(period(TUMBLING) - 41.5092195) < 5e-8
    cases = ((TUMBLING, period(TUMBLING) / 4, (50, 100, 200, 400), 0.05), (HEAVY, 1.2, (50, 100, 200, 400), 0.01))
    curves, attitude, kept = {}, {}, {}
    for (name, scheme), expected in zip(SCHEMES.items(), ORDERS):
        found = [(counts, errors(top, duration, counts, scheme)[:, 0]) for top, duration, counts, _ in cases]
        observed = [order(*pair) for pair in found]
        label = name.replace("ρ∞", r"$\rho_\infty$").replace("α", r"$\alpha$")
        curves[label] = [(case[1] / np.array(counts), error) for case, (counts, error) in zip(cases, found)]
        attitude[name] = [f"{error[n]:.1e}" + f" ({rate:.2f})" * (n == -1)
                          for (_, error), rate in zip(found, observed) for n in (0, -1)]
        kept[name] = [f"{change:.0e}" for top, _, _, dt in cases for change in drift(top, dt, 10_000, scheme)[0]]
        assert np.allclose(observed, expected, atol=0.1), f"{name}: orders {observed}"
    assert all(float(change) < 1e-10 for change in kept["energy-momentum"])
    steps = [f"{case[1] / count:.3g} s" for case in cases for count in (case[2][0], case[2][-1])]
    print(*table(attitude, [f"tumbling {steps[0]}", steps[1], f"top {steps[2]}", steps[3]]), sep="\n")
    print(*table(kept, ["tumbling E", "π", "top E", "π"]), sep="\n")
    print(convergence(OUT / "tumbling.png", curves, ("tumbling", "heavy top"), "error of the attitude [rad]"))
