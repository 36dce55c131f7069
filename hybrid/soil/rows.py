"""Assembly of the contribution of one point to the rows of the soil block.

The nodes of a point that differ in z only form a *stack*: the entries for their free components are contiguous in every
row of the matrix. A contribution is first formed for all free components q = (w, k) of a point,

    B_ij,q = V0 A_ijkl g_w,l

in nine rows of WIDTH numbers. Σ_j g_v,j B_ij,q is then added to matrix row (v, i) in contiguous runs, one a stack.
"""

import numpy as np
from numba import njit

from hybrid.linalg.stencil import local_number, relative_place
from hybrid.soil.tangent import FIVE, FOUR, NINE, ONE, SIX, THREE, TWO

WIDTH = np.uintp(81)    # largest number of free components of a point: 27 nodes of 3


@njit(cache=True)
def scratch():
    """Arrays that a thread reuses for all its points: node (27,), g (27, 3), local (27,), unknown (2, 81),
    stack (2, 10), place (9,)."""
    return (np.empty(27, np.int64), np.empty((27, 3)), np.empty(27, np.int64), np.empty((2, 81), np.int64),
            np.empty((2, 10), np.int64), np.empty(9, np.int64))


@njit(cache=True)
def free_components(count, node, dof, local, unknown, stack):
    """Find the free components of the nodes of one point; returns the number of stacks that have any.

    count: (3,) nodes along the axes; node: (m,) numbers of the nodes; dof: (N, 3) unknown number or -1. Fills
    local: (m,) local numbers of the nodes (`hybrid.linalg.stencil`); unknown: (2, q) index of the node among those of
    the point, and component; stack: (2, s) local number of the first node with a free component, and index of the
    stack's first component. One more column of `stack` marks the end of the last one.
    """
    m, q, stacks = 0, 0, 0
    for a in range(count[0]):
        for b in range(count[1]):
            stack[1, stacks] = q
            for c in range(count[2]):
                local[m] = local_number(a, b, c)
                for k in range(3):
                    if dof[node[m], k] >= 0:
                        if q == stack[1, stacks]:
                            stack[0, stacks] = local[m]
                        unknown[0, q], unknown[1, q] = m, k
                        q += 1
                m += 1
            if q > stack[1, stacks]:
                stacks += 1
    stack[1, stacks] = q
    return stacks


@njit(cache=True)
def find_stacks(row, local, stack, stacks, slot, place):
    """Fill `place` with the offsets of the stacks in the rows of a node with local number `local`; False if the node
    has no rows (row < 0)."""
    if row >= 0:
        for s in range(stacks):
            place[s] = slot[row, relative_place(local, stack[0, s])]
    return row >= 0


@njit(cache=True, fastmath={"contract"})
def contract(A, g, volume, unknown, size, B):
    """Fill B with B_ij,q = V0 A_ijkl g_w,l of the free components q = (w, k), in nine rows of WIDTH."""
    for q in range(size):
        w, k, at = np.uintp(unknown[0, q]), np.uintp(3 * unknown[1, q]), np.uintp(q)
        x, y, z = volume * g[w, 0], volume * g[w, 1], volume * g[w, 2]
        for _ in range(9):
            B[at] = A[k] * x + A[k + ONE] * y + A[k + TWO] * z
            at += WIDTH
            k += NINE


@njit(cache=True, fastmath={"contract"})
def add_row(values, begin, place, stack, stacks, B, S, x, gradient, mean):
    """Add Σ_j g_j B_ij,q to the matrix row that begins at `begin`, and with F-bar, where S is not None, Σ_j m_j S_ij,q
    in the same pass.

    gradient, mean: g_j and m_j (3,); x: index of B_i0,0 in B and of S_i0,0 in S.
    """
    for s in range(stacks):
        at, q, length = np.uintp(begin + place[s]), x + np.uintp(stack[1, s]), stack[1, s + 1] - stack[1, s]
        if length == 9:
            _add_six(values, at, B, S, q, gradient, mean)
            _add_three(values, at + SIX, B, S, q + SIX, gradient, mean)
        elif length == 6:
            _add_six(values, at, B, S, q, gradient, mean)
        else:
            for _ in range(length):
                for j in range(3):
                    values[at] += gradient[j] * B[q + np.uintp(j) * WIDTH]
                    if S is not None:
                        values[at] += mean[j] * S[q + np.uintp(j) * WIDTH]
                at += ONE
                q += ONE


@njit(cache=True, fastmath={"contract"})
def _add_six(values, at, B, S, x, gradient, mean):
    """Add to six contiguous entries. All reads precede all writes, so that no addition has to wait for another."""
    (gx, gy, gz), (mx, my, mz), y, z = gradient, mean, x + WIDTH, x + WIDTH + WIDTH
    one = values[at] + gx * B[x] + gy * B[y] + gz * B[z]
    two = values[at + ONE] + gx * B[x + ONE] + gy * B[y + ONE] + gz * B[z + ONE]
    three = values[at + TWO] + gx * B[x + TWO] + gy * B[y + TWO] + gz * B[z + TWO]
    four = values[at + THREE] + gx * B[x + THREE] + gy * B[y + THREE] + gz * B[z + THREE]
    five = values[at + FOUR] + gx * B[x + FOUR] + gy * B[y + FOUR] + gz * B[z + FOUR]
    six = values[at + FIVE] + gx * B[x + FIVE] + gy * B[y + FIVE] + gz * B[z + FIVE]
    if S is not None:
        one += mx * S[x] + my * S[y] + mz * S[z]
        two += mx * S[x + ONE] + my * S[y + ONE] + mz * S[z + ONE]
        three += mx * S[x + TWO] + my * S[y + TWO] + mz * S[z + TWO]
        four += mx * S[x + THREE] + my * S[y + THREE] + mz * S[z + THREE]
        five += mx * S[x + FOUR] + my * S[y + FOUR] + mz * S[z + FOUR]
        six += mx * S[x + FIVE] + my * S[y + FIVE] + mz * S[z + FIVE]
    values[at], values[at + ONE], values[at + TWO] = one, two, three
    values[at + THREE], values[at + FOUR], values[at + FIVE] = four, five, six


@njit(cache=True, fastmath={"contract"})
def _add_three(values, at, B, S, x, gradient, mean):
    (gx, gy, gz), (mx, my, mz), y, z = gradient, mean, x + WIDTH, x + WIDTH + WIDTH
    one = values[at] + gx * B[x] + gy * B[y] + gz * B[z]
    two = values[at + ONE] + gx * B[x + ONE] + gy * B[y + ONE] + gz * B[z + ONE]
    three = values[at + TWO] + gx * B[x + TWO] + gy * B[y + TWO] + gz * B[z + TWO]
    if S is not None:
        one += mx * S[x] + my * S[y] + mz * S[z]
        two += mx * S[x + ONE] + my * S[y + ONE] + mz * S[z + ONE]
        three += mx * S[x + TWO] + my * S[y + TWO] + mz * S[z + TWO]
    values[at], values[at + ONE], values[at + TWO] = one, two, three
