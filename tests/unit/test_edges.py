"""Sharp edges of a body beside which soil that deforms is not in contact."""

import numpy as np
import pytest

from hybrid.body.mesh import generate
from hybrid.body.surface import build_surface
from hybrid.contact.edges import find_edges
from hybrid.runtime.data import GEOMETRY

DOWN = np.array([[0.0, 0.0, -1.0]])


def surface_of(file, **parameters):
    mesh = generate(GEOMETRY / file, parameters)
    middle = 0.5 * (mesh.points.min(axis=0) + mesh.points.max(axis=0))
    return build_surface(mesh.points - middle, mesh.contact, mesh.normals)


def share_below(edges, surface, x, y=0.0):
    """Share of contact under the bottom of a body at (x, y)."""
    return edges.share(np.array([[x, y, surface.lower[2]]]), DOWN)[0]


def test_a_box_has_contact_from_half_a_cell_inside_its_edges():
    surface = surface_of("box.geo", length=2.0, width=1.0, height=0.5, size=0.5)
    edges = find_edges(surface, 0.2)
    right, front = surface.upper[0], surface.upper[1]
    assert share_below(edges, surface, right - 0.08) == 0.0 and share_below(edges, surface, right - 0.12) == 1.0
    assert share_below(edges, surface, right - 0.1) == pytest.approx(0.5)
    assert share_below(edges, surface, 0.0, front - 0.08) == 0.0
    # on a side of the box, half as high as wide, the same edge counts as far
    side = edges.share(np.array([[right, 0.0, surface.lower[2] + 0.12]]), np.array([[1.0, 0.0, 0.0]]))[0]
    assert side == 1.0


def test_narrow_faces_keep_their_contact():
    """A rim of 0.04 m on cells of 0.2 m: contact from a quarter of its width inside its edges."""
    surface = surface_of("box.geo", length=2.0, width=1.0, height=0.04, size=0.5)
    edges = find_edges(surface, 0.2)
    right, bottom = surface.upper[0], surface.lower[2]
    outward = np.array([[1.0, 0.0, 0.0]])
    for off, wanted in ((0.005, 0.0), (0.02, 1.0)):
        assert edges.share(np.array([[right, 0.0, bottom + off]]), outward)[0] == wanted
    assert share_below(edges, surface, right - 0.08) == 0.0


def test_in_plane_strain_the_ends_of_the_prism_do_not_count():
    surface = surface_of("box.geo", length=2.0, width=0.1, height=0.5, size=0.5)
    edges = find_edges(surface, 0.2, [np.array([0.0, 1.0, 0.0])])
    right = surface.upper[0]
    assert share_below(edges, surface, 0.0) == 1.0
    assert share_below(edges, surface, right - 0.08) == 0.0 and share_below(edges, surface, right - 0.12) == 1.0


@pytest.mark.parametrize("file, parameters", [("sphere.geo", {"radius": 0.5, "size": 0.2})])
def test_a_smooth_body_has_no_edges(file, parameters):
    assert len(find_edges(surface_of(file, **parameters), 0.2).segment) == 0


def test_the_rim_of_a_cylinder_is_an_edge_and_its_facets_are_none():
    surface = surface_of("cylinder.geo", radius=0.5, height=1.0, size=0.15)
    edges = find_edges(surface, 0.1)
    radius = np.linalg.norm(edges.segment[..., :2], axis=2)
    assert len(edges.segment) and np.allclose(radius, 0.5, atol=1e-3)
    assert np.allclose(np.abs(edges.segment[..., 2]), 0.5, atol=1e-3)


def test_the_shoulder_of_a_cone_is_an_edge_and_its_tip_is_none():
    """Triangles that meet at the tip bend there, and not at the shoulder; those at the shoulder bend by 30°."""
    surface = surface_of("cone.geo", radius=1.0, angle=60.0, shaft=2.0, size=0.3)
    edges = find_edges(surface, 0.5)
    low, shoulder = surface.lower[2], surface.lower[2] + np.sqrt(3.0)
    assert set(np.round(edges.segment[..., 2].ravel(), 6)) == {round(shoulder, 6), round(shoulder + 2.0, 6)}
    outward = np.array([[np.sqrt(0.75), 0.0, -0.5]])
    for height, wanted in ((0.0, 1.0), (1.0, 1.0), (1.7, 0.0)):
        assert edges.share(np.array([[height / np.sqrt(3.0), 0.0, low + height]]), outward)[0] == wanted
