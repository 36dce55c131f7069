"""The part of the soil block that its incomplete factor, or sweeps, are made of.

A point near a cell's face couples nodes two cells apart, which makes three quarters of the entries but carries little,
so they are left out. Not so those of light nodes, which a few points barely reach (`hybrid.soil.model.LIGHT`): what
such a node has with far ones is as large as what it has with its neighbours. They are a twentieth of the nodes. Krylov
iterations with an incomplete factor in sand before an anchor, 120 000 unknowns, to 1e-2, without the columns of light
nodes, with those of less than a hundredth, a tenth and a half of the mass of a node in whole soil: 150 and more, 61, 9,
6, for 9.0, 9.7, 10.3 and 12 of 40 million entries. The rows of light nodes do as well as their columns.

So where a block of 12 000 unknowns just reaches into its last cells, to 1e-3, without and with light nodes:

| share of the last cells filled | 0.3    | 0.1    | 0.01    | 0.001    |
|--------------------------------|--------|--------|---------|----------|
| sand, dynamic                  | 11, 9  | 39, 9  | 79, 8   | 79, 8    |
| quasi-static                   | 29, 21 | -, -   | 284, 45 | -, 49    |
| dynamic, ghost = 0.033         | 40, 10 | 74, 11 | 74, 12  | 74, 12   |
| quasi-static                   | 89, 18 | 91, 19 | 92, 25  | 92, 24   |
| elastic, the same              | 9, 8   | 15, 7  | 27, 7   | 37, 7    |
"""

import numpy as np
from numba import njit, prange

from hybrid.grid.numbering import node_number
from hybrid.linalg.stencil import PLACES, offset_of_place


def reduced_entries(pattern, shape, small_support):
    """Entries (entries,) bool of `pattern`, on a grid of `shape` nodes of which some are `small_support` (N,) bool, that are
    between nodes of one cell or in the columns of light nodes."""
    chosen = np.empty(len(pattern.indices), np.bool_)
    nodes = np.flatnonzero(pattern.row >= 0)
    _choose(nodes, small_support, pattern.free, shape, pattern.sparsity, chosen)
    return chosen


class ReducedMatrix:
    """Entries of a matrix of sparsity (indptr, indices) that `chosen` (entries,) bool marks.

    indptr, indices, values: compressed rows.
    """

    def __init__(self, indptr, indices, chosen):
        self._chosen = np.flatnonzero(chosen)
        self.indptr = np.searchsorted(self._chosen, indptr).astype(np.int32)
        if len(chosen) < np.iinfo(np.int32).max:
            self._chosen = self._chosen.astype(np.int32)    # half of what is read besides the values
        self.indices, self.values = indices[self._chosen], np.empty(len(self._chosen))

    def take(self, values):
        """Fill `values` of this from the entries of the whole matrix."""
        _take(values, self._chosen, self.values)


@njit(cache=True, parallel=True)
def _take(values, chosen, near):
    for n in prange(len(chosen)):
        near[n] = values[chosen[n]]


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
