"""Torque-free rotation of a body: tumbling about the intermediate axis, and the order of Newmark's rule.

    J = diag(1, 2, 3) kg m²,  W(0) = (ε, 1, 0) rad/s      period of W = 4 K(m)/λ, K complete elliptic integral

With L² = |J W|² < 2T J2, 2T = W·J W, W1 never changes sign and

    λ² = (J2 - J1)(2T J3 - L²)/(J1 J2 J3)        m = (J3 - J2)(L² - 2T J1) / [(J2 - J1)(2T J3 - L²)]

(Landau and Lifshitz, Mechanics, sec. 37, with axes 1 and 3 exchanged). For ε = 1e-2 this is 41.5092195 s.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from hybrid.body.attitude import exp_so3, log_so3, skew
from hybrid.body.motion import inertia_residual, updated
from hybrid.state import BodyState

INERTIA = np.diag([1.0, 2.0, 3.0])


def start(spin, gyroscopic=True):
    """Committed state whose spin rate is in equilibrium with its spin."""
    rate = np.linalg.solve(INERTIA, -np.cross(spin, INERTIA @ spin)) if gyroscopic else np.zeros(3)
    return BodyState(np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3), np.array(spin, float), rate)


def without_gyroscopic_term(state, position, rotation, dt, beta, gamma):
    """The broken variant: residual R J A. The tangent keeps the term, which costs iterations only."""
    residual, tangent = inertia_residual(1.0, INERTIA, state, position, rotation, dt, beta, gamma)
    spin = updated(state, position, rotation, dt, beta, gamma)[2]
    residual[3:] -= rotation @ np.cross(spin, INERTIA @ spin)
    return residual, tangent


def complete(*args):
    return inertia_residual(1.0, INERTIA, *args)


def advance(state, dt, function=complete, beta=0.25, gamma=0.5):
    """One step, Newton's iteration from the constant-rate prediction: new state and iterations."""
    position = state.position
    rotation = state.rotation @ exp_so3(dt * state.spin + 0.5 * dt**2 * state.spin_rate)
    for iteration in range(30):
        residual, tangent = function(state, position, rotation, dt, beta, gamma)
        if np.linalg.norm(residual) < 1e-11:
            rates = updated(state, position, rotation, dt, beta, gamma)
            return BodyState(position, rotation, *rates), iteration
        step = np.linalg.solve(tangent, -residual)
        position, rotation = position + step[:3], exp_so3(step[3:]) @ rotation
    raise AssertionError(f"no convergence: residual {np.linalg.norm(residual):g} after 30 iterations")


def closed_form_period(spin):
    j1, j2, j3 = np.diag(INERTIA)
    momentum, energy = np.sum((INERTIA @ spin) ** 2), spin @ INERTIA @ spin
    assert j1 * energy < momentum < j2 * energy
    below, above = (j2 - j1) * (j3 * energy - momentum), (j3 - j2) * (momentum - j1 * energy)
    return 4 * ellipk(above / below) / np.sqrt(below / (j1 * j2 * j3))


def tumbling_period(dt):
    """Twice the time between the first two zeros of W2, where the body turns over fastest."""
    state, time, zeros = start([1e-2, 1.0, 0.0]), 0.0, []
    while len(zeros) < 2:
        new, _ = advance(state, dt)
        before, after = state.spin[1], new.spin[1]
        if before * after <= 0.0:
            zeros.append(time + dt * before / (before - after))
        state, time = new, time + dt
    return 2 * (zeros[1] - zeros[0])


def test_intermediate_axis_period():
    reference = closed_form_period(np.array([1e-2, 1.0, 0.0]))
    assert reference == pytest.approx(41.5092195, abs=5e-8)
    coarse, fine = tumbling_period(0.2), tumbling_period(0.1)
    assert fine == pytest.approx(reference, abs=4e-3)
    assert np.log2((coarse - reference) / (fine - reference)) == pytest.approx(2.0, abs=0.1)
    assert (4 * fine - coarse) / 3 == pytest.approx(reference, abs=5e-4)     # extrapolated to dt = 0


SPIN, DURATION = np.array([0.8, 1.0, -0.6]), 1.6


def reference_motion():
    """Spin and rotation from Euler's equations and R' = R W̃, integrated to round-off."""
    def rates(_, x):
        w, r = x[:3], x[3:].reshape(3, 3)
        return np.concatenate((np.linalg.solve(INERTIA, -np.cross(w, INERTIA @ w)), (r @ skew(w)).ravel()))

    begin = np.concatenate((SPIN, np.eye(3).ravel()))
    x = solve_ivp(rates, (0, DURATION), begin, method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    return x[:3], x[3:].reshape(3, 3)


def errors(function, counts, gyroscopic=True):
    """Error of attitude [rad] and of spin [rad/s] after DURATION, one row per number of steps."""
    spin, rotation = reference_motion()
    rows = []
    for count in counts:
        state = start(SPIN, gyroscopic)
        for _ in range(count):
            state, _ = advance(state, DURATION / count, function)
        rows.append((np.linalg.norm(log_so3(rotation.T @ state.rotation)), np.linalg.norm(state.spin - spin)))
    return np.array(rows)


def slopes(counts, error):
    return -np.polyfit(np.log(counts), np.log(error), 1)[0]


def test_attitude_and_spin_converge_with_second_order():
    counts = [8, 16, 32, 64]
    attitude, spin = slopes(counts, errors(complete, counts))
    assert 1.9 < attitude < 2.1 and 1.9 < spin < 2.1


@pytest.mark.parametrize("gyroscopic", [True, False])
def test_convergence_is_lost_without_the_gyroscopic_term(gyroscopic):
    """Whether or not the initial spin rate knows of the term."""
    counts = [8, 16, 32]
    error = errors(without_gyroscopic_term, counts, gyroscopic)
    assert (np.abs(slopes(counts, error)) < 1.5).all()
    assert (error[-1] > 0.1).all()


def test_newton_converges_quadratically_and_keeps_the_invariants():
    state = start(SPIN)
    energy, momentum = SPIN @ INERTIA @ SPIN, INERTIA @ SPIN
    for _ in range(100):
        state, iterations = advance(state, 0.02)
        assert iterations <= 3
    assert state.spin @ INERTIA @ state.spin == pytest.approx(energy, rel=1e-4)
    np.testing.assert_allclose(state.rotation @ INERTIA @ state.spin, momentum, atol=1e-3)
    np.testing.assert_allclose(state.rotation @ state.rotation.T, np.eye(3), atol=1e-12)
