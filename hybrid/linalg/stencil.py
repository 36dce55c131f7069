"""The stencil of the soil block, 5 x 5 x 5 nodes, and the position of an entry among the values of the matrix.

The indices of two nodes of one point differ by at most REACH along every axis. Node w = v + (i, j, k) has the *place*

    s = ((i + 2) 5 + j + 2) 5 + k + 2           0 <= s < PLACES = 125,  CENTRE = 62 for w = v

in the stencil of v. Node (a, b, c), counted from the first node of a point or of a cell, has the *local number*
(a 5 + b) 5 + c. The place of w in the stencil of v is the local number of w, minus that of v, plus CENTRE.

Row (v, i) of the matrix belongs to component i of node v. Its entries for the free components of node w are contiguous
and begin at `entry(sparsity, v, i, s)`. This is the only module that depends on the size of the stencil.
"""

from typing import NamedTuple

import numpy as np

from hybrid.runtime.jit import njit

REACH = 2                   # nodes along each axis: a domain overlaps at most two cells
SPAN = 2 * REACH + 1
PLACES = SPAN**3
CENTRE = PLACES // 2


class Sparsity(NamedTuple):
    """Arrays with which kernels locate an entry; fields as in `hybrid.linalg.stencil_pattern.Pattern`."""

    dof: np.ndarray
    row: np.ndarray
    slot: np.ndarray
    indptr: np.ndarray


class Blocks(NamedTuple):
    """Matrix values to which kernels add: uu, entries of K_uu in the order of the pattern; uw (n, m) and wu (m, n),
    dense blocks that couple the n soil unknowns with the m unknowns of one body."""

    uu: np.ndarray
    uw: np.ndarray
    wu: np.ndarray


# Offset (i, j, k) of the node at each place (PLACES, 3). A table lookup is faster than divisions.
OFFSETS = np.array(np.unravel_index(np.arange(PLACES), (SPAN, SPAN, SPAN))).T.copy() - REACH


@njit(cache=True)
def local_number(a, b, c):
    """Number of node (a, b, c), counted from a first node; 0 <= a, b, c < SPAN."""
    return (a * SPAN + b) * SPAN + c


# Local numbers of the eight nodes of a cell, counted from its lowest one; z changes fastest.
CELL = np.array([local_number.py_func(a >> 2, a >> 1 & 1, a & 1) for a in range(8)])


@njit(cache=True)
def relative_place(v, w):
    """Place of node w in the stencil of node v, both given by their local numbers."""
    return w - v + CENTRE


@njit(cache=True)
def offset_of_place(s):
    """Offset (i, j, k) of the node at place s."""
    return OFFSETS[s, 0], OFFSETS[s, 1], OFFSETS[s, 2]


@njit(cache=True)
def entry(sparsity, v, i, s):
    """Index among the values of the first entry of row (v, i), a free component of v, for the node at place s."""
    return sparsity.indptr[sparsity.dof[v, i]] + sparsity.slot[sparsity.row[v], s]
