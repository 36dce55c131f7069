"""Inertia residual of a body: exact tangent, limits, and what Newmark's rule integrates exactly."""

import numpy as np
import pytest

from hybrid.body.attitude import exp_so3, skew
from hybrid.body.motion import inertia_residual, updated
from hybrid.state import BodyState

MASS = 7.0
INERTIA = np.array([[2.0, 0.3, -0.2], [0.3, 3.1, 0.4], [-0.2, 0.4, 1.4]])
SCHEMES = [(0.25, 0.5), (0.5625, 1.0)]


def committed(seed=3, rates=1.0):
    rng = np.random.default_rng(seed)
    vectors = rng.normal(size=(5, 3))
    return BodyState(vectors[0], exp_so3([0.4, -1.1, 0.7]), *(rates * vectors[1:]))


def trial(state, angle, seed=5):
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=3)
    turn = angle * axis / np.linalg.norm(axis)
    return state.position + 0.02 * rng.normal(size=3), state.rotation @ exp_so3(turn)


def moved(position, rotation, step):
    return position + step[:3], exp_so3(step[3:]) @ rotation


def difference_tangent(function, position, rotation, h):
    columns = []
    for e in np.eye(6):
        plus, minus = (function(*moved(position, rotation, s * h * e)) for s in (1, -1))
        columns.append((plus - minus) / (2 * h))
    return np.array(columns).T


@pytest.mark.parametrize("beta, gamma", SCHEMES)
@pytest.mark.parametrize("angle", [0.0, 1e-10, 1e-4, 0.29, 0.5, 2.0])
@pytest.mark.parametrize("dt", [0.3, 0.01])
def test_tangent_equals_central_differences(angle, beta, gamma, dt):
    state = committed(rates=3.0)
    position, rotation = trial(state, angle)
    args = (dt, beta, gamma)
    tangent = inertia_residual(MASS, INERTIA, state, position, rotation, *args)[1]
    fd = difference_tangent(
        lambda c, r: inertia_residual(MASS, INERTIA, state, c, r, *args)[0], position, rotation, 1e-5)
    for rows in (slice(0, 3), slice(3, 6)):   # force and moment on their own scales
        assert np.abs(tangent - fd)[rows].max() < 1e-8 * np.abs(fd[rows]).max()


def taylor_slope(tangent_of, angle=0.5, dt=0.05):
    state = committed(rates=3.0)
    position, rotation = trial(state, angle)
    residual, tangent = tangent_of(state, position, rotation, dt)
    direction = np.random.default_rng(8).normal(size=6)
    steps = 0.2 * 0.5 ** np.arange(6)
    remainders = []
    for h in steps:
        there = moved(position, rotation, h * direction)
        there = inertia_residual(MASS, INERTIA, state, *there, dt, 0.25, 0.5)[0]
        remainders.append(np.linalg.norm(there - residual - h * tangent @ direction))
    return np.polyfit(np.log(steps[2:]), np.log(remainders[2:]), 1)[0]


def test_taylor_remainder_is_second_order():
    assert taylor_slope(lambda *a: inertia_residual(MASS, INERTIA, *a, 0.25, 0.5)) > 1.95


def test_taylor_test_notices_a_missing_moment_term():
    def broken(*a):
        residual, tangent = inertia_residual(MASS, INERTIA, *a, 0.25, 0.5)
        tangent[3:, 3:] += skew(residual[3:])
        return residual, tangent

    assert taylor_slope(broken) < 1.3


def test_rates_follow_newmark():
    """Constant acceleration about a fixed axis is integrated exactly, with any scheme."""
    dt, axis = 0.4, np.array([0.0, 0.6, 0.8])
    spin, spin_rate = 0.7 * axis, 0.3 * axis
    velocity, acceleration = np.array([1.0, 2.0, -1.0]), np.array([0.0, 0.5, -9.81])
    state = BodyState(np.ones(3), exp_so3([0.1, 0.2, 0.3]), velocity, acceleration, spin, spin_rate)
    position = state.position + dt * velocity + dt**2 / 2 * acceleration
    rotation = state.rotation @ exp_so3(dt * spin + dt**2 / 2 * spin_rate)
    expected = (velocity + dt * acceleration, acceleration, spin + dt * spin_rate, spin_rate)
    for beta, gamma in SCHEMES:
        for found, wanted in zip(updated(state, position, rotation, dt, beta, gamma), expected):
            np.testing.assert_allclose(found, wanted, atol=1e-13)


def test_residual_is_the_inertia_force_and_moment():
    state = committed(rates=2.0)
    position, rotation = trial(state, 0.5)
    residual, _ = inertia_residual(MASS, INERTIA, state, position, rotation, 0.1, 0.25, 0.5)
    _, acceleration, spin, spin_rate = updated(state, position, rotation, 0.1, 0.25, 0.5)
    # the moment from spatial quantities: I α + ω × I ω with I = R J R^T
    spatial, omega, alpha = rotation @ INERTIA @ rotation.T, rotation @ spin, rotation @ spin_rate
    np.testing.assert_allclose(residual[:3], MASS * acceleration, rtol=1e-14)
    np.testing.assert_allclose(residual[3:], spatial @ alpha + np.cross(omega, spatial @ omega), rtol=1e-12)


def test_nothing_is_written_into_the_committed_state():
    state, copy = committed(), committed()
    inertia_residual(MASS, INERTIA, state, *trial(state, 0.5), 0.1, 0.25, 0.5)
    for name in ("position", "rotation", "velocity", "acceleration", "spin", "spin_rate"):
        assert np.array_equal(getattr(state, name), getattr(copy, name))
