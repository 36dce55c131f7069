"""The smooth surface behind a body's facets: gap and normal converge to the exact ones and are continuous."""

import numpy as np
import pytest
from numba import njit
from smooth_shapes import around, ellipsoid, merged, revolved, sphere, torus

from hybrid.body.closest import closest, gap_geometry
from hybrid.body.closest_on_patches import FIXED
from hybrid.body.facet_tree import SECOND
from hybrid.body.mesh import generate
from hybrid.body.smooth import corner_normals
from hybrid.body.surface import build_surface
from hybrid.contact.search import distances
from hybrid.runtime.data import GEOMETRY

SHAPES = {"sphere": sphere, "ellipsoid": ellipsoid, "torus": torus}


@njit
def query(y, tree):
    triangle, feature, closest_point, weights, gap = closest(y, np.inf, tree)
    geometry = gap_geometry(y, closest_point, weights, gap, triangle, feature, tree)
    return triangle, feature, closest_point, weights, gap, geometry


def gaps_and_normals(surface, places):
    found = [query(y, surface.tree) for y in places]
    return np.array([f[4] for f in found]), np.array([f[5][0] for f in found])


def rates(shape, smooth):
    """Observed orders of the errors (root mean square) of gap and normal in the size of the facets."""
    places, gap, normal = around(shape, 600, 0.05)
    errors = []
    for level in (1, 2, 3):
        vertices, triangles, normals = SHAPES[shape](level)
        g, N = gaps_and_normals(build_surface(vertices, triangles, normals if smooth else None), places)
        errors.append(np.sqrt([np.mean((g - gap) ** 2), np.mean(np.sum((N - normal) ** 2, axis=1))]))
    return np.log2(np.divide(errors[-2], errors[-1]))


# ---------------------------------------------------------------- convergence


@pytest.mark.parametrize("shape", SHAPES)
def test_gap_converges_with_third_order_and_normal_with_second(shape):
    gap, normal = rates(shape, smooth=True)
    assert gap > 2.9 and normal > 1.9


@pytest.mark.parametrize("shape", SHAPES)
def test_facets_alone_converge_with_second_order_and_their_normals_with_first(shape):
    """The broken variant."""
    gap, normal = rates(shape, smooth=False)
    assert gap == pytest.approx(2.0, abs=0.25) and normal == pytest.approx(1.0, abs=0.25)


# ---------------------------------------------------------------- continuity and derivatives


@pytest.mark.parametrize("shape", SHAPES)
def test_gap_and_normal_are_continuous_across_edges(shape):
    """On paths through the neighbourhood of the surface no jump is larger than the step allows."""
    assert (steepest(build_surface(*SHAPES[shape](2)), shape) < (1.1, 4.0)).all()


def steepest(surface, shape):
    """Largest slopes of gap and normal on straight paths through the neighbourhood of a shape."""
    places, _, normal = around(shape, 12, 0.05)
    crossed, steep_gap, steep_normal = 0, 0.0, 0.0
    for y, n, along in zip(places, normal, np.random.default_rng(3).normal(size=(12, 3))):
        along -= (along @ n) * n
        step = 1e-4
        found = [query(y + s * along / np.linalg.norm(along), surface.tree) for s in np.arange(-0.15, 0.15, step)]
        crossed += len({f[0] for f in found}) - 1
        gap, N = np.array([f[4] for f in found]), np.array([f[5][0] for f in found])
        steep_gap = max(steep_gap, np.abs(np.diff(gap)).max() / step)
        steep_normal = max(steep_normal, np.linalg.norm(np.diff(N, axis=0), axis=1).max() / step)
    assert crossed > 10
    return np.array([steep_gap, steep_normal])


