"""Contact force and tangent against finite differences: stick, slip and μ = 0 on face, edge and vertex.

Slope tests: with an exact tangent the remainder of a step h falls as h², with a broken one as h.
"""

import itertools

import numpy as np
import pytest
from contact_features import CENTRE, INSIDE, KIND, RATIO, ROTATION, SHIFT, SURFACE, corners_at, tangent
from smooth_shapes import torus

from hybrid.body.attitude import exp_so3, skews
from hybrid.body.closest import closest
from hybrid.contact import assembly, soil_to_body

LAWS = {"frictionless": 0.0, "slip": 0.01, "stick": 50.0}


def contact_at(corners, feature, law, place=None, pose=(CENTRE, ROTATION)):
    place = corners.position if place is None else place
    return soil_to_body.evaluate(corners, place, *pose, SURFACE[feature], LAWS[law], RATIO)


def test_places_have_the_features_they_are_named_after():
    for feature, places in INSIDE.items():
        for y in places:
            _, found, _, _, gap = closest(SHIFT + y, np.inf, SURFACE[feature].tree)
            assert found in KIND[feature] and gap < 0.0


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("feature", INSIDE)
def test_law_is_in_the_state_it_is_named_after(feature, law):
    contact = contact_at(corners_at(feature), feature, law)
    assert len(contact) == len(INSIDE[feature])
    assert (contact.slip == (law == "slip")).all()


# ------------------------------------------------------------ the whole tangent: corners and body together


def residual(corners, feature, law, step):
    """Forces on corners and the body's residual after a step (3 m + 6,) of places, centre and rotation."""
    place = corners.position + step[:-6].reshape(-1, 3)
    pose = CENTRE + step[-6:-3], exp_so3(step[-3:]) @ ROTATION
    contact = contact_at(corners, feature, law, place, pose)
    assert len(contact) == len(corners)
    return np.concatenate([contact.force.ravel(), assembly.add_residual(contact, corners, None)])


def observed_rate(feature, law, spoil=lambda K, contact: K, seed=7, rotation_only=False):
    corners = corners_at(feature)
    zero = np.zeros(3 * len(corners) + 6)
    direction = np.random.default_rng(seed).standard_normal(len(zero))
    if rotation_only:
        direction[:-3] = 0.0
    contact = contact_at(corners, feature, law)
    base, slope = residual(corners, feature, law, zero), spoil(tangent(contact), contact) @ direction
    sizes = 4e-5 / 2.0 ** np.arange(4)
    remainders = [np.linalg.norm(residual(corners, feature, law, h * direction) - base - h * slope) for h in sizes]
    return np.polyfit(np.log(sizes), np.log(remainders), 1)[0]


@pytest.mark.parametrize("rotation_only", [False, True])
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("feature", INSIDE)
def test_remainder_is_second_order(feature, law, rotation_only):
    assert observed_rate(feature, law, rotation_only=rotation_only) == pytest.approx(2.0, abs=0.02)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("feature", INSIDE)
def test_tangent_equals_central_differences(feature, law):
    assert tangent_error(corners_at(feature), feature, law) < 1e-7


def tangent_error(corners, feature, law):
    exact, h = tangent(contact_at(corners, feature, law)), 1e-6
    columns = [residual(corners, feature, law, h * e) - residual(corners, feature, law, -h * e)
               for e in np.eye(len(exact))]
    return np.abs(np.array(columns).T / (2 * h) - exact).max() / np.abs(exact).max()


@pytest.mark.parametrize("law", LAWS)
def test_tangent_equals_central_differences_beside_the_edges_of_patches(law):
    """On both sides of edges between patches, where a corner passes from triangle to triangle."""
    vertices, triangles, normals = torus(1)
    surface, chosen = SURFACE["curved"], np.random.default_rng(1).integers(0, len(triangles), 10)
    ends, n = vertices[triangles[chosen, :2]], normals[chosen, 0] + normals[chosen, 1]
    n /= np.linalg.norm(n, axis=1)[:, None]
    deep = ends.mean(axis=1) - 0.25 * surface.tree.patches.nodes[chosen, 6] - 0.03 * n      # y = x - g N
    across = 1e-4 * np.cross(ends[:, 1] - ends[:, 0], n)
    sides = [deep - across, deep + across]
    assert tangent_error(corners_at("curved", places=np.concatenate(sides)), "curved", law) < 1e-7
    one, other = ([closest(SHIFT + y, np.inf, surface.tree)[0] for y in side] for side in sides)
    assert np.not_equal(one, other).all()


@pytest.mark.parametrize("feature, law", [*((f, "frictionless") for f in INSIDE if f != "curved"), ("face", "stick")])
def test_force_is_the_gradient_of_the_stored_energy(feature, law):
    """Where the normal turns, the tangential part of the law has no potential; on a curved face the normal part has one
    up to the difference between N and the gradient of the gap."""
    corners = corners_at(feature)
    contact, h = contact_at(corners, feature, law), 1e-6
    for n, i in itertools.product(range(len(corners)), range(3)):
        shift = np.zeros((len(corners), 3))
        shift[n, i] = h
        there, back = (contact_at(corners, feature, law, corners.position + s * shift).energy for s in (1, -1))
        slope, scale = (there - back) / (2 * h), np.abs(contact.force).max()
        assert slope == pytest.approx(contact.force[n, i], rel=1e-6, abs=1e-6 * scale)


# ------------------------------------------------------------ broken variants must be noticed


def without_turning_normal(K, contact):
    """D of a face everywhere, as if N did not turn at edges and vertices."""
    K = K.copy()
    for n in range(len(contact)):
        N = contact.force[n] / np.linalg.norm(contact.force[n])
        stiffness = np.linalg.norm(contact.force[n]) / -contact.gap[n]
        K[3 * n:3 * n + 3, 3 * n:3 * n + 3] = stiffness * np.outer(N, N)
    return K


def symmetric(K, contact):
    """Without the -μ ε s N^T that makes slip unsymmetric."""
    m = 3 * len(contact)
    K = K.copy()
    K[:m, :m] = 0.5 * (K[:m, :m] + K[:m, :m].T)
    return K


def without_turning_force(K, contact):
    """Without the terms of a force that turns with the body."""
    K = K.copy()
    K[-3:, -3:] -= np.einsum("nij,njk->ik", skews(contact.arm), skews(contact.force))
    return K


@pytest.mark.parametrize("feature, law, spoil", [
    ("edge", "frictionless", without_turning_normal),
    ("vertex", "frictionless", without_turning_normal),
    ("curved", "frictionless", without_turning_normal),
    ("curved", "stick", without_turning_normal),
    ("face", "slip", symmetric),
    ("edge", "slip", symmetric),
    ("face", "stick", without_turning_force),
    ("vertex", "slip", without_turning_force),
])
def test_slope_test_fails_on_a_broken_tangent(feature, law, spoil):
    assert observed_rate(feature, law, spoil, rotation_only=spoil is without_turning_force) < 1.3


def test_without_turning_normal_is_right_on_a_face():
    """The broken variant spoils the named term and nothing else."""
    assert observed_rate("face", "frictionless", without_turning_normal) == pytest.approx(2.0, abs=0.01)
