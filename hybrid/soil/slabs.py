"""Colouring that lets two threads add into the same nodal arrays without locks.

Points are grouped by slabs of two cells along the longest axis. A point reaches at most two nodes ahead of its first
one, so slabs of the same parity never share a node. All even slabs run at once, then all odd ones; the order of
additions at a node does not depend on the number of threads, so results are bitwise reproducible.
"""

from dataclasses import dataclass

import numpy as np

WIDTH = 2


@dataclass(frozen=True)
class Slabs:
    """order: (n,) points sorted by slab; start: (slabs + 1,) offsets into `order`."""

    order: np.ndarray
    start: np.ndarray


def make_slabs(first, shape):
    """Slabs from the first nodes (n, 3) of the points on a grid of `shape` nodes."""
    axis = int(np.argmax(shape))
    key = first[:, axis] // WIDTH
    order = np.argsort(key, kind="stable").astype(np.int64)
    start = np.searchsorted(key[order], np.arange(shape[axis] // WIDTH + 2)).astype(np.int64)
    return Slabs(order, start)
