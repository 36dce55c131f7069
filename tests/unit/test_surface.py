"""Closest point, gap, sign and normal of a contact surface, against brute force and closed forms."""

import math

import numpy as np
import pytest
from numba import njit

from hybrid.body.closest import closest, gap_geometry
from hybrid.body.facet_tree import SECOND, search
from hybrid.body.surface import build_surface
from hybrid.runtime.errors import GeometryError

# ---------------------------------------------------------------- shapes


def voxels(cells, size=1.0):
    """Boundary of a union of unit cubes: faces that no two cubes share, two triangles each."""
    cells = {tuple(c) for c in cells}
    number, triangles = {}, []
    for cell in sorted(cells):
        for axis in range(3):
            for side in (0, 1):
                beyond = list(cell)
                beyond[axis] += 2 * side - 1
                if tuple(beyond) in cells:
                    continue
                quad = []
                for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)) if side else ((0, 0), (0, 1), (1, 1), (1, 0)):
                    corner = list(cell)
                    corner[axis] += side
                    corner[(axis + 1) % 3] += a
                    corner[(axis + 2) % 3] += b
                    quad.append(number.setdefault(tuple(corner), len(number)))
                triangles += [(quad[0], quad[1], quad[2]), (quad[0], quad[2], quad[3])]
    return size * np.array(list(number), dtype=float), np.array(triangles)


def box(n=1):
    vertices, triangles = voxels(np.ndindex(n, n, n), 1.0 / n)
    return vertices - 0.5, triangles


def ell(n=1):
    cells = [c for c in np.ndindex(2 * n, 2 * n, n) if not (c[0] >= n and c[1] >= n)]
    return voxels(cells, 1.0 / n)


def sphere(levels, radius=0.7):
    """Octahedron whose edges are halved `levels` times and pushed out to the sphere."""
    vertices = [s * e for e in np.eye(3) for s in (1, -1)]
    triangles = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    for _ in range(levels):
        middle, finer = {}, []
        for t in triangles:
            m = []
            for a, b in ((t[0], t[1]), (t[1], t[2]), (t[2], t[0])):
                key = (min(a, b), max(a, b))
                if key not in middle:
                    p = vertices[a] + vertices[b]
                    middle[key] = len(vertices)
                    vertices.append(p / np.linalg.norm(p))
                m.append(middle[key])
            finer += [(t[0], m[0], m[2]), (m[0], t[1], m[1]), (m[2], m[1], t[2]), tuple(m)]
        triangles = finer
    return radius * np.array(vertices), np.array(triangles)


def spike():
    """Needle-like tetrahedron: at its tip the nearest face often shows its back to a point outside."""
    vertices = np.array([[0.0, 0.0, 3.0], [0.3, 0.0, 0.0], [-0.2, 0.25, 0.0], [-0.2, -0.3, 0.0]])
    return vertices, np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])


SHAPES = {"box": box(), "fine box": box(4), "sphere": sphere(2), "L": ell(), "fine L": ell(3),
          "spike": spike()}


def points_around(surface, count=1500, seed=0):
    rng = np.random.default_rng(seed)
    size = surface.upper - surface.lower
    return rng.uniform(surface.lower - 0.4 * size, surface.upper + 0.4 * size, size=(count, 3))


# ---------------------------------------------------------------- brute force


def brute_distance(y, vertices, triangles):
    """Distance by the closest point on every plane that falls inside its triangle, and on every segment."""
    v = vertices[triangles]
    best = np.inf
    for k in range(3):
        a, b = v[:, k], v[:, (k + 1) % 3]
        s = np.clip(((y - a) * (b - a)).sum(1) / ((b - a) ** 2).sum(1), 0, 1)
        best = min(best, np.linalg.norm(a + s[:, None] * (b - a) - y, axis=1).min())
    n = np.cross(v[:, 1] - v[:, 0], v[:, 2] - v[:, 0])
    n /= np.linalg.norm(n, axis=1)[:, None]
    height = ((y - v[:, 0]) * n).sum(1)
    closest_point = y - height[:, None] * n
    left = [(np.cross(v[:, (k + 1) % 3] - v[:, k], closest_point - v[:, k]) * n).sum(1) >= 0 for k in range(3)]
    inside = np.all(left, axis=0)
    return min(best, np.abs(height[inside]).min()) if inside.any() else best


