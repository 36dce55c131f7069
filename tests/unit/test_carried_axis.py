"""Nodes of an axis that go along with a body: by less than a cell, whole where it goes, not at all at the ends."""

import numpy as np
import pytest

from hybrid.grid.carried_axis import CarriedAxis

GRADED = np.array([-4.0, -2.5, -1.5, -1.0, -0.5, 0.0, 0.5, 1.0])


def test_cells_where_the_body_goes_move_with_it_and_the_ends_stay():
    axis = CarriedAxis.around(GRADED, (-1.2, 0.6), (-1.4, 0.6))
    moved = axis.at(-0.2) - GRADED
    assert moved == pytest.approx([0.0, -0.12, -0.2, -0.2, -0.2, -0.2, -0.2, 0.0])
    assert np.array_equal(axis.at(0.0), GRADED)


def test_after_whole_cells_the_nodes_are_where_they_were():
    axis = CarriedAxis.around(GRADED, (-1.2, 0.6), (-1.4, 0.6))
    for way in (0.1, -0.24, 0.251, 1.3, -7.9):
        nodes = axis.at(way)
        assert np.allclose([axis.at(way - 0.5), axis.at(way + 2.0)], nodes, rtol=0, atol=1e-12)
        inside = slice(2, 7)
        assert np.abs(nodes - GRADED)[inside] == pytest.approx(np.abs(nodes - GRADED)[2]) and abs(nodes[2] + 1.5) < 0.2508
        assert np.diff(nodes).min() > 0.249


def test_half_a_cell_is_the_same_with_any_round_off_and_on_both_sides():
    axis = CarriedAxis.around(GRADED, (-1.2, 0.6), (-1.4, 0.6))
    for way in (0.25, -0.25):
        for noise in (1 - 1e-14, 1 + 1e-14):
            assert axis.at(way * noise)[3] - GRADED[3] == pytest.approx(way)


def test_a_body_that_goes_through_cells_of_different_sizes_has_none():
    assert CarriedAxis.around(GRADED, (-1.2, 0.4), (-1.6, 0.4)) is None
    assert CarriedAxis.around(GRADED, (-1.2, 9.0), (-1.5, 9.0)) is not None     # above the grid there are no cells


def test_equal_cells_up_to_the_ends_share_what_the_last_ones_take():
    axis = CarriedAxis.around(np.arange(13.0), (7.5, 11.2), (3.0, 14.0))
    assert axis.at(0.4) - np.arange(13.0) == pytest.approx([0.0, 0.1, 0.2, 0.3, *8 * [0.4], 0.0])


def test_nodes_do_not_depend_on_how_far_the_body_goes():
    near, far = (CarriedAxis.around(GRADED, (-0.4, 0.4), (low, 0.4)) for low in (-0.5, -1.4))
    assert np.array_equal(near.at(0.2), far.at(0.2))
