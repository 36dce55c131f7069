"""Sharp edges of a body, and the surface with these rounded off that soil which deforms is in contact with."""

import numpy as np
import pytest

from hybrid.body.closest import closest, gap_geometry
from hybrid.body.mesh import generate
from hybrid.body.rounded import round_off
from hybrid.body.sharp_edges import find_edges, narrowest_face
from hybrid.body.smooth import shared_edges
from hybrid.body.surface import build_surface
from hybrid.runtime.data import GEOMETRY

BOX = {"length": 2.0, "width": 1.0, "height": 0.5}


def surface_of(file, **parameters):
    mesh = generate(GEOMETRY / file, parameters)
    middle = 0.5 * (mesh.points.min(axis=0) + mesh.points.max(axis=0))
    return build_surface(mesh.points - middle, mesh.contact, mesh.normals)


def rounded(surface, cell, along=()):
    return round_off(surface, find_edges(surface, cell, along))


def gap(surface, *place):
    return closest(np.array(place), np.inf, surface.tree)[4]


def normal(surface, *place):
    triangle, feature, closest_point, weights, distance = closest(np.array(place), np.inf, surface.tree)
    return np.array(gap_geometry(np.array(place), closest_point, weights, distance, triangle, feature, surface.tree)[0])


def rim(surface):
    return surface.triangles.size - 2 * len(shared_edges(surface.triangles)[0])


def volume(surface):
    a, b, c = np.moveaxis(surface.vertices[surface.triangles], 1, 0)
    return np.einsum("ti,ti->", a, np.cross(b, c)) / 6


@pytest.mark.parametrize("size", [0.5, 0.06])
def test_a_box_is_itself_from_half_a_cell_inside_its_edges(size):
    """However fine its triangles are: those of 0.06 m lie within the inset of 0.1 m."""
    box = surface_of("box.geo", **BOX, size=size)
    body = rounded(box, 0.2)
    assert rim(body) == 0
    for place in ((0.899, 0.0, -0.25), (0.0, 0.399, -0.25), (1.0, 0.0, -0.149), (0.899, 0.399, -0.25)):
        assert gap(body, *place) == pytest.approx(0.0, abs=1e-8)
    # the parabola between (0.9, -0.25) and (1, -0.15) passes a quarter of the inset inside of the edge
    assert gap(body, 0.975, 0.0, -0.225) == pytest.approx(0.0, abs=1e-4)
    assert gap(body, 1.0, 0.0, -0.25) > 0.03
    # a parabola takes d²/6 of an edge, its four chords an eighth more
    edges = 4 * (2.0 + 1.0 + 0.5)
    assert volume(box) - volume(body) == pytest.approx(9 / 8 * 0.01 / 6 * edges, rel=0.02)


@pytest.mark.parametrize("end", [(1.0, 0.1, -0.1), (0.1, 0.9, -0.2), (1.0, 1.0, 0.0)])
def test_the_normal_is_continuous_over_edges_and_corners(end):
    """On ways from the bottom to sides and over the corner, a little below the surface."""
    box = surface_of("box.geo", **BOX, size=0.5)
    body = rounded(box, 0.2)
    start, s = np.array([0.1, 0.2, -1.0]), np.linspace(0.0, 1.0, 401)[:, None]
    way = (1 - s) * start + s * np.array(end)
    path = np.array([0.9, 0.4, -0.15]) + 0.09 * way / np.linalg.norm(way, axis=1, keepdims=True)
    turns = {name: max(np.linalg.norm(np.diff([normal(surface, *place) for place in path], axis=0), axis=1))
             for name, surface in (("sharp", box), ("rounded", body))}
    assert turns["rounded"] < 0.06 and turns["sharp"] > 1.0


def test_narrow_faces_keep_their_contact():
    """A rim of 0.04 m on cells of 0.2 m: itself from a quarter of its width inside its edges."""
    body = rounded(surface_of("box.geo", length=2.0, width=1.0, height=0.04, size=0.5), 0.2)
    assert gap(body, 1.0, 0.0, -0.009) == pytest.approx(0.0, abs=1e-8)
    assert gap(body, 1.0, 0.0, -0.019) > 1e-3 and gap(body, 0.95, 0.0, -0.02) > 1e-4


def test_a_prism_without_its_ends_is_rounded_along_its_axis_only():
    box = surface_of("box.geo", length=2.0, width=0.1, height=0.5, size=0.5)
    axis = np.array([0.0, 1.0, 0.0])
    sides = np.abs(box.normals @ axis) < 0.5
    prism = build_surface(box.vertices, box.triangles[sides])
    body = rounded(prism, 0.2, [axis])
    for y in (-0.049, 0.0, 0.049):
        assert gap(body, 0.899, y, -0.25) == pytest.approx(0.0, abs=1e-8)
        assert gap(body, 1.0, y, -0.25) == pytest.approx(gap(body, 1.0, 0.0, -0.25), abs=1e-6)
    assert np.ptp(body.vertices[:, 1]) == pytest.approx(0.1)


