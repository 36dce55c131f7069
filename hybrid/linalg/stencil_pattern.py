"""Numbering of the unknowns and sparsity of the soil block.

Only displacement components of nodes that carry mass and are not held are unknowns. Two nodes are coupled when some
point may see both: they lie within two cells of each other along every axis, a 5x5x5 stencil. That pattern depends on
the set of active nodes alone, so it is kept for as long as the set stays the same, however the points move.

All free components of a node are numbered in sequence and its rows share one layout, hence an entry is found without
a search:  values[indptr[dof[v, i]] + slot[row[v], stencil(w - v)] + (rank of component k among the free ones of w)].
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import njit, prange

from hybrid.grid.numbering import node_indices, node_number
from hybrid.linalg.stencil import PLACES, Sparsity, offset_of_place
from hybrid.runtime.errors import SceneError

LIMIT = np.iinfo(np.int32).max      # of unknowns and entries: PETSc's indices, and ours, have 32 bits


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
        """What kernels need to find an entry."""
        return Sparsity(self.dof, self.row, self.slot, self.indptr)

    @property
    def size(self):
        """Number of soil unknowns."""
        return len(self.indptr) - 1


def make_pattern(active, fixed, shape):
    """Pattern for active nodes (N,) bool and held components (N, 3) bool on a grid of `shape` nodes.

    Raises SceneError when unknowns or entries are more than index arrays of 32 bits can number, before memory for them
    is allocated.
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

    Where the largest possible number of entries is within LIMIT, that number, which takes no time, else the exact one.
    """
    unknowns = int(np.count_nonzero(free))
    bound = 3 * PLACES * unknowns
    return unknowns, bound if bound <= LIMIT else int(_count_entries(free, tuple(shape)))


def check_size(unknowns, entries):
    """Raises SceneError when there are more than LIMIT unknowns or entries of the soil block."""
    for count, what in ((unknowns, "unknowns"), (entries, "entries")):
        if count > LIMIT:
            raise SceneError(f"the matrix of the soil has {count} {what}, the limit is {LIMIT} (indices of 32 bits); use "
                             "larger cells far from the body (grid.x.fine, grid.x.growth), larger cells everywhere "
                             "(grid.x.size), or a shorter axis; y and z alike")


@njit(cache=True)
def _count_entries(free, shape):
    """Number of entries, in 64 bits, of rows (v, i) for free components (N, 3) bool."""
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
    """Places (n,) of the diagonal among the entries of compressed rows that are in order and all have one."""
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
