"""Inertia residual of a body in every scheme: exact tangent, limits, and what the rules integrate exactly."""

from dataclasses import fields, replace

import numpy as np
import pytest

from hybrid.body.attitude import cayley, cayley_rate, cayley_vector, exp_so3, log_so3, right_tangent, skew
from hybrid.body.motion import free_spin_rate, inertia_residual, momentum_rate, rotation_angle, updated
from hybrid.scheme import Scheme
from hybrid.state import BodyState

MASS = 7.0
INERTIA = np.array([[2.0, 0.3, -0.2], [0.3, 3.1, 0.4], [-0.2, 0.4, 1.4]])
NEWMARK = Scheme.newmark()
SCHEMES = {
    "newmark": NEWMARK,
    "dissipative": Scheme.newmark(0.5625, 1.0),
    "alpha 0.8": Scheme.generalised_alpha(0.8),
    "alpha 0": Scheme.generalised_alpha(0.0),
    "energy-momentum": Scheme.energy_momentum(),
}
every_scheme = pytest.mark.parametrize("scheme", SCHEMES.values(), ids=SCHEMES)


def committed(seed=3, rates=1.0):
    rng = np.random.default_rng(seed)
    vectors = rng.normal(size=(7, 3))
    return BodyState(vectors[0], exp_so3([0.4, -1.1, 0.7]), *(rates * vectors[1:5]),
                     algorithmic=rates * vectors[5:].ravel())


def trial(state, angle, seed=5):
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=3)
    turned = exp_so3(angle * axis / np.linalg.norm(axis))
    return state.position + 0.02 * rng.normal(size=3), state.rotation @ turned


def moved(position, rotation, step):
    return position + step[:3], exp_so3(step[3:]) @ rotation


def difference_tangent(function, position, rotation, h):
    columns = []
    for e in np.eye(6):
        plus, minus = (function(*moved(position, rotation, s * h * e)) for s in (1, -1))
        columns.append((plus - minus) / (2 * h))
    return np.array(columns).T


@every_scheme
@pytest.mark.parametrize("angle", [0.0, 1e-10, 1e-4, 0.29, 0.5, 2.0])
@pytest.mark.parametrize("dt", [0.3, 0.01])
def test_tangent_equals_central_differences(angle, scheme, dt):
    state = committed(rates=3.0)
    position, rotation = trial(state, angle)
    tangent = inertia_residual(MASS, INERTIA, state, position, rotation, dt, scheme)[1]
    fd = difference_tangent(
        lambda c, r: inertia_residual(MASS, INERTIA, state, c, r, dt, scheme)[0], position, rotation, 1e-5)
    for rows in (slice(0, 3), slice(3, 6)):   # force and moment on their own scales
        assert np.abs(tangent - fd)[rows].max() < 1e-8 * np.abs(fd[rows]).max()


def taylor_slope(scheme, error=lambda tangent, residual, state, rotation: 0.0, angle=0.5, dt=0.05):
    """Order of the remainder when `error` is added to the tangent of the rotations."""
    state = committed(rates=3.0)
    position, rotation = trial(state, angle)
    residual, tangent = inertia_residual(MASS, INERTIA, state, position, rotation, dt, scheme)
    tangent[3:, 3:] += error(tangent[3:, 3:], residual, state, rotation)
    direction = np.random.default_rng(8).normal(size=6)
    steps = 0.2 * 0.5 ** np.arange(6)
    remainders = []
    for h in steps:
        there = moved(position, rotation, h * direction)
        there = inertia_residual(MASS, INERTIA, state, *there, dt, scheme)[0]
        remainders.append(np.linalg.norm(there - residual - h * tangent @ direction))
    return np.polyfit(np.log(steps[2:]), np.log(remainders[2:]), 1)[0]


@every_scheme
def test_taylor_remainder_is_second_order(scheme):
    assert taylor_slope(scheme) > 1.95


def without_moment(tangent, residual, state, rotation):
    return skew(residual[3:])


def without_momentum(tangent, residual, state, rotation):
    """Of energy-momentum: as if R J W were turned, not R."""
    spin = updated(INERTIA, state, state.position, rotation, 0.05, SCHEMES["energy-momentum"]).spin
    return 2 / 0.05 * skew(rotation @ INERTIA @ spin)


def exponential_rate(tangent, residual, state, rotation):
    """Of energy-momentum: dΘ/dΦ of the exponential map at the same angle."""
    turned = state.rotation.T @ rotation
    wrong = np.linalg.inv(right_tangent(log_so3(turned))) - cayley_rate(cayley_vector(turned))
    return (2 / 0.05) ** 2 * rotation @ INERTIA @ wrong @ rotation.T