@pytest.mark.parametrize("level, largest, mean", [(1, 6e-3, 1e-3), (2, 2e-3, 2e-4)])
def test_gaps_about_a_centre_of_curvature(level, largest, mean):
    """About the centre line of a torus, where projections fail: the gap is that to the nearest patch that has one. Facets in
    place of it are four times as far off, 1.7e-2 and 4.3e-3, and the gap jumps by as much."""
    surface, rng = build_surface(*torus(level)), np.random.default_rng(1)
    angle, off = rng.uniform(0.0, 2 * np.pi, 400), rng.normal(size=(400, 3))
    off *= (rng.uniform(0.0, 0.06, 400) / np.linalg.norm(off, axis=1))[:, None]
    y = np.stack([np.cos(angle), np.sin(angle), np.zeros(400)], axis=1) + off
    exact = np.hypot(np.hypot(y[:, 0], y[:, 1]) - 1.0, y[:, 2]) - 0.4
    found = [closest(tuple(place), np.inf, surface.tree) for place in y]
    error = np.abs([gap for *_, gap in found] - exact)
    assert error.max() < largest and error.mean() < mean
    assert np.count_nonzero([feature == FIXED for _, feature, *_ in found]) > 20
    for place, (triangle, feature, closest_point, weights, gap) in zip(y, found):
        N, _, _ = gap_geometry(place, closest_point, weights, gap, triangle, feature, surface.tree)
        np.testing.assert_allclose(closest_point + gap * np.array(N), place, atol=1e-9)


@pytest.mark.parametrize("shape", SHAPES)
def test_facets_alone_are_not_continuous(shape):
    """The broken variant: from facet to facet the normal jumps."""
    assert steepest(build_surface(*SHAPES[shape](2)[:2]), shape)[1] > 500.0


SHAFT = [(0.0, -1.0), (1.0, -1.0), (1.0, 0.0), (0.5, 0.0), (0.5, 1.0), (0.0, 1.0)]     # re-entrant edge at z = 0


def test_gradient_and_curvature_by_differences():
    h, checked = 1e-6, {}
    for name, shape in ({n: s(1) for n, s in SHAPES.items()} | {"shaft": revolved(SHAFT, 12)}).items():
        surface = build_surface(*shape)
        places, _, _ = around(name if name in SHAPES else "torus", 150, 0.1, seed=5)
        if name == "shaft":
            a = np.random.default_rng(1).uniform(0, 2 * np.pi, 150)
            r, z = np.random.default_rng(2).uniform((0.4, -0.2), (0.7, 0.2), (150, 2)).T
            places = np.stack((r * np.cos(a), r * np.sin(a), z), axis=1)
        for y in places:
            _, feature, closest_point, weights, gap, (N, gradient, G) = query(y, surface.tree)
            sides = [[query(y + s * h * e, surface.tree) for s in (1, -1)] for e in np.eye(3)]
            if any(q[1] != feature or q[1] > 0 and q[0] != sides[0][0][0] for pair in sides for q in pair):
                continue
            if feature > 0 and abs(gap) < 0.02:
                continue
            if min(weights) < 1e-4 and feature == 0:
                continue
            np.testing.assert_allclose(gradient, [(p[4] - m[4]) / (2 * h) for p, m in sides], atol=1e-7)
            np.testing.assert_allclose(
                np.array(G).T, [np.subtract(p[5][0], m[5][0]) / (2 * h) for p, m in sides], atol=1e-6)
            np.testing.assert_allclose(np.subtract(y, closest_point), gap * np.array(N), atol=1e-12)
            kind = "face" if feature == 0 else "edge" if feature < 4 else "vertex"
            checked[name, kind, gap < 0] = checked.get((name, kind, gap < 0), 0) + 1
    for name in SHAPES:
        assert checked[name, "face", True] > 20 and checked[name, "face", False] > 20
    assert checked["shaft", "edge", True] > 10      # seen from inside, the circle at z = 0


# ---------------------------------------------------------------- sharp edges, plane faces


