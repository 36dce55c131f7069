"""Node coordinates and held faces of the background grid."""

import numpy as np
import pytest

from hybrid.grid.axes import graded_nodes, make_grid, uniform_nodes
from hybrid.runtime.errors import SceneError

FREE = dict.fromkeys(("x_min", "x_max", "y_min", "y_max", "z_min", "z_max"), "free")
EXTENT = np.array([(0.0, 2.0), (0.0, 1.5), (-1.0, 0.0)])
AXES = (np.linspace(0, 2, 5), np.linspace(0, 1.5, 4), np.linspace(-1, 0, 3))


def ratios(nodes):
    cells = np.diff(nodes)
    return np.maximum(cells[1:] / cells[:-1], cells[:-1] / cells[1:])


@pytest.mark.parametrize("size, cells", [(0.5, 4), (0.3, 7), (2.0, 1), (9.0, 1), (0.1, 20)])
def test_uniform_cells_are_equal_and_no_larger_than_asked(size, cells):
    nodes = uniform_nodes(-0.5, 1.5, size)
    assert len(nodes) == cells + 1 and nodes[0] == -0.5 and nodes[-1] == 1.5
    np.testing.assert_allclose(np.diff(nodes), 2.0 / cells, rtol=1e-13)


def test_a_size_with_six_digits_makes_no_cell_more():
    """39 cells of 1/12 m are 39.00002 of 0.0833333 m; a thousandth of a cell is no rounding."""
    assert len(uniform_nodes(0.0, 3.25, 0.0833333)) == 40 and len(uniform_nodes(0.0, 3.25, 0.08333)) == 41
    nodes = graded_nodes(0.0, 3.25 + 5e-6, 0.0833333, (0.0, 3.25), 1.3)
    assert len(nodes) == 40 and nodes[-1] == 3.25 + 5e-6


@pytest.mark.parametrize("growth", [1.05, 1.3, 2.0])
@pytest.mark.parametrize("fine", [(-0.4, 0.8), (-3.0, 0.8), (-0.4, 5.0)])
def test_graded_cells_keep_size_growth_and_ends(fine, growth):
    size, start, end = 0.1, -3.0, 5.0
    nodes = graded_nodes(start, end, size, fine, growth)
    assert nodes[0] == start and nodes[-1] == end and np.all(np.diff(nodes) > 0)
    assert ratios(nodes).max() <= growth * (1 + 1e-9)
    inside = (nodes > fine[0] - 1e-9) & (nodes < fine[1] + 1e-9)
    np.testing.assert_allclose(np.diff(nodes[inside]), size, rtol=1e-12)
    np.testing.assert_allclose(nodes[inside][[0, -1]], fine, atol=1e-12)
    outside = np.diff(nodes[nodes > fine[1] - 1e-9])
    if len(outside) > 1:
        assert np.ptp(outside[1:] / outside[:-1]) < 1e-9   # one ratio throughout, end cell included


def test_graded_uses_the_fewest_cells():
    """With one cell less, growth would have to exceed its limit."""
    nodes = graded_nodes(0.0, 10.0, 0.1, (0.0, 0.1), 1.3)
    fewer = len(nodes) - 3
    assert 0.1 * np.sum(1.3 ** np.arange(1, fewer + 1)) < 9.9


def test_neighbouring_cells_beyond_a_factor_of_two_are_refused():
    limit = np.array([0.0, 1.0, 3.0, 7.0])
    make_grid((limit, *AXES[1:]), EXTENT, FREE)
    with pytest.raises(SceneError, match=r"grid\.x.*factor of 2\.5, the limit is 2.*growth.*fine"):
        make_grid((np.array([0.0, 1.0, 3.5]), *AXES[1:]), EXTENT, FREE)
    with pytest.raises(SceneError, match=r"grid\.z.*factor of 4"):
        make_grid((*AXES[:2], np.array([-1.0, -0.2, 0.0])), EXTENT, FREE)


def test_a_sliver_next_to_the_fine_region_is_refused():
    nodes = graded_nodes(0.0, 1.03, 0.1, (0.0, 1.0), 1.3)
    with pytest.raises(SceneError, match="neighbouring cells"):
        make_grid((nodes, *AXES[1:]), EXTENT, FREE)


@pytest.mark.parametrize("face, axis, layer", [
    ("x_min", 0, 0), ("x_max", 0, -1), ("y_min", 1, 0), ("y_max", 1, -1), ("z_min", 2, 0), ("z_max", 2, -1)])
def test_faces_hold_what_they_say(face, axis, layer):
    shape = tuple(map(len, AXES))
    layer_of = np.indices(shape)[axis].ravel() == np.arange(shape[axis])[layer]
    assert not make_grid(AXES, EXTENT, FREE).fixed.any()
    roller = make_grid(AXES, EXTENT, FREE | {face: "roller"}).fixed
    assert np.array_equal(roller[:, axis], layer_of) and not np.delete(roller, axis, axis=1).any()
    fixed = make_grid(AXES, EXTENT, FREE | {face: "fixed"}).fixed
    assert np.array_equal(fixed, np.repeat(layer_of[:, None], 3, axis=1))
    assert make_grid(AXES, EXTENT, FREE, all_fixed=True).fixed.all()


def test_nodes_are_numbered_with_z_fastest():
    grid = make_grid(AXES, EXTENT, FREE | {"z_max": "roller"})
    assert grid.shape == (5, 4, 3) and grid.node_count == 60
    assert np.array_equal(np.flatnonzero(grid.fixed[:, 2]), np.arange(2, 60, 3))
    assert grid.smallest_cell == 0.5


def test_every_node_has_half_of_the_cells_around_it():
    grid = make_grid(AXES, EXTENT, FREE)
    whole = np.prod(np.ptp(grid.extent, axis=1))
    assert grid.volumes.sum() == pytest.approx(whole, rel=1e-14)
    edges = [np.concatenate([[a[0]], 0.5 * (a[1:] + a[:-1]), [a[-1]]]) for a in AXES]
    for node, (i, j, k) in enumerate(np.ndindex(grid.shape)):
        volume = np.prod([e[n + 1] - e[n] for e, n in zip(edges, (i, j, k))])
        assert grid.volumes[node] == pytest.approx(volume, rel=1e-14)
    plane = make_grid((AXES[0], np.array([0.75]), AXES[2]), EXTENT, FREE)
    assert plane.volumes.sum() == pytest.approx(whole, rel=1e-14)


def test_collapsed_axis_is_held_and_has_one_node():
    grid = make_grid((AXES[0], np.array([0.75]), AXES[2]), EXTENT, FREE)
    assert grid.shape == (5, 1, 3) and np.array_equal(grid.collapsed, [False, True, False])
    assert grid.fixed[:, 1].all() and not grid.fixed[:, [0, 2]].any()
    assert np.array_equal(grid.extent[1], [0.0, 1.5])
