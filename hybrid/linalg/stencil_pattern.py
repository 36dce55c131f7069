"""Numbering of the unknowns and sparsity of the soil block.

Only displacement components of nodes that carry mass and are not held are unknowns. Two nodes are coupled when some
point may see both: they lie within two cells of each other along every axis, a 5x5x5 stencil. That pattern depends on
the set of active nodes alone, so it is kept for as long as the set stays the same, however the points move.

All free components of a node are numbered in sequence and its rows share one layout, hence an entry is found without
a search:  values[indptr[dof[v, i]] + slot[row[v], stencil(w - v)] + (rank of component k among the free ones of w)].
"""

from dataclasses import dataclass

import numpy as np
from numba import njit, prange


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

    @property
    def size(self):
        """Number of soil unknowns."""
        return len(self.indptr) - 1


def make_pattern(active, fixed, shape):
    """Pattern for active nodes (N,) bool and held components (N, 3) bool on a grid of `shape` nodes."""
    free = active[:, None] & ~fixed
    dof = np.full(free.shape, -1, np.int32)
    dof[free] = np.arange(np.count_nonzero(free))
    row = np.full(len(active), -1, np.int32)
    nodes = np.nonzero(free.any(axis=1))[0]
    row[nodes] = np.arange(len(nodes))
    slot = np.full((len(nodes), 125), -1, np.int32)
    indptr = np.zeros(np.count_nonzero(free) + 1, np.int32)
    width = _fill_slots(nodes, free, shape[0], shape[1], shape[2], slot)
    indptr[1:] = np.cumsum(np.repeat(width, free[nodes].sum(axis=1)))
    indices = np.empty(indptr[-1], np.int32)
    _fill_indices(nodes, dof, shape[1], shape[2], slot, indptr, indices)
    return Pattern(dof, row, slot, indptr, indices, free, diagonal_places(indptr, indices))


@njit(cache=True, parallel=True)
def diagonal_places(indptr, indices):
    """Places (n,) of the diagonal among the entries of compressed rows that are in order and all have one."""
    places = np.empty(len(indptr) - 1, np.int64)
    for i in prange(len(places)):
        places[i] = indptr[i] + np.searchsorted(indices[indptr[i]:indptr[i + 1]], i)
    return places


@njit(cache=True, parallel=True)
def _fill_slots(nodes, free, nx, ny, nz, slot):
    width = np.zeros(len(nodes), np.int32)
    for r in prange(len(nodes)):
        v = nodes[r]
        i, j, k = v // (ny * nz), v // nz % ny, v % nz
        taken = 0
        for s in range(125):
            a, b, c = i + s // 25 - 2, j + s // 5 % 5 - 2, k + s % 5 - 2
            if 0 <= a < nx and 0 <= b < ny and 0 <= c < nz:
                w = (a * ny + b) * nz + c
                components = 0
                for q in range(3):
                    components += free[w, q]
                if components > 0:
                    slot[r, s] = taken
                    taken += components
        width[r] = taken
    return width


@njit(cache=True, parallel=True)
def _fill_indices(nodes, dof, ny, nz, slot, indptr, indices):
    for r in prange(len(nodes)):
        v = nodes[r]
        for i in range(3):
            if dof[v, i] < 0:
                continue
            at = indptr[dof[v, i]]
            for s in range(125):
                if slot[r, s] < 0:
                    continue
                w = v + ((s // 25 - 2) * ny + s // 5 % 5 - 2) * nz + s % 5 - 2
                for k in range(3):
                    if dof[w, k] >= 0:
                        indices[at] = dof[w, k]
                        at += 1
