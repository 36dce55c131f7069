"""Rotations: the exponential map, its inverse near 0 and π, its tangent, and quaternions."""

import math

import numpy as np
import pytest
from scipy.linalg import expm

from hybrid.body.attitude import (
    cayley,
    cayley_rate,
    cayley_vector,
    exp_so3,
    log_so3,
    quaternion,
    right_tangent,
    rotation_from_axis_angle,
    skew,
)
from hybrid.runtime.errors import SceneError

ANGLES = [0.0, 1e-200, 1e-12, 1e-8, 1e-4, 0.1, 0.2999, 0.3001, 1.0, 2.5, math.pi - 1e-4, math.pi - 1e-9]


def unit_vectors(count=20, seed=1):
    v = np.random.default_rng(seed).normal(size=(count, 3))
    return v / np.linalg.norm(v, axis=1)[:, None]


def test_skew_is_the_cross_product():
    a, b = unit_vectors(2)
    np.testing.assert_allclose(skew(a) @ b, np.cross(a, b), atol=1e-16)


@pytest.mark.parametrize("angle", ANGLES)
def test_exponential_is_a_rotation_and_matches_the_matrix_exponential(angle):
    for axis in unit_vectors():
        r = exp_so3(angle * axis)
        np.testing.assert_allclose(r @ r.T, np.eye(3), atol=2e-15)
        np.testing.assert_allclose(r, expm(skew(angle * axis)), atol=5e-15)


@pytest.mark.parametrize("angle", ANGLES)
def test_logarithm_inverts_the_exponential(angle):
    for axis in unit_vectors():
        np.testing.assert_allclose(log_so3(exp_so3(angle * axis)), angle * axis, rtol=1e-13, atol=5e-15)


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0, -1, 0), (1, -2, 3)])
def test_logarithm_at_half_a_turn(axis):
    axis = np.array(axis) / np.linalg.norm(axis)
    r = 2.0 * np.outer(axis, axis) - np.eye(3)
    v = log_so3(r)
    assert np.linalg.norm(v) == pytest.approx(math.pi, abs=1e-14)
    np.testing.assert_allclose(exp_so3(v), r, atol=1e-14)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-3, 0.2999, 0.3001, 1.5, 3.0])
def test_right_tangent_is_the_derivative_of_the_exponential(angle):
    h = 1e-5
    for axis in unit_vectors(5):
        theta = angle * axis
        fd = np.empty((3, 3))
        for k, e in enumerate(np.eye(3)):
            plus, minus = (log_so3(exp_so3(theta).T @ exp_so3(theta + s * h * e)) for s in (1, -1))
            fd[:, k] = (plus - minus) / (2 * h)
        np.testing.assert_allclose(right_tangent(theta), fd, atol=1e-9)


@pytest.mark.parametrize("angle", ANGLES[:-2])
def test_cayley_map_turns_by_twice_the_arctangent_and_moves_by_the_mean(angle):
    for axis in unit_vectors():
        theta, size = 2 * math.tan(angle / 2) * axis, 1.0 + math.tan(angle / 2)
        turned = cayley(theta)
        np.testing.assert_allclose(turned, exp_so3(angle * axis), atol=2e-15 * size)
        np.testing.assert_allclose(cayley_vector(turned), theta, rtol=1e-13, atol=5e-15 * size)
        np.testing.assert_allclose(turned - np.eye(3), skew(theta) @ (turned + np.eye(3)) / 2, atol=2e-15 * size)


def test_cayley_vector_of_half_a_turn_is_long_but_finite():
    vector = cayley_vector(exp_so3([math.pi, 0.0, 0.0]))
    assert np.isfinite(vector).all() and np.linalg.norm(vector) > 1e8


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-3, 0.5, 1.5, 2.5])
def test_cayley_rate_is_the_derivative_of_the_inverse_map(angle):
    h = 1e-5
    for axis in unit_vectors(5):
        theta = 2 * math.tan(angle / 2) * axis
        fd = np.array([(cayley_vector(cayley(theta) @ exp_so3(h * e)) - cayley_vector(cayley(theta) @ exp_so3(-h * e)))
                       / (2 * h) for e in np.eye(3)]).T
        np.testing.assert_allclose(cayley_rate(theta), fd, rtol=1e-8, atol=1e-8)


def test_series_of_the_right_tangent_meets_the_closed_form():
    axis = np.array([0.6, 0.0, 0.8])
    below, above = (right_tangent(0.3 * s * axis) for s in (1 - 1e-14, 1 + 1e-14))
    np.testing.assert_allclose(below, above, atol=2e-14)


def test_quaternion_rotates_vectors_as_the_matrix_does():
    rng = np.random.default_rng(4)
    for axis in unit_vectors(50, 2):
        r = exp_so3(rng.uniform(0, math.pi) * axis)
        q = quaternion(r)
        w, v, a = q[0], q[1:], rng.normal(size=3)
        assert w >= 0 and np.linalg.norm(q) == pytest.approx(1.0, abs=1e-15)
        rotated = a + 2 * w * np.cross(v, a) + 2 * np.cross(v, np.cross(v, a))
        np.testing.assert_allclose(rotated, r @ a, atol=5e-15)


def test_axis_and_angle():
    quarter = rotation_from_axis_angle((0, 0, 5), math.pi / 2)
    np.testing.assert_allclose(quarter @ [1, 0, 0], [0, 1, 0], atol=1e-15)
    with pytest.raises(SceneError, match="no direction"):
        rotation_from_axis_angle((0, 0, 0), 1.0)