@pytest.mark.parametrize("shear", [0.0, 0.6], ids=["upright", "oblique"])
def test_a_body_that_is_cut_in_half_stays_on_its_plane(shear):
    """Where its edges meet the plane at an angle as well."""
    box = surface_of("box.geo", **BOX, size=0.5)
    kept = box.triangles[box.vertices[box.triangles][:, :, 0].mean(axis=1) < 1.0 - 1e-9]
    half = build_surface(box.vertices + shear * box.vertices[:, :1] * [0.0, 1.0, 0.0], kept)
    body = rounded(half, 0.2)
    ends = np.stack([body.triangles, np.roll(body.triangles, -1, axis=1)], axis=2)
    single = np.ones(body.triangles.shape, bool)
    single[shared_edges(body.triangles)] = False
    assert np.allclose(body.vertices[ends[single].ravel(), 0], 1.0)
    assert body.vertices[:, 0].max() < 1.0 + 1e-9


PYRAMID = np.array([[-0.5, 0.0, 0.3], [0.0, 0.0, 0.3], [0.5, 0.0, 0.3], [0.5, 0.5, 0.3], [0.0, 0.5, 0.3], [-0.5, 0.5, 0.3],
                    [0.0, 0.0, -0.3]])


@pytest.mark.parametrize("triangles, planes", [
    ([[0, 2, 3], [0, 3, 5], [2, 6, 3], [3, 6, 5], [5, 6, 0]], [1]), ([[1, 2, 3], [1, 3, 4], [2, 6, 3], [3, 6, 4]], [0, 1])])
def test_a_tip_in_the_planes_of_cuts_is_closed_in_them(triangles, planes):
    """Half and a quarter of a pyramid on its tip: the rim stays in the planes, and nothing is open between them."""
    used = np.unique(triangles)
    body = rounded(build_surface(PYRAMID[used], np.searchsorted(used, triangles)), 0.25)
    single = np.ones(body.triangles.shape, bool)
    single[shared_edges(body.triangles)] = False
    ends = body.vertices[np.stack([body.triangles, np.roll(body.triangles, -1, axis=1)], axis=2)[single]]
    assert np.abs(ends[:, :, planes]).max(axis=1).min(axis=1).max() < 1e-9 and body.vertices[:, planes].min() > -1e-9
    a, b, c = np.moveaxis(body.vertices[body.triangles], 1, 0)
    assert np.abs(np.delete(np.cross(b - a, c - a).sum(axis=0), planes)).max() < 1e-9
    assert body.vertices[:, 2].min() == pytest.approx(-0.15, abs=0.01)      # of the whole one -0.156


def test_a_smooth_body_has_no_edges():
    sphere = surface_of("sphere.geo", radius=0.5, size=0.2)
    assert len(find_edges(sphere, 0.2).triangle) == 0 and rounded(sphere, 0.2) is sphere


@pytest.mark.parametrize("radius, width", [(0.002, np.inf), (0.12, 0.24)])
def test_the_flat_at_the_tip_of_a_cone_is_no_narrow_face(radius, width):
    """One as wide as a cell and more is."""
    angle = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(24)])
    points = np.concatenate([radius * ring, ring + (0.0, 0.0, 1.0), [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]])
    i, j = np.arange(24), np.roll(np.arange(24), -1)
    flat, lid = np.full(24, 48), np.full(24, 49)
    parts = (flat, j, i), (lid, 24 + i, 24 + j), (i, j, 24 + j), (i, 24 + j, 24 + i)
    triangles = np.concatenate([np.column_stack(part) for part in parts])
    found = narrowest_face(find_edges(build_surface(points, triangles), 0.3), 0.3)
    assert found == pytest.approx(width, rel=0.02)


def ends_of(surface, edges):
    return surface.vertices[surface.triangles[edges.triangle, edges.number]].reshape(-1, 3)


def test_the_rim_of_a_cylinder_is_an_edge_and_its_facets_are_none():
    surface = surface_of("cylinder.geo", radius=0.5, height=1.0, size=0.15)
    ends = ends_of(surface, find_edges(surface, 0.1))
    assert len(ends) and np.allclose(np.linalg.norm(ends[:, :2], axis=1), 0.5, atol=1e-3)
    assert np.allclose(np.abs(ends[:, 2]), 0.5, atol=1e-3)
    body = rounded(surface, 0.1)
    assert rim(body) == 0 and gap(body, 0.5, 0.0, 0.44) == pytest.approx(0.0, abs=2e-4) and gap(body, 0.5, 0.0, 0.5) > 0.015


def test_a_slender_cylinder_of_few_facets_stays_round():
    """Vertices that move by twice its radius along it do not leave its surface."""
    surface = surface_of("cylinder.geo", radius=0.05, height=5.0, size=0.1)
    body = rounded(surface, 0.2)
    # 0.065 on the tangent planes
    assert body is not surface and np.linalg.norm(body.vertices[:, :2], axis=1).max() < 0.053