def cylinder_gap(y, radius, height):
    """Exact gap of a cylinder about z."""
    radial, axial = np.hypot(y[:, 0], y[:, 1]) - radius, np.abs(y[:, 2]) - height / 2
    beyond = np.hypot(np.maximum(radial, 0), np.maximum(axial, 0))
    return np.where((radial < 0) & (axial < 0), np.maximum(radial, axial), beyond)


def test_cylinder_has_a_round_mantle_plane_ends_and_a_sharp_rim(geometry):
    mesh = generate(geometry / "cylinder.geo", {"radius": 0.25, "height": 0.4, "size": 0.1})
    rng = np.random.default_rng(0)
    a, r, z = rng.uniform((0, 0.15, 0.1), (2 * np.pi, 0.3, 0.25), (2000, 3)).T
    y = np.stack((r * np.cos(a), r * np.sin(a), z), axis=1)
    exact = cylinder_gap(y, 0.25, 0.4)
    surface, facets = build_surface(mesh.points, mesh.contact, mesh.normals), build_surface(mesh.points, mesh.contact)
    y, exact, r, z = (values[exact > -0.03] for values in (y, exact, r, z))
    error = np.abs(gaps_and_normals(surface, y)[0] - exact)
    assert error.max() < 7e-4 and error[exact < 0.0].max() < 5e-5
    assert np.abs(gaps_and_normals(facets, y)[0] - exact)[exact < 0.0].max() > 4e-3     # sagitta of the facets
    under = (exact < -1e-3) & (np.abs(exact - (z - 0.2)) < 1e-9) & (r < 0.22)
    g, N = gaps_and_normals(surface, y[under])
    np.testing.assert_allclose(g, z[under] - 0.2, atol=1e-15)
    np.testing.assert_allclose(N, np.broadcast_to([0.0, 0.0, 1.0], N.shape), atol=1e-15)
    assert under.sum() > 100


def test_bodies_of_plane_faces_carry_no_patches(geometry):
    for name in ("box", "notched_block"):
        mesh = generate(geometry / f"{name}.geo")
        tree = build_surface(mesh.points, mesh.contact, mesh.normals).tree
        assert tree.patches.bulge == 0.0 and len(tree.patches.nodes) == 0 and not tree.kind[:, SECOND:].any()


def test_plane_faces_of_a_rounded_body_stay_plane(geometry):
    mesh = generate(geometry / "stockless_anchor.geo", {"size": 0.3})
    surface, facets = build_surface(mesh.points, mesh.contact, mesh.normals), build_surface(mesh.points, mesh.contact)
    checked = 0
    assert 0.02 < np.mean(surface.curved) < 0.7
    for t in np.flatnonzero(~surface.curved):
        y = facets.vertices[facets.triangles[t]].mean(axis=0) - 1e-3 * facets.normals[t]
        if query(y, facets.tree)[0] == t:
            found, flat = query(y, surface.tree), query(y, facets.tree)
            assert found == flat and flat[4] == pytest.approx(-1e-3, abs=1e-15)
            checked += 1
    assert checked > 100


# ---------------------------------------------------------------- normals


def test_normals_of_the_geometry(geometry):
    for size in (0.1, 0.05):
        mesh = generate(geometry / "sphere.geo", {"size": size})
        np.testing.assert_allclose(0.25 * mesh.normals, mesh.points[mesh.contact], atol=1e-12)


BUILT_IN = """
lc = 0.15; Point(1) = {0, 0, 0, lc}; Point(2) = {0.5, 0, 0, lc}; Point(3) = {0, 0.5, 0, lc}; Point(4) = {0, 0, 0.5, lc};
Circle(1) = {2, 1, 3}; Circle(2) = {3, 1, 4}; Circle(3) = {4, 1, 2}; Line(4) = {1, 2}; Line(5) = {1, 3}; Line(6) = {1, 4};
Curve Loop(1) = {1, 2, 3}; Surface(1) = {1} In Sphere {1}; Curve Loop(2) = {4, 1, -5}; Plane Surface(2) = {2};
Curve Loop(3) = {5, 2, -6}; Plane Surface(3) = {3}; Curve Loop(4) = {6, 3, -4}; Plane Surface(4) = {4};
Surface Loop(1) = {1, 2, 3, 4}; Volume(1) = {1};
Physical Volume("body") = {1}; Physical Surface("contact") = {1, 2, 3}; Physical Surface("symmetry") = {4};
"""


