"""Samples of a body's surface: where they are, and that their areas are a quadrature of the surface."""

import numpy as np
import pytest
from contact_bed import ball, box

from hybrid.body.samples import surface_samples

SURFACES = {"box": box(1), "fine box": box(3), "ball": ball(rings=8)}


@pytest.mark.parametrize("surface", SURFACES.values(), ids=SURFACES)
def test_no_spacing_finer_than_the_facets_leaves_the_vertices(surface):
    samples = surface_samples(surface, 10.0)
    assert len(samples) == len(surface.vertices)
    distance = np.linalg.norm(samples.position[:, None] - surface.vertices, axis=2)
    np.testing.assert_allclose(distance.min(axis=1), 0.0, atol=1e-12)
    np.testing.assert_allclose(distance.min(axis=0), 0.0, atol=1e-12)


@pytest.mark.parametrize("spacing", [10.0, 0.3, 0.1])
@pytest.mark.parametrize("surface", SURFACES.values(), ids=SURFACES)
def test_areas_close_the_surface_and_enclose_its_volume(surface, spacing):
    """Σ a_s = 0 and Σ a_s·y_s / 3 = V: the rule integrates linear functions on each facet exactly."""
    samples = surface_samples(surface, spacing)
    corners = surface.vertices[surface.triangles]
    volume = np.einsum("ti,ti->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    scale = np.linalg.norm(samples.area, axis=1).sum()
    np.testing.assert_allclose(samples.area.sum(axis=0), 0.0, atol=1e-13 * scale)
    assert np.einsum("ki,ki->", samples.area, samples.position) / 3 == pytest.approx(volume, rel=1e-12)


@pytest.mark.parametrize("surface", SURFACES.values(), ids=SURFACES)
def test_weights_give_the_place_on_the_triangle(surface):
    samples = surface_samples(surface, 0.2)
    corners = surface.vertices[surface.triangles[samples.triangle]]
    np.testing.assert_allclose(np.einsum("kv,kvi->ki", samples.weights, corners), samples.position, atol=1e-13)
    np.testing.assert_allclose(samples.weights.sum(axis=1), 1.0, rtol=1e-14)


def test_spacing_is_kept_and_samples_on_edges_are_merged():
    """No two samples coincide, though triangles share edges, and the nearest other one is within the spacing."""
    samples = surface_samples(box(1), 0.25)
    distance = np.linalg.norm(samples.position[:, None] - samples.position, axis=2)
    np.fill_diagonal(distance, np.inf)
    assert 1e-3 < distance.min() and distance.min(axis=1).max() <= 0.25


def test_a_sample_on_an_edge_shows_flat_soil_only_the_bottom():
    """-n·a_s over the samples of the bottom of a box, walls included, is the area of the bottom."""
    samples = surface_samples(box(1, (1.0, 0.8, 0.5)), 0.2)
    bottom = samples.position[:, 2] < -0.5 + 1e-9
    assert -samples.area[bottom, 2].sum() == pytest.approx(2.0 * 1.6, rel=1e-12)
