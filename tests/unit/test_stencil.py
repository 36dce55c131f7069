"""Numbers of nodes, places in the stencil and entries of the matrix: each way there leads back."""

import itertools

import numpy as np

from hybrid.grid.numbering import node_indices, node_number
from hybrid.linalg import stencil
from hybrid.linalg.stencil import CELL, CENTRE, PLACES, REACH, SPAN, entry, local_number, relative_place
from hybrid.linalg.stencil_pattern import make_pattern

OFFSETS = list(itertools.product(range(-REACH, REACH + 1), repeat=3))


def place_of_offset(*offset):
    """Place of the node at an offset."""
    return local_number(*offset) + CENTRE


def in_stencil(*offset):
    """Whether two nodes at an offset are coupled by entries of the matrix."""
    return np.abs(offset).max() <= REACH


def test_node_numbers_are_those_of_a_raveled_array():
    shape = (4, 5, 6)
    number = np.arange(np.prod(shape)).reshape(shape)
    for index in itertools.product(*map(range, shape)):
        assert node_number(shape, *index) == number[index] and node_indices(shape, number[index]) == index
    assert node_number(shape, 3, 1, 2) - node_number(shape, 1, 4, 3) == node_number(shape, 2, -3, -1)


def test_places_are_those_of_the_offsets():
    assert [place_of_offset(*offset) for offset in OFFSETS] == list(range(PLACES))
    assert [stencil.offset_of_place(s) for s in range(PLACES)] == OFFSETS
    assert place_of_offset(0, 0, 0) == CENTRE and PLACES == SPAN**3
    assert all(in_stencil(*offset) for offset in OFFSETS)
    far = (REACH + 1) * np.eye(3, dtype=int)
    assert not any(in_stencil(*offset) for offset in [*far, *-far])


def test_places_of_nodes_of_one_cell():
    """CELL is in the order of the corners' bits 4, 2, 1 for x, y, z, as the hat functions of a corner are."""
    for (a, v), (b, w) in itertools.product(enumerate(CELL), repeat=2):
        offset = [(b >> bit & 1) - (a >> bit & 1) for bit in (2, 1, 0)]
        assert relative_place(v, w) == place_of_offset(*offset)
    assert relative_place(local_number(1, 2, 0), local_number(0, 2, 1)) == place_of_offset(-1, 0, 1)


def test_entries_are_those_of_the_pattern():
    """Column by column: the entries of two nodes are in consecutive places, one for each free component."""
    shape, rng = (4, 3, 3), np.random.default_rng(1)
    active, fixed = rng.random(36) < 0.8, rng.random((36, 3)) < 0.3
    pattern = make_pattern(active, fixed, shape)
    found = 0
    for v, w in itertools.product(np.flatnonzero(active), repeat=2):
        offset = np.subtract(node_indices(shape, w), node_indices(shape, v))
        if not in_stencil(*offset) or pattern.row[v] < 0 or pattern.row[w] < 0:
            continue
        columns = [pattern.dof[w, k] for k in range(3) if pattern.dof[w, k] >= 0]
        for i in np.flatnonzero(pattern.dof[v] >= 0):
            at = entry(pattern.sparsity, v, i, place_of_offset(*offset))
            assert pattern.indices[at:at + len(columns)].tolist() == columns
            assert pattern.indptr[pattern.dof[v, i]] <= at < pattern.indptr[pattern.dof[v, i] + 1]
            found += len(columns)
    assert found == len(pattern.indices)