def test_normals_of_the_built_in_kernel(tmp_path):
    """An eighth of a sphere: radial on its round face, exactly plane on the others."""
    path = tmp_path / "eighth.geo"
    path.write_text(BUILT_IN)
    mesh = generate(path)
    corners = mesh.points[mesh.contact]
    round_face = np.abs(np.linalg.norm(corners, axis=2) - 0.5).max(axis=1) < 1e-9
    np.testing.assert_allclose(0.5 * mesh.normals[round_face], corners[round_face], atol=1e-7)
    assert (np.abs(mesh.normals[~round_face]) > 1 - 1e-12).any(axis=2).all()


HALF = """SetFactory("OpenCASCADE");
Mesh.MeshSizeMin = 0.1; Mesh.MeshSizeMax = 0.1;
Sphere(1) = {0, 0, 0, 0.5}; Box(2) = {-1, 0, -1, 2, 2, 2};
BooleanIntersection(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
cut[] = Surface In BoundingBox{-1, -1e-3, -1, 1, 1e-3, 1};
all[] = Abs(Boundary{ Volume{3}; }); all[] -= cut[];
Physical Volume("body") = {3}; Physical Surface("contact") = {all[]}; Physical Surface("symmetry") = {cut[]};
"""


@pytest.mark.parametrize("by", ["geometry", "facets"])
def test_half_a_sphere_has_no_false_normals_at_its_cut(tmp_path, by):
    path = tmp_path / "half.geo"
    path.write_text(HALF)
    mesh = generate(path)
    normals = mesh.normals
    if by == "facets":
        normals = corner_normals(mesh.points, mesh.contact, symmetry=np.array([0.0, 1.0, 0.0]))
    rim = np.abs(mesh.points[mesh.contact][:, :, 1]) < 1e-9
    assert rim.sum() > 20 and np.abs(normals[rim][:, 1]).max() < 1e-12
    surface = build_surface(mesh.points, mesh.contact, normals)
    angle, gap = np.random.default_rng(0).uniform((0, -0.05), (2 * np.pi, 0.05), (200, 2)).T
    for y in (0.0, 1e-4):
        r = np.sqrt((0.5 + gap) ** 2 - y**2)
        found, N = gaps_and_normals(surface, np.stack((r * np.cos(angle), 0 * r + y, r * np.sin(angle)), axis=1))
        np.testing.assert_allclose(found, gap, atol=5e-4 if by == "facets" else 5e-5)
        assert np.abs(N[:, 1]).max() < (1e-2 if by == "facets" else 1e-3)
    if by == "facets":
        one_sided = corner_normals(mesh.points, mesh.contact)       # the broken variant
        assert np.abs(one_sided[rim][:, 1]).max() > 0.05


def test_without_geometry_edges_that_bend_little_are_smooth_and_others_sharp():
    vertices, triangles, exact = revolved([(0, -0.5), (0.5, -0.5), (0.5, 0.5), (0, 0.5)], 24)     # bends of 15 degrees
    found = corner_normals(vertices, triangles)
    assert np.degrees(np.arccos(np.clip(np.einsum("tki,tki->tk", found, exact), -1, 1))).max() < 3.0
    caps = np.abs(exact[:, 0, 2]) > 0.5
    np.testing.assert_allclose(found[caps], exact[caps], atol=1e-14)
    coarse = revolved([(0, -0.5), (0.5, -0.5), (0.5, 0.5), (0, 0.5)], 8)        # a prism, with bends of 45 degrees
    assert build_surface(*coarse[:2], corner_normals(*coarse[:2])).tree.patches.bulge == 0.0


