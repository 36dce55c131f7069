"""Nodes of a travelling axis: aligned, graded by halves and doubles, steady where the body hardly moves."""

import numpy as np
import pytest

from hybrid.grid.moving_axis import AxisLayout, MovingAxis


@pytest.mark.parametrize("doublings", [1, 2, 3])
@pytest.mark.parametrize("per", [1, 2, 3])
@pytest.mark.parametrize("window", [None, (2.0, 3.0)])
def test_cells_double_away_from_the_body_and_start_at_multiples_of_themselves(doublings, per, window):
    axis = MovingAxis(-4.0, 12.0, 64, (0.6, 0.9), window, doublings, per)
    for low in np.linspace(-5.0, 12.5, 120):
        layout = axis.layout_for(low, low + 1.1)
        nodes = axis.node_numbers(layout)
        cells = np.diff(nodes)
        assert (nodes[0], nodes[-1]) == layout.window
        assert np.all(np.isin(cells, 2 ** np.arange(doublings + 1)))
        assert np.all(nodes[:-1] % cells == 0)
        assert np.all((cells[1:] <= 2 * cells[:-1]) & (cells[:-1] <= 2 * cells[1:]))
        inner = (axis.coordinates(nodes[:-1]) >= low - 0.6) & (axis.coordinates(nodes[1:]) <= low + 2.0)
        assert np.all(cells[inner] == 1)


def test_coordinates_are_the_same_bits_in_every_layout():
    axis = MovingAxis(-3.7, 12.3, 160, (0.5, 0.5), (1.5, 1.5), 3, 2)
    seen = {}
    for low in np.linspace(-3.0, 11.0, 60):
        nodes = axis.node_numbers(axis.layout_for(low, low + 1.0))
        for number, x in zip(nodes.tolist(), axis.coordinates(nodes).tolist()):
            assert seen.setdefault(number, x) == x


def test_a_body_that_trembles_does_not_move_the_grid():
    axis = MovingAxis(0.0, 16.0, 64, (0.6, 0.9), (2.0, 3.0), 3, 2)
    for low in np.linspace(3.0, 5.0, 41):
        layout = axis.layout_for(low, low + 1.1)
        back = axis.layout_for(low - 1e-3, low + 1.1 - 1e-3, layout)
        assert axis.layout_for(low, low + 1.1, back) == back
    far = axis.layout_for(9.0, 10.1, axis.layout_for(3.0, 4.1))
    assert far == axis.layout_for(9.0, 10.1)


def test_without_grading_or_window_all_of_the_axis_is_there():
    assert MovingAxis(0.0, 3.2, 16, None, (2.0, 2.0), 2, 2).layout_for(1.5, 1.7) == AxisLayout((0, 16), (0, 16))
    assert MovingAxis(0.0, 3.2, 16, None, (0.3, 0.3), 2, 2).layout_for(1.5, 1.7) == AxisLayout((4, 12), (4, 12))
    axis = MovingAxis(0.0, 3.2, 16, (0.2, 0.2), None, 2, 1)
    layout = axis.layout_for(1.5, 1.7)
    assert layout.window == (0, 16)
    np.testing.assert_array_equal(np.diff(axis.node_numbers(layout)), [4, 2, 1, 1, 1, 1, 2, 4])
