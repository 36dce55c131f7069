"""Which points a grid with finer cells halves, and which it leaves as they are."""

from dataclasses import replace

import numpy as np
import pytest
from contact_bed import bed

from hybrid.laws.hencky import Hencky
from hybrid.soil.refinement import PointRefinement
from hybrid.state import PointConstants, Points, Population


def soil_of_coarse_points(stretch):
    """(Population, Grid, law, PointRefinement): cells of 0.1 m, points of cells twice as wide, stretched along x."""
    grid, _, _ = bed()
    position = np.array([[0.3, 0.4, 0.0], [0.5, 0.4, 0.0]])
    half, n = np.full((2, 3), 0.05), 2
    F = np.tile(np.diag([stretch, 1.0, 1.0]), (n, 1, 1))
    points = Points(position=position, velocity=np.zeros((n, 3)), acceleration=np.zeros((n, 3)), half_width=half.copy(),
                    deformation=F, b_elastic=np.tile(np.eye(3), (n, 1, 1)), stress=np.zeros((n, 3, 3)),
                    plastic_strain=np.zeros(n))
    constants = PointConstants(position, half, np.full(n, 1e-3), np.full(n, 1.8))
    law = Hencky(np.full(n, 1e6), 0.3)
    width = np.full(3, 0.05)
    refinement = PointRefinement((0, 1, 2), np.zeros(3), width, np.full(3, 2), 1)
    return Population(points, constants, law.rows), grid, law, refinement


@pytest.mark.parametrize(("stretch", "count"), [(1.0, 16), (9.0, 16), (11.0, 8)])
def test_points_stretched_beyond_the_limit_are_not_split(stretch, count):
    """Two points become eight each, but not along an axis that F stretches by more than ten."""
    population, grid, law, refinement = soil_of_coarse_points(stretch)
    adapted, _ = refinement.adapt(population, grid, law, np.ones(2, bool))
    assert len(adapted) == count
    assert adapted.constants.mass.sum() == pytest.approx(3.6)
    moved = 0.025 * stretch if count == 16 else 0.0
    assert np.abs(adapted.points.position[:, 0] - 0.4).max() == pytest.approx(0.1 + moved)


def test_a_point_is_not_split_if_a_half_would_lie_outside_the_grid():
    """A point near the end of the grid, stretched five times."""
    population, grid, law, refinement = soil_of_coarse_points(5.0)
    end = grid.axes[0][0]
    for place in (0.1, 0.124, 0.126, 0.13):
        population.points.position[0, 0] = end + place
        adapted, _ = refinement.adapt(population, grid, law, np.ones(2, bool))
        assert adapted.points.position[:, 0].min() >= end
        assert (len(adapted) == 16) == (place > 0.125)


def test_all_that_a_point_is_split_into_has_one_family():
    """So the halves of a point, which may be merged again, come together in one process, wherever they have moved."""
    population, grid, law, refinement = soil_of_coarse_points(1.0)
    refinement = replace(refinement, start=np.full(3, -0.05))
    adapted, _ = refinement.adapt(population, grid, law, np.ones(2, bool))
    adapted.points.position[:] = 7.0
    family, point = np.unique(refinement.family(adapted).round(12), axis=0, return_inverse=True)
    np.testing.assert_allclose(family, population.constants.position, atol=1e-12)
    assert np.bincount(point.ravel()).tolist() == [8, 8]
    along = replace(refinement, axes=(0,)).family(adapted)
    assert np.array_equal(along[:, 1:], adapted.constants.position[:, 1:])