@pytest.mark.parametrize("known", [True, False])
def test_cone_keeps_its_apex(known):
    """There no normal fits all facets: each takes its own, and points near the tip see a sharp cone."""
    vertices, triangles, exact = revolved([(0, 0), (0.5, 1.0), (0, 1.0)], 16)
    given = exact.copy()
    given[np.linalg.norm(vertices[triangles], axis=2) < 1e-9] = np.nan
    normals = corner_normals(vertices, triangles, given if known else None)
    surface = build_surface(vertices, triangles, normals)
    assert query(np.array([0.0, 0.0, -0.01]), surface.tree)[4] == pytest.approx(0.01, rel=1e-6)
    angle = np.linspace(0, 2 * np.pi, 50)
    for s in (0.05, 0.3):
        y = np.stack((0.5 * s * np.cos(angle), 0.5 * s * np.sin(angle), 0 * angle + s), axis=1)   # on the cone
        assert np.abs(gaps_and_normals(surface, y)[0]).max() < (0.01 if known else 0.02) * s


def test_places_around_a_tip_are_inside_by_the_smooth_surface_if_by_facets(geometry):
    """But for what stands out of the facets. Where the smooth surface ends beside the tip of a cone, places outside of it
    were taken for places 5 cm inside."""
    mesh = generate(geometry / "cone.geo")
    surface, facets = build_surface(mesh.points, mesh.contact, mesh.normals), build_surface(mesh.points, mesh.contact)
    tip, bulge = mesh.points[mesh.points[:, 2].argmin()], surface.tree.patches.bulge
    size = np.ptp(mesh.points[:, 0])
    for spread in (0.1, 0.5, 2.0):
        places = tip + spread * size * np.random.default_rng(0).normal(size=(3000, 3))
        smooth, plain = (np.array([query(y, s.tree)[4] for y in places]) for s in (surface, facets))
        assert np.abs(smooth - plain).max() < 2 * bulge < 0.15 * size


@pytest.mark.parametrize("angle, size", [(47.3, 0.3), (58.1, 0.3), (80.2, 0.3), (60.0, 0.2)])
def test_a_cone_has_eight_triangles_and_more_around_its_tip(angle, size):
    """Where only three met, one of them might span 156 degrees of the circumference."""
    mesh = generate(GEOMETRY / "cone.geo", {"radius": 1.0, "angle": angle, "shaft": 2.0, "size": size})
    corners = mesh.points[mesh.contact]
    at_tip = np.abs(corners).max(axis=2) < 1e-9
    around = corners[at_tip.any(axis=1)][~at_tip[at_tip.any(axis=1)]].reshape(-1, 2, 3)
    direction = np.arctan2(around[..., 1], around[..., 0])
    spans = np.abs(np.angle(np.exp(1j * np.diff(direction, axis=1)))).ravel()
    assert len(spans) >= 8 and np.degrees(spans.max()) < 46.0 and spans.sum() == pytest.approx(2 * np.pi, rel=1e-6)


def test_stray_normals_are_replaced_by_those_of_the_facets():
    vertices, triangles, exact = sphere(2)
    given = exact.copy()
    one = triangles == triangles[0, 0]
    given[one] = np.cross(exact[one], [0.3, 0.5, 0.8])
    found = corner_normals(vertices, triangles, given)
    assert np.abs(found - exact).max() < 0.1
    np.testing.assert_allclose(found[~one], exact[~one], atol=1e-14)


# ---------------------------------------------------------------- bounds


