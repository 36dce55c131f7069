"""Numbering and sparsity of the soil block against a brute-force construction."""

import numpy as np
import pytest
from scipy import sparse

from hybrid.linalg import stencil_pattern
from hybrid.linalg.precond_pattern import reduced_entries
from hybrid.linalg.stencil_pattern import make_pattern, sizes_of_box
from hybrid.runtime.errors import SceneError


def brute_force(active, fixed, shape):
    """Couplings of all free components of active nodes within two nodes of each other, as scipy sees them."""
    near = [sparse.diags([np.ones(n - abs(k)) for k in range(-2, 3) if abs(k) < n],
                         [k for k in range(-2, 3) if abs(k) < n]) for n in shape]
    nodes = sparse.kron(sparse.kron(near[0], near[1]), near[2])
    free = np.flatnonzero((active[:, None] & ~fixed).ravel())
    matrix = sparse.kron(nodes, np.ones((3, 3))).tocsr()[free][:, free]
    matrix.eliminate_zeros()
    matrix.sort_indices()
    return matrix


def case(name):
    rng = np.random.default_rng(11)
    shape = {"one cell": (2, 2, 2), "plane": (7, 1, 6), "column": (1, 1, 9)}.get(name, (5, 4, 6))
    nodes = int(np.prod(shape))
    active, fixed = np.ones(nodes, bool), np.zeros((nodes, 3), bool)
    if name != "all free":
        active = rng.random(nodes) < 0.7
        fixed = rng.random((nodes, 3)) < 0.3
    if name in ("plane", "column"):
        fixed[:, 1] = True
    return active, fixed, shape


CASES = ["all free", "scattered", "one cell", "plane", "column"]


@pytest.mark.parametrize("name", CASES)
def test_pattern_equals_brute_force(name):
    active, fixed, shape = case(name)
    pattern, expected = make_pattern(active, fixed, shape), brute_force(active, fixed, shape)
    assert pattern.size == expected.shape[0]
    assert np.array_equal(pattern.indptr, expected.indptr)
    assert np.array_equal(pattern.indices, expected.indices)   # hence sorted and without repetition


@pytest.mark.parametrize("name", CASES)
def test_only_active_free_components_are_unknowns(name):
    active, fixed, shape = case(name)
    pattern = make_pattern(active, fixed, shape)
    unknown = active[:, None] & ~fixed
    assert np.array_equal(pattern.free, unknown) and np.array_equal(pattern.dof >= 0, unknown)
    assert np.array_equal(pattern.dof[unknown], np.arange(pattern.size))
    with_row = unknown.any(axis=1)
    assert np.array_equal(pattern.row >= 0, with_row)
    assert np.array_equal(pattern.row[with_row], np.arange(with_row.sum()))


@pytest.mark.parametrize("name", CASES)
def test_diagonal_and_entries_are_where_they_are_said_to_be(name):
    active, fixed, shape = case(name)
    pattern = make_pattern(active, fixed, shape)
    row_of = np.repeat(np.arange(pattern.size), np.diff(pattern.indptr))
    assert np.array_equal(pattern.indices[pattern.diagonal], np.arange(pattern.size))
    assert np.array_equal(row_of[pattern.diagonal], np.arange(pattern.size))
    place = np.array(np.unravel_index(np.arange(len(active)), shape)).T
    used = np.flatnonzero(pattern.row >= 0)
    for v in used:
        for w in used[np.abs(place[used] - place[v]).max(axis=1) <= 2]:
            apart = place[w] - place[v]
            start = pattern.slot[pattern.row[v], (apart + 2) @ (25, 5, 1)]
            for i in np.flatnonzero(pattern.free[v]):
                entries = pattern.indptr[pattern.dof[v, i]] + start + np.arange(pattern.free[w].sum())
                assert np.array_equal(pattern.indices[entries], pattern.dof[w][pattern.free[w]])


@pytest.mark.parametrize("name", CASES)
def test_reduced_entries_are_of_one_cell_or_in_columns_of_nodes_with_small_support(name):
    active, fixed, shape = case(name)
    small = np.random.default_rng(3).random(len(active)) < 0.2
    node = np.nonzero(active[:, None] & ~fixed)[0]
    place = np.array(np.unravel_index(node, shape)).T
    pattern = make_pattern(active, fixed, shape)
    for small in (np.zeros(len(active), bool), small):
        row = np.repeat(np.arange(pattern.size), np.diff(pattern.indptr))
        expected = np.abs(place[row] - place[pattern.indices]).max(axis=1, initial=0) <= 1
        expected |= small[node[pattern.indices]]
        assert np.array_equal(reduced_entries(pattern, shape, small), expected)


def test_nothing_active():
    pattern = make_pattern(np.zeros(8, bool), np.zeros((8, 3), bool), (2, 2, 2))
    assert pattern.size == 0 and len(pattern.indices) == 0 and len(pattern.diagonal) == 0


@pytest.mark.parametrize("name", CASES)
def test_entries_are_counted_before_they_are_allocated(name, monkeypatch):
    """The bound where it is within the limit, the exact number where it is not."""
    active, fixed, shape = case(name)
    free, pattern = active[:, None] & ~fixed, make_pattern(active, fixed, shape)
    bound = 3 * 125 * pattern.size
    assert stencil_pattern.count_unknowns_and_entries(free, shape) == (pattern.size, bound)
    monkeypatch.setattr(stencil_pattern, "LIMIT", bound - 1)
    assert stencil_pattern.count_unknowns_and_entries(free, shape) == (pattern.size, len(pattern.indices))


def test_too_many_entries_or_unknowns_are_refused(monkeypatch):
    """At the limit of 32 bits; and by make_pattern before it allocates, shown with a lower limit."""
    stencil_pattern.check_size(2**31 - 1, 2**31 - 1)
    for unknowns, entries, what in ((2**31, 1, "2147483648 unknowns"), (1, 2**31, "2147483648 entries")):
        with pytest.raises(SceneError, match=f"{what}, the limit is 2147483647.*grid.x.size"):
            stencil_pattern.check_size(unknowns, entries)
    active, fixed, shape = case("all free")
    monkeypatch.setattr(stencil_pattern, "LIMIT", len(make_pattern(active, fixed, shape).indices) - 1)
    monkeypatch.setattr(stencil_pattern, "_fill_slots", None)
    with pytest.raises(SceneError, match="entries, the limit is"):
        make_pattern(active, fixed, shape)


@pytest.mark.parametrize("shape", [(5, 4, 6), (2, 2, 2), (7, 1, 6), (1, 1, 9)])
def test_sizes_of_a_box_of_nodes_are_those_of_its_pattern(shape):
    """Whose planes hold some components or none, and carry soil or not."""
    rng = np.random.default_rng(3)
    for _ in range(5):
        planes = [rng.random((n, 3)) < 0.8 for n in shape]
        x, y, z = planes
        free = (x[:, None, None] & y[:, None] & z).reshape(-1, 3)
        pattern, found = make_pattern(np.ones(len(free), bool), ~free, shape), sizes_of_box(planes)
        assert (found.nodes, found.unknowns, found.entries) == (free.any(axis=1).sum(), pattern.size, len(pattern.indices))
