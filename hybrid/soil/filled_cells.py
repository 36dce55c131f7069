"""Cells that the domains of the points fill: what soil they contain, how stiff it is, and where in the cell it lies.

    |Ω_K| = Σ_p |domain ∩ K| / |domain| V0        x_K = Σ_p |domain ∩ K| / |domain| V0 x_pK / |Ω_K|

with x_pK the centre of domain ∩ K. Fixed during a step. Cells on a cut between two processes count the points of both.
"""

from typing import NamedTuple

import numpy as np

from hybrid.runtime.jit import njit, prange
from hybrid.soil.basis import support


class FilledCells(NamedTuple):
    """What points leave in the cells (a, b, c) of a grid at the start of a step.

    first: (n, 3) first cell of each point along each axis; parts: (n, 3, 2) share of its domain in that cell and in the
    next one; volume: (a, b, c) [m³] of soil; share: (a, b, c) [-] of the cell that it fills, more than 1 where domains
    overlap; stiffness: (a, b, c) [N m] volume times modulus; centre: (3, a, b, c) [-] of the soil, from 0 at the lower to 1
    at the upper node of the cell, 1/2 where there is none
    """

    first: np.ndarray
    parts: np.ndarray
    volume: np.ndarray
    share: np.ndarray
    stiffness: np.ndarray
    centre: np.ndarray


def fill_cells(basis, position, half, volume, modulus, grid):
    """FilledCells of points at `position` (n, 3) [m] with domains of `half`-widths (n, 3) [m], a `volume` (n,) [m³] and a
    `modulus` (n,) [Pa], whose Basis is given."""
    parts, places = np.zeros((2, len(position), 3, 2))
    for axis, nodes in enumerate(grid.axes):
        _along(position[:, axis], half[:, axis], nodes, axis, parts, places)
    sums = np.zeros((5, *(max(1, n - 1) for n in grid.shape)))
    _add(basis.first, parts, places, volume, modulus, sums)
    filled, stiffness, *moments = (grid.summed_cells(values) for values in sums)
    centre = np.divide(moments, filled, out=np.full((3, *filled.shape), 0.5), where=filled > 0)
    return FilledCells(basis.first, parts, filled, filled / _cell_volumes(grid), stiffness, centre)


def _cell_volumes(grid):
    x, y, z = (np.diff(nodes) if len(nodes) > 1 else upper - lower for nodes, (lower, upper) in zip(grid.axes, grid.extent))
    return np.reshape(x, (-1, 1, 1)) * np.reshape(y, (-1, 1)) * z


@njit(cache=True, parallel=True)
def _along(x, half, nodes, axis, parts, places):
    """Fill the shares of domains in their first two cells along an axis, and the centre [-] of what lies in each."""
    for p in prange(len(x)):
        if len(nodes) == 1:
            parts[p, axis, 0], places[p, axis, 0] = 1.0, 0.5
            continue
        first, last, low, high = support(x[p], half[p], nodes)
        for a in range(last - first):
            begin, end = nodes[first + a], nodes[first + a + 1]
            lower, upper = max(low, begin), min(high, end)
            parts[p, axis, a] = (upper - lower) / (high - low) if last - first > 1 else 1.0
            places[p, axis, a] = (0.5 * (lower + upper) - begin) / (end - begin)


@njit(cache=True)
def _add(first, parts, places, volume, modulus, sums):
    """Add volume, volume times modulus, and volume times centre along each axis to `sums` (5, a, b, c)."""
    for p in range(len(first)):
        for a in range(2):
            for b in range(2):
                for c in range(2):
                    part = volume[p] * parts[p, 0, a] * parts[p, 1, b] * parts[p, 2, c]
                    if part == 0.0:     # also where there is no next cell
                        continue
                    i, j, k = first[p, 0] + a, first[p, 1] + b, first[p, 2] + c
                    sums[0, i, j, k] += part
                    sums[1, i, j, k] += part * modulus[p]
                    sums[2, i, j, k] += part * places[p, 0, a]
                    sums[3, i, j, k] += part * places[p, 1, b]
                    sums[4, i, j, k] += part * places[p, 2, c]
