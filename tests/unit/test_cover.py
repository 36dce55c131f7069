"""How often contact points cover the surface of a body: once, in layers, on both sides of a wall, in half models and
slices."""

import numpy as np
import pytest
from contact_bed import RIGHT_HAND, ball, box

from hybrid.contact.cover import Cover
from hybrid.contact.samples import everywhere

EVERYWHERE = np.array([[-np.inf, np.inf]] * 3)
ORIGIN = np.zeros(3), np.eye(3)
WIDTH = 0.1


def at(surface, spacing=0.02, chosen=None):
    """Feet (m, 3), normals (m, 3) and areas (m,) of contact points spread evenly over a surface, as much of it as
    `chosen` says."""
    found = everywhere(surface, spacing)
    return found if chosen is None else tuple(values[chosen(*found)] for values in found)


def twice(found):
    return tuple(np.concatenate([values, values]) for values in found)


@pytest.mark.parametrize("surface, area",
                         [(ball(0.25), 4 * np.pi * 0.25**2), (box(half=(0.5, 0.3, 0.2)), 8 * (0.15 + 0.06 + 0.1))])
@pytest.mark.parametrize("spacing", [0.01, 0.05, 1.0])
def test_points_everywhere_have_the_area_of_the_surface(surface, area, spacing):
    point, normal, own = everywhere(surface, spacing)
    assert own.sum() == pytest.approx(area, rel=1e-2)
    assert np.einsum("ni,ni->n", point, normal).min() > 0.0     # outward; both are convex about their centre
    assert own.max() < 2 * max(spacing, np.sqrt(area / len(surface.triangles)))**2


@pytest.mark.parametrize("surface", [ball(0.5), box(half=(0.5, 0.3, 0.2))])
@pytest.mark.parametrize("pose", [ORIGIN, (np.array([3.0, -2.0, 1.0]), RIGHT_HAND)])
def test_each_layer_counts_once_whatever_the_pose(surface, pose):
    cover, (y, normal, area) = Cover.of(surface, WIDTH), at(surface)
    closest_point, normal = pose[0] + y @ pose[1].T, normal @ pose[1].T
    np.testing.assert_allclose(cover.layers(closest_point, normal, area, pose, EVERYWHERE), 1.0, atol=0.05)
    two = cover.layers(*twice((closest_point, normal, area)), pose, EVERYWHERE)
    np.testing.assert_allclose(two, 2.0, atol=0.1)


def test_where_contact_ends_there_is_half_of_a_layer():
    cover, found = Cover.of(box(half=(1.0, 1.0, 0.5)),
                            WIDTH), at(box(half=(1.0, 1.0, 0.5)), chosen=lambda y, n, a: y[:, 0] > 0.0)
    layers, top = cover.layers(*found, ORIGIN, EVERYWHERE), found[1][:, 2] > 0.9
    x, inner = found[0][:, 0], top & (np.abs(found[0][:, 1]) < 0.7)
    assert layers[inner & (x < 0.03)] == pytest.approx(0.5, abs=0.12)
    assert layers[inner & (x > 0.25)] == pytest.approx(1.0, abs=0.05)


def test_what_is_beyond_a_plane_of_symmetry_does_not_count():
    """Two layers on the half of the surface that the grid has: two up to the plane, where half of the surface around is
    missing."""
    surface = ball(0.5)
    cover, found = Cover.of(surface, WIDTH), twice(at(surface, chosen=lambda y, n, a: y[:, 0] > 0.0))
    half = np.array([[0.0, 2.0], [-2.0, 2.0], [-2.0, 2.0]])
    layers, edge = cover.layers(*found, ORIGIN, half), found[0][:, 0] < 0.05
    np.testing.assert_allclose(layers, 2.0, atol=0.25)
    assert cover.layers(*found, ORIGIN, EVERYWHERE)[edge].max() < 1.7


def test_both_sides_of_a_wall_count_apart():
    wall = box(half=(0.5, 0.5, 0.01))
    layers = Cover.of(wall, WIDTH).layers(*at(wall), ORIGIN, EVERYWHERE)
    assert np.median(layers) == pytest.approx(1.0, abs=0.02) and layers.max() < 1.1


def test_in_a_slice_areas_are_those_of_its_thickness():
    """A box 1.6 m long of which the slice has 0.2 m; contact points lie in any plane across it."""
    surface, share = box(half=(0.5, 0.8, 0.3)), 0.2 / 1.6
    flat = np.array([[0.0, 1.0, 0.0]])
    y, normal, area = at(surface, chosen=lambda y, n, a: np.abs(n[:, 1]) < 0.5)
    without_ends = Cover.of(surface, WIDTH, flat, share)
    layers = without_ends.layers(y, normal, share * area, ORIGIN, EVERYWHERE)
    np.testing.assert_allclose(layers, 1.0, atol=0.05)


def test_a_large_body_has_a_bounded_number_of_patches():
    cover = Cover.of(box(half=(20.0, 20.0, 20.0)), WIDTH)
    assert len(cover.area) < 1.2e5 and cover.area.sum() == pytest.approx(6 * 1600.0)


def test_nothing_in_contact():
    none = np.zeros((0, 3))
    assert len(Cover.of(ball(0.5), WIDTH).layers(none, none, np.zeros(0), ORIGIN, EVERYWHERE)) == 0