def test_the_shoulder_of_a_cone_is_an_edge_and_its_tip_is_none():
    """Triangles that meet at the tip bend there, and not at the shoulder; those at the shoulder bend by 30°."""
    surface = surface_of("cone.geo", radius=1.0, angle=60.0, shaft=2.0, size=0.3)
    low, shoulder = surface.lower[2], surface.lower[2] + np.sqrt(3.0)
    ends = ends_of(surface, find_edges(surface, 0.5))
    assert set(np.round(ends[:, 2], 6)) == {round(shoulder, 6), round(shoulder + 2.0, 6)}
    body = rounded(surface, 0.5)
    assert body.lower[2] == pytest.approx(low) and gap(body, 0.0, 0.0, low - 0.1) == pytest.approx(0.1, abs=1e-4)


def test_an_anchor_is_closed_and_nowhere_turned_over():
    """Of 1 744 triangles, with thin plates, edges that fade out and corners of several faces; cut in half."""
    mesh = generate(GEOMETRY / "stockless_anchor.geo", {})
    surface = build_surface(mesh.points, mesh.contact, mesh.normals)
    body = rounded(surface, 0.2)
    assert 0.9 < volume(body) / volume(surface) < 1.0
    plane = body.vertices[:, 1].min()
    assert surface.vertices[:, 1].min() == pytest.approx(plane, abs=1e-6)
    ends = np.stack([body.triangles, np.roll(body.triangles, -1, axis=1)], axis=2)
    single = np.ones(body.triangles.shape, bool)
    single[shared_edges(body.triangles)] = False
    assert np.allclose(body.vertices[ends[single].ravel(), 1], plane, atol=1e-6)


@pytest.mark.parametrize("size", [0.2, 0.12, 0.06])
def test_the_base_of_a_cylinder_stays_plane_beside_its_rounded_rim(size):
    """Its patches stood out of the base by up to 5 mm, on which the cylinder then stood."""
    radius, inset = 0.371, 0.03
    sharp = surface_of("cylinder.geo", radius=radius, height=0.2, size=size)
    body = rounded(sharp, 2 * inset)
    assert body.extent(np.array([0.0, 0.0, -1.0])) == pytest.approx(0.1, abs=1e-12)
    angles = np.linspace(0.0, 2.0 * np.pi, 50)
    for r in (0.1, 0.25, radius - 1.1 * inset):     # a polygon's corners are farther in than its sides
        heights = np.array([gap(body, r * np.cos(angle), r * np.sin(angle), -0.101) for angle in angles])
        assert heights == pytest.approx(np.full(50, 1e-3), abs=1e-12)
    for s in (0.1, 0.5, 0.9):                       # the parabola of the section, along the whole rim
        r, z = radius - (1 - s)**2 * inset, -0.1 + s**2 * inset
        gaps = np.array([gap(body, r * np.cos(angle), r * np.sin(angle), z) for angle in angles])
        assert np.abs(gaps).max() < 0.05 * inset


def test_a_body_of_plane_and_curved_faces_stays_inside_of_the_plane_ones(tmp_path):
    """A segment of a cylinder: straight and curved edges that meet in corners."""
    (tmp_path / "segment.geo").write_text("""
        SetFactory("OpenCASCADE"); Mesh.MeshSizeMin = 0.15; Mesh.MeshSizeMax = 0.15;
        Cylinder(1) = {0, 0, -0.1, 0, 0, 0.3, 0.37}; Box(2) = {-1, -1, -1, 1.1, 2, 2};
        BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
        Physical Volume("body") = {3}; Physical Surface("contact") = Abs(Boundary{ Volume{3}; });""")
    sharp = surface_of(tmp_path / "segment.geo")
    for cell in (0.03, 0.08):
        body = rounded(sharp, cell)
        for outward in ((-1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)):
            assert body.extent(np.array(outward)) == pytest.approx(sharp.extent(np.array(outward)), abs=1e-12)


def test_the_shoulder_of_a_cone_and_its_top_stay_where_they_are():
    sharp = surface_of("cone.geo", radius=0.1, shaft=0.4, size=0.05)
    body = rounded(sharp, 0.04)
    for r, angle in np.ndindex(3, 20):
        place = (0.03 * r * np.cos(angle), 0.03 * r * np.sin(angle), sharp.upper[2] + 1e-3)
        assert gap(body, *place) == pytest.approx(1e-3, abs=1e-12)
    assert body.extent(np.array([0.0, 0.0, 1.0])) == pytest.approx(sharp.upper[2], abs=1e-12)
    for z, angle in np.ndindex(9, 20):      # from the shoulder to the top: nowhere outside of the shaft, whose radius is 0.1
        assert gap(body, 0.11 * np.cos(angle), 0.11 * np.sin(angle), sharp.upper[2] - 0.05 * z) > 0.01 - 1e-4
