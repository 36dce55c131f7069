"""GIMP basis: what its values and slopes reproduce, its limits, and those of domains that follow the deformation."""

import numpy as np
import pytest
from scattered_points import COUNT, GRIDS, UNIFORM, clear_of_nodes, scattered

from hybrid.runtime.errors import StepError
from hybrid.soil.basis import SNAP, evaluate_basis
from hybrid.soil.domains import THINNEST, updated_half


def dense(basis, axes, axis):
    """Values and slopes (n, nodes) of one axis."""
    value, slope = (np.zeros((len(basis.first), len(axes[axis]))) for _ in range(2))
    for a in range(3):
        used = np.flatnonzero(a < basis.count[:, axis])
        value[used, basis.first[used, axis] + a] = basis.value[used, axis, a]
        slope[used, basis.first[used, axis] + a] = basis.gradient[used, axis, a]
    return value, slope


@pytest.mark.parametrize("name", GRIDS)
@pytest.mark.parametrize("standard", [False, True])
def test_partition_of_unity_and_linear_reproduction(name, standard):
    axes = GRIDS[name]
    position, half = scattered(axes)
    half *= not standard
    basis = evaluate_basis(position, half, axes)
    assert basis.count.max() <= 3 and (standard or basis.count.max() == 3)
    for axis, nodes in enumerate(axes):
        value, slope = dense(basis, axes, axis)
        assert value.min() >= 0.0
        assert np.abs(value.sum(axis=1) - 1).max() < 1e-12
        assert np.abs(value @ nodes - position[:, axis]).max() < 1e-12
        assert np.abs(slope.sum(axis=1)).max() < 1e-12
        assert np.abs(slope @ nodes - 1).max() < 1e-12


@pytest.mark.parametrize("name", GRIDS)
def test_slope_is_the_derivative_of_the_value(name):
    """Between places where a domain's end meets a node the value is a quadratic: differences are exact."""
    axes = GRIDS[name]
    position, half = scattered(axes, narrowest=0.1)
    clear = clear_of_nodes(position, half, axes, 2e-4)
    position, half = position[clear], half[clear]
    for axis, nodes in enumerate(axes):
        h = 1e-4 * np.diff(nodes).min()
        step = h * np.eye(3)[axis]
        high, low = (dense(evaluate_basis(position + s * step, half, axes), axes, axis)[0] for s in (1, -1))
        slope = dense(evaluate_basis(position, half, axes), axes, axis)[1]
        assert np.abs((high - low) / (2 * h) - slope).max() < 1e-9


def test_no_width_is_the_standard_material_point_method():
    axes = GRIDS["graded"]
    position, _ = scattered(axes)
    basis = evaluate_basis(position, np.zeros_like(position), axes)
    for axis, nodes in enumerate(axes):
        value, slope = dense(basis, axes, axis)
        hats = np.array([np.interp(position[:, axis], nodes, unit) for unit in np.eye(len(nodes))]).T
        assert np.abs(value - hats).max() < 1e-13
        cell = np.searchsorted(nodes, position[:, axis]) - 1
        rows = np.arange(COUNT)
        np.testing.assert_allclose(slope[rows, cell], -1 / np.diff(nodes)[cell], rtol=1e-14)
        np.testing.assert_allclose(slope[rows, cell + 1], 1 / np.diff(nodes)[cell], rtol=1e-14)


@pytest.mark.parametrize("width", [1e-2, 1e-3, 1e-4])
def test_narrow_domains_tend_to_the_standard_method(width):
    """Inside a cell the two agree; on a node of cells a, b they differ by l/4 (1/a + 1/b) at that node."""
    axes = GRIDS["graded"]
    position, _ = scattered(axes)
    half = width * np.array([np.diff(nodes).min() for nodes in axes]) * np.ones((COUNT, 1))
    inside = clear_of_nodes(position, 0 * half, axes, 2 * width)
    narrow, standard = evaluate_basis(position, half, axes), evaluate_basis(position, 0 * half, axes)
    nodes = axes[0]
    for a, b in zip(dense(narrow, axes, 0), dense(standard, axes, 0)):
        assert np.abs(a - b)[inside].max() < 1e-10
    place, l = position[:1].copy(), half[0, 0]
    place[0, 0] = nodes[4]
    value = dense(evaluate_basis(place, half[:1], axes), axes, 0)[0][0, 4]
    left, right = np.diff(nodes)[3:5]
    assert 1 - value == pytest.approx(l / 4 * (1 / left + 1 / right), rel=1e-9)


