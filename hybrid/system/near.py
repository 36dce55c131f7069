"""The part of the soil block that its incomplete factor, or sweeps, are made of.

A point near a cell's face couples nodes two cells apart, which makes three quarters of the entries but carries little,
so they are left out. Not so those of light nodes, which a few points barely reach (`hybrid.soil.model.LIGHT`): what
such a node has with far ones is as large as what it has with its neighbours. They are a twentieth of the nodes. Krylov
iterations with an incomplete factor in sand before an anchor, 120 000 unknowns, to 1e-2, without the columns of light
nodes, with those of less than a hundredth, a tenth and a half of the mass of a node in whole soil: 150 and more, 61, 9,
6, for 9.0, 9.7, 10.3 and 12 of 40 million entries. The rows of light nodes do as well as their columns.

The ghost penalty couples them too, and with it they carry much: then a share of what is left out
is added to the block that its row's node has with itself, component by component. Krylov iterations to 1e-3 of blocks
of 10 700 to 12 000 unknowns whose last cells are filled to a part:

| share, with ghost = 0.033           | 0    | 1/4 | 1/2  | 3/4  |
|-------------------------------------|------|-----|------|------|
| 0.01, elastic, quasi-static         | 27   | 7   | 6    | 6    |
| 0.001, elastic, dynamic             | 49   | 7   | 6    | 6    |
| 0.3, plastic, quasi-static          | none | 37  | none | none |

Without the penalty a share does harm: cells filled to 0.3 take 19 iterations instead of 5, and to 0.1 none converges.
"""

import numpy as np
from numba import njit, prange

SHARE = 0.25


class Near:
    """Entries of a matrix of sparsity (indptr, indices) that `chosen` (entries,) bool marks, and what others leave.

    indptr, indices, values: compressed rows. own: (n, 3) unknowns of the node of each unknown, or -1, and component:
    (n,) which of them it is; without these the other entries are left out altogether.
    """

    def __init__(self, indptr, indices, chosen, own=None, component=None):
        n = len(indptr) - 1
        self._from, self._chosen = indptr, np.flatnonzero(chosen)
        if len(chosen) < np.iinfo(np.int32).max:
            self._chosen = self._chosen.astype(np.int32)    # half of what is read besides the values
        self.indptr = np.zeros(n + 1, np.int32)
        np.cumsum(np.add.reduceat(chosen, indptr[:-1], dtype=np.int32), out=self.indptr[1:])
        self.indices, self.values = indices[chosen], np.empty(len(self._chosen))
        self._place = None
        if own is not None:
            self._place, self._kind = np.full((n, 3), -1, np.int32), component.astype(np.int8)[indices]
            self._kind[chosen] = -1
            _find(self.indptr, self.indices, own.astype(np.int32), self._place)

    def take(self, values):
        """Fill `values` of this from the entries of the whole matrix."""
        _take(values, self._chosen, self.values)
        if self._place is not None:
            _share(self._from, self._kind, self._place, values, self.values)


@njit(cache=True)
def _find(indptr, indices, own, place):
    """Places of the entries that a row has with its own node."""
    for r in range(len(own)):
        for at in range(indptr[r], indptr[r + 1]):
            for k in range(3):
                if indices[at] == own[r, k]:
                    place[r, k] = at


@njit(cache=True, parallel=True)
def _take(values, chosen, near):
    for n in prange(len(chosen)):
        near[n] = values[chosen[n]]


@njit(cache=True, parallel=True)
def _share(whole, kind, place, values, near):
    """Add a share of the entries left out to those that a row has with its own node."""
    for r in prange(len(whole) - 1):
        x, y, z = 0.0, 0.0, 0.0
        for entry in range(whole[r], whole[r + 1]):
            k = kind[entry]
            if k == 0:
                x += values[entry]
            elif k == 1:
                y += values[entry]
            elif k == 2:
                z += values[entry]
        if place[r, 0] >= 0:
            near[place[r, 0]] += SHARE * x
        if place[r, 1] >= 0:
            near[place[r, 1]] += SHARE * y
        if place[r, 2] >= 0:
            near[place[r, 2]] += SHARE * z
