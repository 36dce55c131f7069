"""Entries of the soil block from which its preconditioner, an incomplete factor or sweeps, is computed.

A point whose domain overlaps two cells couples nodes two cells apart. These entries are three quarters of all entries
but small, so they are omitted, except in the columns of nodes with small support (`hybrid.soil.model.SMALL_SUPPORT`):
the few points around such a node couple it with distant nodes as strongly as with its neighbours. About one node in
twenty has small support. Krylov iterations with an incomplete factor, sand in front of an anchor, 120 000 unknowns, to
1e-2:

| columns kept: nodes with less than this share of their mass in filled cells  | iterations  | million entries of 40 |
|------------------------------------------------------------------------------|-------------|-----------------------|
| none                                                                         | 150 or more | 9.0                   |
| 0.01                                                                         | 61          | 9.7                   |
| 0.1                                                                          | 9           | 10.3                  |
| 0.5                                                                          | 6           | 12                    |

Keeping the rows of these nodes instead is equally effective. Iterations without and with their columns, for a block of
12 000 unknowns whose last layer of cells is partly filled, to 1e-3 ("-": no convergence):

| share of the last cells filled | 0.3    | 0.1    | 0.01    | 0.001    |
|--------------------------------|--------|--------|---------|----------|
| sand, dynamic                  | 11, 9  | 39, 9  | 79, 8   | 79, 8    |
| quasi-static                   | 29, 21 | -, -   | 284, 45 | -, 49    |
| dynamic, ghost = 0.033         | 40, 10 | 74, 11 | 74, 12  | 74, 12   |
| quasi-static                   | 89, 18 | 91, 19 | 92, 25  | 92, 24   |
| elastic, the same              | 9, 8   | 15, 7  | 27, 7   | 37, 7    |
"""

import numpy as np

from hybrid.grid.numbering import node_number
from hybrid.linalg.stencil import PLACES, offset_of_place
from hybrid.runtime.jit import njit, prange


def reduced_entries(pattern, shape, small_support):
    """(entries,) bool, entries of `pattern` between nodes of one cell or in the columns of nodes with `small_support`
    (N,) bool, on a grid of `shape` nodes."""
    chosen = np.empty(len(pattern.indices), np.bool_)
    nodes = np.flatnonzero(pattern.row >= 0)
    _choose(nodes, small_support, pattern.free, shape, pattern.sparsity, chosen)
    return chosen


class ReducedMatrix:
    """The entries of a matrix of sparsity (indptr, indices) that are selected by `chosen` (entries,) bool.

    indptr, indices, values: compressed rows.
    """

    def __init__(self, indptr, indices, chosen):
        self._chosen = np.flatnonzero(chosen)
        self.indptr = np.searchsorted(self._chosen, indptr).astype(np.int32)
        if len(chosen) < np.iinfo(np.int32).max:
            self._chosen = self._chosen.astype(np.int32)    # halves the memory that `update` reads besides values
        self.indices, self.values = indices[self._chosen], np.empty(len(self._chosen))

    def update(self, values):
        """Copy the selected entries of `values`, those of the full matrix, to this matrix."""
        _copy_chosen(values, self._chosen, self.values)


@njit(cache=True, parallel=True)
def _copy_chosen(values, chosen, out):
    for n in prange(len(chosen)):
        out[n] = values[chosen[n]]


@njit(cache=True, parallel=True)
def _choose(nodes, small_support, free, shape, sparsity, chosen):
    dof, _, slot, indptr = sparsity
    for r in prange(len(nodes)):
        v = nodes[r]
        for s in range(PLACES):
            if slot[r, s] < 0:
                continue
            i, j, k = offset_of_place(s)
            w = v + node_number(shape, i, j, k)
            kept = small_support[w] or max(abs(i), abs(j), abs(k)) <= 1
            width = 0
            for k in range(3):
                width += free[w, k]
            for i in range(3):
                if free[v, i]:
                    at = indptr[dof[v, i]] + slot[r, s]
                    for k in range(width):
                        chosen[at + k] = kept
