"""Colouring of the points, so that threads add to the same nodal arrays without locks.

Points are grouped into slabs of two cells along the longest axis. A point adds to at most three successive nodes along
it, so slabs of the same parity never share a node. All even slabs are processed in parallel, then all odd ones; the
order of additions at a node does not depend on the number of threads, so results are bitwise reproducible.

Within a slab the points are sorted by cell: the nodal values of a point are in the processor's cache for the next one.
"""

from typing import NamedTuple

import numpy as np

WIDTH = 2


class Slabs(NamedTuple):
    """order: (n,) points sorted by slab; start: (slabs + 1,) offsets into `order`."""

    order: np.ndarray
    start: np.ndarray


def make_slabs(first, shape):
    """Slabs from the first nodes (n, 3) of the points on a grid of `shape` nodes."""
    axis = int(np.argmax(shape))
    second, third = (a for a in range(3) if a != axis)
    slab, place = np.divmod(first[:, axis].astype(np.int64), WIDTH)
    cell = ((slab * shape[second] + first[:, second]) * shape[third] + first[:, third]) * WIDTH + place
    order = np.argsort(cell, kind="stable").astype(np.int64)
    start = np.searchsorted(slab[order], np.arange(shape[axis] // WIDTH + 2)).astype(np.int64)
    return Slabs(order, start)