@pytest.mark.parametrize("name, error", [
    *((name, without_moment) for name in SCHEMES), ("energy-momentum", without_momentum),
    ("energy-momentum", exponential_rate)])
def test_taylor_test_notices_a_wrong_term(name, error):
    assert taylor_slope(SCHEMES[name], error) < 1.3


def test_rates_follow_newmark():
    """Constant acceleration about a fixed axis is integrated exactly, with any pair."""
    dt, axis = 0.4, np.array([0.0, 0.6, 0.8])
    spin, spin_rate = 0.7 * axis, 0.3 * axis
    velocity, acceleration = np.array([1.0, 2.0, -1.0]), np.array([0.0, 0.5, -9.81])
    state = BodyState(np.ones(3), exp_so3([0.1, 0.2, 0.3]), velocity, acceleration, spin, spin_rate)
    position = state.position + dt * velocity + dt**2 / 2 * acceleration
    rotation = state.rotation @ exp_so3(dt * spin + dt**2 / 2 * spin_rate)
    expected = {"velocity": velocity + dt * acceleration, "acceleration": acceleration,
                "spin": spin + dt * spin_rate, "spin_rate": spin_rate}
    for scheme in (s for name, s in SCHEMES.items() if name != "energy-momentum"):
        new = updated(INERTIA, state, position, rotation, dt, scheme)
        for name, wanted in expected.items():
            np.testing.assert_allclose(getattr(new, name), wanted, atol=1e-13)
        assert (new.algorithmic is None) == (not scheme.auxiliary)


@every_scheme
def test_residual_is_the_inertia_force_and_moment(scheme):
    state = committed(rates=2.0)
    position, rotation = trial(state, 0.5)
    residual, _ = inertia_residual(MASS, INERTIA, state, position, rotation, 0.1, scheme)
    new = updated(INERTIA, state, position, rotation, 0.1, scheme)
    # the moment from spatial quantities: I α + ω × I ω with I = R J R^T
    spatial, omega, alpha = rotation @ INERTIA @ rotation.T, rotation @ new.spin, rotation @ new.spin_rate
    np.testing.assert_allclose(residual[:3], MASS * new.acceleration, rtol=1e-14)
    np.testing.assert_allclose(residual[3:], spatial @ alpha + np.cross(omega, spatial @ omega), rtol=1e-12)


def test_energy_momentum_turns_by_the_mean_spin_and_gains_the_mean_moment():
    state, dt = committed(rates=2.0), 0.1
    position, rotation = trial(state, 0.5)
    new = updated(INERTIA, state, position, rotation, dt, SCHEMES["energy-momentum"])
    np.testing.assert_allclose(state.rotation @ cayley(dt / 2 * (state.spin + new.spin)), rotation, atol=1e-14)
    gain = rotation @ INERTIA @ new.spin - state.rotation @ INERTIA @ state.spin
    mean = momentum_rate(INERTIA, state) / 2 + momentum_rate(INERTIA, new) / 2
    np.testing.assert_allclose(gain, dt * mean, rtol=1e-12)


@every_scheme
def test_nothing_is_written_into_the_committed_state(scheme):
    state, copy = committed(), committed()
    inertia_residual(MASS, INERTIA, state, *trial(state, 0.5), 0.1, scheme)
    for field in fields(state):
        assert np.array_equal(getattr(state, field.name), getattr(copy, field.name))


def test_turn_of_a_step_counts_what_the_spin_after_it_would_make():
    state = replace(committed(), spin=np.array([0.0, 0.0, 40.0]))
    pose = trial(state, 0.5)
    assert rotation_angle(INERTIA, state, *pose, 0.1, Scheme(inertia=False)) == pytest.approx(0.5)
    assert rotation_angle(INERTIA, state, *pose, 0.1, NEWMARK) > 3.0       # 2 Θ/Δt - W_n after
    assert rotation_angle(INERTIA, replace(state, spin=np.zeros(3)), *pose, 0.1, NEWMARK) == pytest.approx(1.0)


def test_free_spin_rate_needs_no_moment_but_that_of_the_guides():
    rotation, spin = exp_so3([0.3, -0.8, 0.2]), np.array([1.0, -2.0, 0.5])

    def moment(free):
        rate = free_spin_rate(INERTIA, rotation, spin, np.array(free))
        state = BodyState(np.zeros(3), rotation, np.zeros(3), np.zeros(3), spin, rate)
        return momentum_rate(INERTIA, state), rotation @ rate

    assert np.abs(moment([True] * 3)[0]).max() < 1e-14
    needed, rate = moment([True, False, True])
    assert np.abs(needed[[0, 2]]).max() < 1e-14 < 0.1 < abs(needed[1]) and abs(rate[1]) < 1e-14
    assert not moment([False] * 3)[1].any()