def is_inside(y, vertices, triangles):
    """Winding number from solid angles (van Oosterom and Strackee 1983)."""
    a, b, c = np.moveaxis(vertices[triangles] - y, 1, 0)
    la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
    volume = (a * np.cross(b, c)).sum(1)
    rest = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
    return np.arctan2(volume, rest).sum() / (2 * math.pi) > 0.5


@pytest.mark.parametrize("shape", SHAPES)
def test_closest_point_and_sign_against_brute_force(shape):
    surface = build_surface(*SHAPES[shape])
    tree = surface.tree
    insides = 0
    for y in points_around(surface, 800):
        triangle, feature, closest_point, weights, gap = closest(y, np.inf, tree)
        corners = surface.vertices[surface.triangles[triangle]]
        assert abs(gap) == pytest.approx(brute_distance(y, *SHAPES[shape]), abs=1e-14)
        assert np.linalg.norm(y - closest_point) == pytest.approx(abs(gap), abs=1e-14)
        np.testing.assert_allclose(weights @ corners, closest_point, atol=1e-13)
        assert min(weights) > -1e-14 and sum(weights) == pytest.approx(1.0)
        inside = is_inside(y, *SHAPES[shape])
        assert (gap < 0) == inside
        insides += inside
    assert insides > 10


def test_the_normal_of_the_nearest_triangle_alone_gives_wrong_signs():
    """Why pseudo-normals are needed: the same check fails with the face's normal."""
    surface = build_surface(*spike())
    wrong = 0
    for y in points_around(surface, 800):
        triangle, _, closest_point, _, gap = closest(y, np.inf, surface.tree)
        wrong += (surface.normals[triangle] @ (y - closest_point) < 0) != (gap < 0)
    assert wrong > 20


@pytest.mark.parametrize("shape", SHAPES)
def test_reach_limits_the_search(shape):
    surface = build_surface(*SHAPES[shape])
    for y in points_around(surface, 200):
        full = closest(y, np.inf, surface.tree)
        distance = abs(full[4])
        assert closest(y, 1.001 * distance, surface.tree) == full
        assert closest(y, 0.999 * distance, surface.tree)[0] == -1
    assert closest(np.full(3, np.nan), np.inf, surface.tree)[0] == -1


# ---------------------------------------------------------------- features and derivatives


@njit
def query(y, tree):
    """As a contact kernel calls it."""
    triangle, feature, closest_point, weights, gap = closest(y, np.inf, tree)
    return triangle, feature, closest_point, gap, gap_geometry(y, closest_point, weights, gap, triangle, feature, tree)


def geometry(y, tree):
    """Triangle, feature, closest point y_s, gap, N and A = ∂(y - y_s)/∂y = N N^T + g ∂N/∂y, N the gradient of the gap."""
    triangle, feature, closest_point, gap, (N, gradient, G) = query(y, tree)
    assert gradient == N
    return triangle, feature, closest_point, gap, N, np.outer(N, N) + gap * np.array(G)


def box_geometry(y):
    """N and A outside a unit cube about the origin: what is not beyond a face slides freely."""
    beyond = np.abs(y) > 0.5
    x = np.where(beyond, y - np.clip(y, -0.5, 0.5), 0.0)
    return x / np.linalg.norm(x), np.diag(beyond.astype(float)), beyond.sum()


@pytest.mark.parametrize("n", [1, 4])
@pytest.mark.parametrize("lattice", [False, True])
def test_features_of_a_box(n, lattice):
    """However the box is cut into triangles, also for points exactly above their edges and vertices."""
    surface = build_surface(*box(n))
    points = points_around(surface, 1500)
    if lattice:
        axis = np.arange(-7, 8) / 8
        points = np.stack(np.meshgrid(axis, axis, axis), -1).reshape(-1, 3)
    seen = np.zeros(4, int)
    for y in points[(np.abs(points) > 0.5).any(axis=1)]:
        _, feature, _, _, N, A = geometry(y, surface.tree)
        normal, slide, beyond = box_geometry(y)
        np.testing.assert_allclose(N, normal, atol=1e-13)
        # exactly above the rim of a face or the end of an edge the derivative differs from side to side
        if not (np.abs(y) == 0.5).any():
            np.testing.assert_allclose(A, slide, atol=1e-13)
            assert (feature == 0) == (beyond == 1)
            assert n > 1 or (feature > 3) == (beyond == 3)
        seen[beyond] += 1
    assert (seen[1:] > 20).all()