def test_a_hair_thin_overlap_is_cut_off():
    """Domain ends within SNAP of a node count as being on it: the cell beyond carries nothing."""
    nodes = np.linspace(0.0, 4.0, 5)
    axes = (nodes, nodes, nodes)
    half = np.full((1, 3), 0.25)
    for overlap, first, count in ((0.5 * SNAP, 1, 2), (2 * SNAP, 0, 3)):
        basis = evaluate_basis(np.full((1, 3), 1.25 - overlap), half, axes)
        assert basis.first[0, 0] == first and basis.count[0, 0] == count
        value, slope = dense(basis, axes, 0)
        assert abs(value.sum() - 1) < 1e-14 and abs(slope @ nodes - 1) < 1e-12
        assert abs(value @ nodes - (1.25 - overlap)) < SNAP


def test_collapsed_axis_is_a_constant():
    axes = (UNIFORM[0], np.array([0.5]), UNIFORM[2])
    position, half = scattered(UNIFORM)
    position[:, 1] = 37.0   # wherever: the axis has no extent of its own
    basis = evaluate_basis(position, half, axes)
    assert np.all(basis.first[:, 1] == 0) and np.all(basis.count[:, 1] == 1)
    assert np.all(basis.value[:, 1, 0] == 1.0) and not basis.gradient[:, 1].any()
    full = evaluate_basis(scattered(UNIFORM)[0], half, UNIFORM)
    assert np.array_equal(basis.value[:, [0, 2]], full.value[:, [0, 2]])


@pytest.mark.parametrize("axis, x", [(0, 2.01), (1, -1.2), (2, 1.95), (0, np.nan)])
def test_a_point_that_leaves_the_grid_stops_the_step(axis, x):
    position, half = np.full((3, 3), 0.5), np.full((3, 3), 0.1)
    position[1, axis] = x
    name = "xyz"[axis]
    message = rf"point 1 at {name} = .*left the grid \[-1, 2\] m; enlarge grid\.{name}"
    with pytest.raises(StepError, match=message):
        evaluate_basis(position, half, UNIFORM)


def test_a_domain_that_fills_its_cell_at_the_end_of_the_grid_is_inside():
    basis = evaluate_basis(np.array([[1.875, 0.5, 0.5]]), np.array([[0.125, 0.1, 0.1]]), UNIFORM)
    assert basis.first[0, 0] == 11 and basis.count[0, 0] == 2


def test_domains_are_capped():
    """No wider than the cell of the centre, inside the grid, not thinner than a thousandth of the start."""
    axes = (UNIFORM[0], np.array([0.5]), UNIFORM[2])
    initial = np.full((3, 3), 0.1)
    position = np.array([[0.3, 0.5, 0.3], [-0.96, 0.5, 1.9], [0.3, 0.5, 0.3]])
    F = np.array([5.0 * np.eye(3), 1.5 * np.eye(3), np.diag([1.0, 1.0, 1e-6])])
    half = updated_half("moments", initial, F, position, axes)
    np.testing.assert_allclose(half[0], [0.125, 0.1, 0.5], rtol=1e-12)          # cells of 0.25 and 1.0
    np.testing.assert_allclose(half[1], [0.04, 0.1, 0.1], rtol=1e-12)           # the ends of the grid
    np.testing.assert_allclose(half[2], [0.1, 0.1, THINNEST * 0.1], rtol=1e-12)
    evaluate_basis(position, half, axes)
