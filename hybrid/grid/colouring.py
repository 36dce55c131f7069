"""Colouring that lets two threads add into the same nodal arrays without locks.

Points are grouped by slabs of two cells along the longest axis. A point reaches at most two nodes ahead of its first
one, so slabs of the same parity never share a node. All even slabs run at once, then all odd ones; the order of
additions at a node does not depend on the number of threads, so results are bitwise reproducible.

Within a slab points go cell by cell: what one adds to is still in the processor's cache when the next one comes.
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