@pytest.mark.parametrize("shape", SHAPES)
def test_gap_geometry_by_differences(shape):
    surface = build_surface(*SHAPES[shape])
    normals, h, checked = surface.tree.normals, 1e-6, np.zeros((3, 2), int)
    points = points_around(surface, 1500, seed=7)
    if "L" in shape:
        points[:100, :2] = 1 - 0.2 * np.random.default_rng(3).random((100, 2))     # about the re-entrant edge
    for y in points:
        triangle, feature, _, gap, N, A = geometry(y, surface.tree)
        sides = [[query(y + s * h * e, surface.tree) for s in (1, -1)] for e in np.eye(3)]
        same = [np.allclose(normals[q[0], q[1]], normals[triangle, feature]) for pair in sides for q in pair]
        if abs(gap) < 1e-2 or not all(same):
            continue
        fd_foot = np.array([np.subtract(plus[2], minus[2]) / (2 * h) for plus, minus in sides]).T
        fd_gap = np.array([(plus[3] - minus[3]) / (2 * h) for plus, minus in sides])
        np.testing.assert_allclose(A, np.eye(3) - fd_foot, atol=1e-8)
        np.testing.assert_allclose(N, fd_gap, atol=1e-7)
        checked[(feature + 2) // 3, int(gap < 0)] += 1
    assert (checked[:, 0] > 20).all()                       # faces, edges and vertices from outside
    assert checked[0, 1] > 20                               # faces from inside
    assert checked[1, 1] > 20 or shape not in ("L", "fine L")   # the re-entrant edge from inside


def test_edges_between_coplanar_triangles_have_the_face_normal():
    surface = build_surface(*box())
    ends = surface.vertices[surface.triangles]
    diagonal = np.linalg.norm(np.roll(ends, -1, axis=1) - ends, axis=2) > 1.2
    assert diagonal.sum() == 12
    for t, k in zip(*np.nonzero(diagonal)):
        np.testing.assert_allclose(surface.tree.normals[t, 1 + k], surface.normals[t], atol=1e-15)
        middle = 0.5 * (ends[t, k] + ends[t, (k + 1) % 3])
        for y in (middle + 0.1 * surface.normals[t], middle - 0.1 * surface.normals[t], middle):
            _, feature, closest_point, gap, N, A = geometry(y, surface.tree)
            assert feature == 0
            np.testing.assert_allclose(N, surface.normals[t], atol=1e-15)
            np.testing.assert_allclose(A, np.outer(N, N), atol=1e-15)
            np.testing.assert_allclose(closest_point, middle, atol=1e-15)


def test_vertex_along_a_straight_edge_slides_along_it():
    surface = build_surface(*box(2))
    corners, tree = surface.vertices[surface.triangles], surface.tree
    outer = np.abs(corners) == 0.5
    for t, k in np.ndindex(len(corners), 3):
        along = np.where(outer[t, k], 0.0, 1.0) if outer[t, k].sum() == 2 else np.zeros(3)
        np.testing.assert_allclose(np.abs(tree.normals[t, SECOND + 4 + k]), along, atol=1e-15)
        assert (tree.kind[t, 4 + k] == 0) == (outer[t, k].sum() == 1)

    _, feature, _, gap, N, A = geometry(np.array([0.0, 0.8, 0.9]), tree)     # above the middle of an edge
    assert feature > 0 and gap == pytest.approx(0.5)
    np.testing.assert_allclose(A, np.diag([0.0, 1.0, 1.0]), atol=1e-15)
    np.testing.assert_allclose(N, [0.0, 0.6, 0.8], atol=1e-15)


def test_pseudo_normals_of_a_cube_do_not_depend_on_its_diagonals():
    surface = build_surface(*box())
    corners = surface.vertices[surface.triangles]
    np.testing.assert_allclose(surface.tree.normals[:, 4:7], 2 * corners / math.sqrt(3), atol=1e-14)


def test_on_a_corner_the_normal_is_the_pseudo_normal():
    _, feature, _, gap, N, A = geometry(np.full(3, 0.5), build_surface(*box()).tree)
    assert feature > 3 and gap == 0.0
    np.testing.assert_allclose(N, np.full(3, 1 / math.sqrt(3)), atol=1e-15)
    np.testing.assert_allclose(A, np.outer(N, N), atol=1e-15)       # without distance no part of N turns


def test_of_equally_near_triangles_the_first_is_taken():
    vertices, triangles = box()
    for order in (np.arange(len(triangles)), np.random.default_rng(2).permutation(len(triangles))):
        surface = build_surface(vertices, triangles[order])
        assert closest(np.zeros(3), np.inf, surface.tree)[0] == 0


def test_open_surface():
    """Half a box: the cut at y = 0 is missing, and its rim takes the normal of the face that is there."""
    vertices, triangles = box(2)
    across = vertices[triangles][:, :, 1]
    keep = across.min(axis=1) >= 0.0
    surface = build_surface(vertices, triangles[keep])
    assert len(surface.vertices) < len(vertices) and surface.lower[1] == 0.0
    for y, gap in (([0.1, 0.1, 0.4], -0.1), ([0.1, 0.0, 0.4], -0.1), ([0.1, 0.0, 0.7], 0.2)):
        assert closest(np.array(y), np.inf, surface.tree)[4] == pytest.approx(gap)
    # beyond the cut the rim is nearest, with the sign of its face
    assert closest(np.array([0.1, -0.3, 0.1]), np.inf, surface.tree)[4] == pytest.approx(-0.5)
    assert closest(np.array([0.1, -0.3, 0.9]), np.inf, surface.tree)[4] == pytest.approx(0.5)


# ---------------------------------------------------------------- cost and refusals


def triangles_visited(levels):
    surface = build_surface(*sphere(levels, 1.0))
    tree, rng = surface.tree, np.random.default_rng(1)
    y = rng.normal(size=(1000, 3))
    y *= rng.uniform(0.95, 1.05, size=(1000, 1)) / np.linalg.norm(y, axis=1)[:, None]
    visited = [search(*p, np.inf, tree)[-1] for p in y]
    return np.mean(visited), len(surface.triangles)


def test_cost_of_a_query_grows_far_slower_than_the_number_of_triangles():
    few, small = triangles_visited(2)
    many, large = triangles_visited(5)
    assert large == 64 * small
    assert many < 3 * few and many < 20


def test_unused_vertices_are_dropped():
    vertices, triangles = box()
    surface = build_surface(np.vstack((np.full((2, 3), 9.0), vertices)), triangles + 2)
    assert len(surface.vertices) == 8
    np.testing.assert_array_equal(surface.upper, [0.5, 0.5, 0.5])
    np.testing.assert_array_equal(surface.vertices[surface.triangles], vertices[triangles])


def test_surfaces_without_an_inside_are_refused():
    vertices, triangles = box()
    flat = np.vstack((triangles, [[0, 1, 1]]))
    sliver = np.vstack((vertices, 0.5 * (vertices[0] + vertices[1])))
    twice = np.vstack((triangles, triangles[:1]))
    turned = triangles.copy()
    turned[0] = turned[0, ::-1]
    nan = vertices.copy()
    nan[3, 1] = np.nan
    for given, match in [
        ((vertices, flat), "1 triangle.*without area, first number 12.*limit"),
        ((sliver, np.vstack((triangles, [[0, 1, 8]]))), "without area"),
        ((vertices, twice), "belongs to 3 triangles, the limit is 2"),
        ((vertices, turned), "oriented against each other"),
        ((vertices, triangles[:0]), 'physical group "contact"'),
        ((nan, triangles), "finite"),
        ((vertices, triangles + 1), "numbers run from 1 to 8"),
        ((vertices, np.array([[0, 1, 2], [0, 2, 1]])), "no thickness"),
    ]:
        with pytest.raises(GeometryError, match=match):
            build_surface(*given)
