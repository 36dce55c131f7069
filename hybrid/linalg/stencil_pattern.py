"""Numbering of the unknowns and sparsity of the soil block.

The unknowns are the displacement components of nodes with mass that are not fixed. Two nodes are coupled if the domain
of one point can reach both: their indices differ by at most two along every axis, a 5x5x5 stencil. The pattern depends
on the set of active nodes only, so it is reused while that set is unchanged, however the points move.

The free components of a node have consecutive numbers and its rows have the same layout, so an entry is located without
a search:  values[indptr[dof[v, i]] + slot[row[v], stencil(w - v)] + (rank of component k among the free ones of w)].
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from math import prod

import numpy as np

from hybrid.grid.numbering import node_indices, node_number
from hybrid.linalg.stencil import PLACES, REACH, Sparsity, offset_of_place
from hybrid.runtime.errors import SceneError
from hybrid.runtime.jit import njit, prange

LIMIT = np.iinfo(np.int32).max      # largest number of unknowns and of entries: indices have 32 bits


@dataclass(frozen=True)
class Pattern:
    """dof: (N, 3) unknown number or -1; row: (N,) number among active nodes or -1; slot: (active, 125) offset in the
    row or -1; indptr, indices: compressed rows; free: (N, 3) bool, the unknowns in the order of their numbers;
    diagonal: (size,) place of each unknown's diagonal entry."""

    dof: np.ndarray
    row: np.ndarray
    slot: np.ndarray
    indptr: np.ndarray
    indices: np.ndarray
    free: np.ndarray
    diagonal: np.ndarray

    @cached_property
    def sparsity(self):
        """Arrays with which kernels locate an entry."""
        return Sparsity(self.dof, self.row, self.slot, self.indptr)

    @property
    def size(self):
        """Number of soil unknowns."""
        return len(self.indptr) - 1


def make_pattern(active, fixed, shape):
    """Pattern for active nodes (N,) bool and fixed components (N, 3) bool on a grid of `shape` nodes.

    Raises SceneError, before memory is allocated, when there are more unknowns or entries than indices of 32 bits can
    number.
    """
    free = active[:, None] & ~fixed
    check_size(*count_unknowns_and_entries(free, shape))
    dof = np.full(free.shape, -1, np.int32)
    dof[free] = np.arange(np.count_nonzero(free))
    row = np.full(len(active), -1, np.int32)
    nodes = np.nonzero(free.any(axis=1))[0]
    row[nodes] = np.arange(len(nodes))
    slot = np.full((len(nodes), PLACES), -1, np.int32)
    indptr = np.zeros(np.count_nonzero(free) + 1, np.int32)
    width = _fill_slots(nodes, free, shape, slot)
    indptr[1:] = np.cumsum(np.repeat(width, free[nodes].sum(axis=1)), dtype=np.int64)
    indices = np.empty(indptr[-1], np.int32)
    _fill_indices(nodes, shape, Sparsity(dof, row, slot, indptr), indices)
    return Pattern(dof, row, slot, indptr, indices, free, diagonal_places(indptr, indices))


def count_unknowns_and_entries(free, shape):
    """Numbers of unknowns and of entries for free components (N, 3) bool on a grid of `shape` nodes.

    The number of entries is its upper bound, which costs nothing, if that is within LIMIT, else the exact number.
    """
    unknowns = int(np.count_nonzero(free))
    bound = 3 * PLACES * unknowns
    return unknowns, bound if bound <= LIMIT else int(_count_entries(free, tuple(shape)))


@dataclass(frozen=True)
class Sizes:
    """Numbers of nodes with unknowns, of unknowns and of entries of the soil block."""

    nodes: int
    unknowns: int
    entries: int


def sizes_of_box(planes):
    """Sizes of the pattern of a box of nodes, which is not made. planes: (n, 3) bool of each axis, components that are
    free in each of its planes of nodes; those of a node are free in all of its three planes."""
    def nodes_with(components):
        return prod(int(np.count_nonzero(plane[:, components].all(axis=1))) for plane in planes)

    def coupled(one, other):
        around = np.ones(2 * REACH + 1, int)
        return prod(int(np.convolve(plane[:, other], around)[REACH:-REACH] @ plane[:, one]) for plane in planes)

    subsets = [list(chosen) for k in (1, 2, 3) for chosen in combinations(range(3), k)]
    return Sizes(sum((-1) ** (len(chosen) + 1) * nodes_with(chosen) for chosen in subsets),
                 sum(nodes_with([k]) for k in range(3)), sum(coupled(k, q) for k in range(3) for q in range(3)))


def check_size(unknowns, entries):
    """Raises SceneError when the soil block has more than LIMIT unknowns or entries."""
    for count, what in ((unknowns, "unknowns"), (entries, "entries")):
        if count > LIMIT:
            raise SceneError(f"the matrix of the soil has {count} {what}, the limit is {LIMIT} (indices of 32 bits); "
                             "use larger cells far from the body (grid.x.fine, grid.x.growth), larger cells everywhere "
                             "(grid.x.size), or a shorter axis (grid.x.end), along y and z as well as x")


@njit(cache=True)
def _count_entries(free, shape):
    """Number of entries for free components (N, 3) bool, as an integer of 64 bits."""
    entries = np.int64(0)
    for v in range(len(free)):
        rows = free[v].sum()
        if rows == 0:
            continue
        i, j, k = node_indices(shape, v)
        for s in range(PLACES):
            di, dj, dk = offset_of_place(s)
            if 0 <= i + di < shape[0] and 0 <= j + dj < shape[1] and 0 <= k + dk < shape[2]:
                entries += rows * free[v + node_number(shape, di, dj, dk)].sum()
    return entries


@njit(cache=True, parallel=True)
def diagonal_places(indptr, indices):
    """Indices (n,) of the diagonal entries among the values of compressed rows; rows are sorted and contain theirs."""
    places = np.empty(len(indptr) - 1, np.int64)
    for i in prange(len(places)):
        places[i] = indptr[i] + np.searchsorted(indices[indptr[i]:indptr[i + 1]], i)
    return places


@njit(cache=True, parallel=True)
def _fill_slots(nodes, free, shape, slot):
    width = np.zeros(len(nodes), np.int32)
    for r in prange(len(nodes)):
        v = nodes[r]
        i, j, k = node_indices(shape, v)
        used = 0
        for s in range(PLACES):
            di, dj, dk = offset_of_place(s)
            if 0 <= i + di < shape[0] and 0 <= j + dj < shape[1] and 0 <= k + dk < shape[2]:
                w = v + node_number(shape, di, dj, dk)
                components = 0
                for q in range(3):
                    components += free[w, q]
                if components > 0:
                    slot[r, s] = used
                    used += components
        width[r] = used
    return width


@njit(cache=True, parallel=True)
def _fill_indices(nodes, shape, sparsity, indices):
    dof, slot, indptr = sparsity.dof, sparsity.slot, sparsity.indptr
    for r in prange(len(nodes)):
        v = nodes[r]
        for i in range(3):
            if dof[v, i] < 0:
                continue
            at = indptr[dof[v, i]]
            for s in range(PLACES):
                if slot[r, s] < 0:
                    continue
                di, dj, dk = offset_of_place(s)
                w = v + node_number(shape, di, dj, dk)
                for k in range(3):
                    if dof[w, k] >= 0:
                        indices[at] = dof[w, k]
                        at += 1