@pytest.mark.parametrize("shape", SHAPES)
def test_bounds_include_what_stands_out_of_the_facets(shape):
    vertices, triangles, normals = SHAPES[shape](1)
    smooth, facets = build_surface(vertices, triangles, normals), build_surface(vertices, triangles)
    for direction in np.random.default_rng(0).normal(size=(20, 3)):
        direction /= np.linalg.norm(direction)
        reach = smooth.extent(direction)
        assert reach >= facets.extent(direction)
        assert reach <= smooth.radius + 1e-12
        if shape == "sphere":
            assert reach == pytest.approx(1.0, abs=0.011)      # the flat edges end 0.08 short of it
    assert (smooth.lower <= facets.lower).all() and (smooth.upper >= facets.upper).all()
    weights = np.random.default_rng(1).dirichlet(np.ones(3), 200)
    direction, nodes = np.array([0.3, -0.5, 0.8]), smooth.tree.patches.nodes
    x = nodes[:, None, 0] + weights[:, 1:2] * nodes[:, None, 1] + weights[:, 2:] * nodes[:, None, 2]
    for k, (i, j) in enumerate(((0, 1), (1, 2), (2, 0))):
        x = x - (weights[:, i] * weights[:, j])[:, None] * nodes[:, None, 6 + k]
    assert (x @ direction).max() <= smooth.extent(direction) + 1e-12
    assert (x @ direction).max() > smooth.extent(direction) - 5e-3


def test_a_reach_finds_all_that_is_nearer():
    surface = build_surface(*sphere(1))
    for y in around("sphere", 200, 0.3)[0]:
        full = closest(y, np.inf, surface.tree)
        assert closest(y, 1.0001 * abs(full[4]), surface.tree) == full
        assert closest(y, 0.9999 * abs(full[4]), surface.tree)[0] == -1


@pytest.mark.parametrize("shape", SHAPES)
def test_distances_are_lower_bounds_of_the_way_to_the_surface(shape):
    surface = build_surface(*SHAPES[shape](1))
    places, gap, normal = around(shape, 3000, 0.2, seed=9)
    places, normal = places[gap > 0.01], normal[gap > 0.01]
    bound, g = distances(places, surface)[0], gaps_and_normals(surface, places)[0]
    assert (bound < g).all() and (bound > 0.5 * g).all()
    for tilt in np.random.default_rng(0).normal(scale=0.3, size=(10, 3)):
        way = tilt - normal
        moved = places + 0.9999 * bound[:, None] * way / np.linalg.norm(way, axis=1)[:, None]
        assert (gaps_and_normals(surface, moved)[0] > 0.0).all()


def test_merged_helper_keeps_the_orientation():
    vertices, triangles, _ = revolved(SHAFT, 12)
    again, numbers = merged(vertices[triangles])
    np.testing.assert_allclose(again[numbers], vertices[triangles])


@pytest.mark.parametrize("stretch", [(1.0, -1.0, 1.0), (1.4, 1.0, 0.7), (0.6, 0.6, 1.3)])
def test_a_mirrored_or_stretched_sphere_has_its_normals_at_the_poles_too(tmp_path, stretch):
    """gmsh gives unit vectors there that are up to 63 degrees off, alike for all facets of the pole."""
    path = tmp_path / "stretched.geo"
    path.write_text('SetFactory("OpenCASCADE");\nMesh.MeshSizeMin = 0.1; Mesh.MeshSizeMax = 0.1;\n'
                    'Sphere(1) = {0, 0, 0, 0.3};\n'
                    f'Dilate {{{{0, 0, 0}}, {{{stretch[0]}, {stretch[1]}, {stretch[2]}}}}} {{ Volume{{1}}; }}\n'
                    'Physical Volume("body") = {1}; Physical Surface("contact") = Abs(Boundary{ Volume{1}; });\n')
    mesh = generate(path)
    corners = mesh.points[mesh.contact]
    exact = corners / np.square(stretch)
    exact /= np.linalg.norm(exact, axis=2)[:, :, None]
    sine = np.linalg.norm(np.cross(corner_normals(mesh.points, mesh.contact, mesh.normals), exact), axis=2)
    assert np.abs(corners[:, :, 2]).max() > 0.99 * 0.3 * stretch[2] and np.degrees(sine.max()) < 0.1
