"""Contact force and tangent against finite differences: stick, slip and μ = 0 on face, edge and vertex.

Seen from inside, where gaps are negative, the closest feature is an edge or a vertex where the body is
re-entrant. The body is a cube of 2 m without its octant x, y, z > 0: three re-entrant edges that meet in a
re-entrant vertex. Curved faces are those of a torus, a curved edge that of a shaft with a shoulder. Slope tests:
with an exact tangent the remainder of a step h falls as h², with a broken one as h.
"""

import itertools

import numpy as np
import pytest
from smooth_shapes import revolved, torus

from hybrid.body.attitude import exp_so3
from hybrid.body.closest import closest
from hybrid.body.surface import build_surface
from hybrid.contact import assembly, soil_to_body
from hybrid.contact.corners import Corners

SHIFT = np.array([0.2, 0.1, -0.3])  # of the notch from the body's centre
INSIDE = {  # places from the notch whose closest feature is that of the name
    "face": [(-0.5, -0.4, 0.97), (-0.03, -0.6, 0.98), (-0.7, 0.96, -0.5), (0.99, -0.4, -0.5)],
    "edge": [(-0.02, -0.03, 0.4), (-0.01, 0.7, -0.02), (0.3, -0.02, -0.02)],
    "vertex": [(-0.02, -0.03, -0.01), (-0.01, -0.01, -0.02)],
    # of the torus, 1 m about its centre line of 0.4 m: outer side, inner side, top
    "curved": [(1.36, 0.1, 0.1), (-0.2, 1.32, -0.13), (-0.5, -0.38, 0.05), (0.1, 0.95, 0.385), (0.73, 0.74, -0.37)],
    # about the circle of radius 0.5 m at z = 0
    "shoulder": [(0.46, 0.15, -0.02), (-0.3, 0.37, -0.03), (0.02, -0.46, -0.01)],
}
KIND = {"face": (0,), "edge": (1, 2, 3), "vertex": (4, 5, 6), "curved": (0,), "shoulder": (1, 2, 3)}
SHAFT = [(0.0, -1.0), (1.0, -1.0), (1.0, 0.0), (0.5, 0.0), (0.5, 1.0), (0.0, 1.0)]
RATIO = 0.5
CENTRE, ROTATION = np.array([0.3, -0.2, 0.5]), exp_so3(np.array([0.4, -0.7, 0.2]))
LAWS = {"frictionless": 0.0, "slip": 0.01, "stick": 50.0}


def notched_cube():
    """ContactSurface of [-1, 1]³ without the octant x, y, z > 0, two triangles per square of 1 m."""
    filled = set(itertools.product((-1, 0), repeat=3)) - {(0, 0, 0)}
    index, triangles = {}, []
    for cell in filled:
        for axis, side in itertools.product(range(3), (0, 1)):
            beyond = tuple(c + (2 * side - 1) * (a == axis) for a, c in enumerate(cell))
            if beyond in filled:
                continue
            square = []
            for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)):
                corner = list(cell)
                corner[axis] += side
                corner[(axis + 1) % 3] += u
                corner[(axis + 2) % 3] += v
                square.append(index.setdefault(tuple(corner), len(index)))
            square = square if side else square[::-1]
            triangles += [(square[0], square[1], square[2]), (square[0], square[2], square[3])]
    return build_surface(SHIFT + np.array(list(index)), np.array(triangles))


def shifted(vertices, triangles, normals):
    return build_surface(SHIFT + vertices, triangles, normals)


NOTCH = notched_cube()
SURFACE = {"face": NOTCH, "edge": NOTCH, "vertex": NOTCH, "curved": shifted(*torus(1)),
           "shoulder": shifted(*revolved(SHAFT, 12))}


def corners_at(feature, seed=4, places=None):
    """Corners at the places of a feature, or those given, with anchors some millimetres away in all directions."""
    y = SHIFT + (INSIDE[feature] if places is None else places)
    m, rng = len(y), np.random.default_rng(seed)
    anchor = y + 0.004 * rng.standard_normal((m, 3))
    place = CENTRE + y @ ROTATION.T
    return Corners(np.arange(m), np.zeros(m, np.int64), place, y, np.zeros((m, 8), np.int64), np.full((m, 8), 0.125),
                   1e5 * (1 + np.arange(m)), np.ones(m, bool), anchor, np.zeros((m, 3)), np.zeros(m),
                   np.zeros(m))


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


def tangent(contact):
    """Derivative of `residual` from D, Q and K_ww, and the block ∂(body residual)/∂x_c as it enters K_wu."""
    ww, Q = assembly.body_tangent(contact)
    m = len(contact)
    K = np.zeros((3 * m + 6, 3 * m + 6))
    for n in range(m):
        own = slice(3 * n, 3 * n + 3)
        K[own, own] = contact.tangent[n]
        K[own, -6:] = Q[n]
        arm, force = assembly.skew(contact.arm[n:n + 1])[0], assembly.skew(contact.force[n:n + 1])[0]
        K[-6:-3, own] = -contact.tangent[n]
        K[-3:, own] = force - arm @ contact.tangent[n]
    K[-6:, -6:] = ww
    return K


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
    K[-3:, -3:] -= np.einsum("nij,njk->ik", assembly.skew(contact.arm), assembly.skew(contact.force))
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
