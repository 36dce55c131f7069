"""Assembly of the tangents of points that share a box of nodes.

Points with the same first node reach at most 3 x 3 x 3 nodes, their *box*, and follow one another in a slab
(`hybrid.grid.colouring`). With

    B_ij,q = V0 A_ijkl g_w,l        q = (w, k)        K_vi,q = Σ_p g_v,j B_ij,q        (with F-bar: + Σ_p m_v,j S_ij,q)

K is summed over them in a dense array and then added to the matrix, once a box. Node (a, b, c) of a box, counted from its
first one, has the number w = (a n_y + b) n_z + c and component k of it the column q = a RUN + 3 (b n_z + c) + k, with
n_y, n_z = 3, or 1 along an axis of one node, and RUN a multiple of 4 that 3 n_y n_z fit in. So a point's columns are
the first ones of each row, and all loops over columns are contiguous, of a length that is a multiple of 8. Columns that a
point does not reach hold zeros.
"""

from typing import NamedTuple

import numpy as np

from hybrid.grid.numbering import node_number
from hybrid.linalg.stencil import local_number, relative_place
from hybrid.runtime.jit import njit

NODES = 27
STRIDE = 88         # columns of a box, 3 x 28, and as many more as make whole vectors
# Unsigned offsets of rows: numba tests at every access whether a signed index is negative, and then uses no vector
# registers.
ROW, ROWS = np.uintp(STRIDE), np.uintp(2 * STRIDE)


class Box(NamedTuple):
    """A box of a thread. K: (84, STRIDE), of which the last three rows count for nothing; first: (3,) its first node;
    reached: (3,) number of nodes along the axes that points reach; of these nodes, for `add_box`: node, local, column (27,),
    unknown (81,), stack (2, 10), place (9,)."""

    K: np.ndarray
    first: np.ndarray
    reached: np.ndarray
    node: np.ndarray
    local: np.ndarray
    column: np.ndarray
    unknown: np.ndarray
    stack: np.ndarray
    place: np.ndarray


@njit(cache=True)
def empty_box():
    """Box that no point is in."""
    return Box(np.zeros((3 * NODES + 3, STRIDE)), np.full(3, -1), np.zeros(3, np.int64), np.empty(NODES, np.int64),
               np.empty(NODES, np.int64), np.empty(NODES, np.int64), np.empty(3 * NODES, np.int64),
               np.empty((2, 10), np.int64), np.empty(9, np.int64))


@njit(cache=True)
def is_in(box, first):
    """Whether the `first` node (3,) of a point is that of the box."""
    return box.first[0] == first[0] and box.first[1] == first[1] and box.first[2] == first[2]


@njit(cache=True)
def move(box, first):
    """Move an empty box to another `first` node (3,)."""
    for axis in range(3):       # numba 0.56 leaves out an assignment to a slice of a tuple's field
        box.first[axis] = first[axis]


@njit(cache=True)
def box_widths(shape):
    """(n_y, n_z, RUN) of the boxes on a grid of `shape` nodes."""
    n_y, n_z = 3 if shape[1] > 1 else 1, 3 if shape[2] > 1 else 1
    return n_y, n_z, (3 * n_y * n_z + 3) // 4 * 4


@njit(cache=True)
def columns_reached(nodes, run):
    """Number of columns of so many `nodes` along x, a multiple of 8."""
    return (nodes * run + 7) // 8 * 8


@njit(cache=True)
def enter(box, count, widths, number, column):
    """Take in a point with `count` (3,) nodes along the axes. Fills their `number` (28,) in the box and the `column` (28,)
    of their first components; where they are odd in number, one more has the rows that count for nothing."""
    (n_y, n_z, run), m = widths, 0
    for axis in range(3):
        box.reached[axis] = max(box.reached[axis], count[axis])
    for a in range(count[0]):
        for b in range(count[1]):
            for c in range(count[2]):
                number[m], column[m] = (a * n_y + b) * n_z + c, a * run + 3 * (b * n_z + c)
                m += 1
    if m % 2:
        number[m] = NODES


@njit(cache=True)
def contract(A, g, volume, column, nodes, columns, E, B):
    """Fill the first `columns` of B_i0,q, B_i1,q and B_i2,q, which row i of B (3, 6 STRIDE) begins with, by g (28, 3) of a
    point's `nodes` nodes, and E (9 STRIDE,), with V0 g_w,l in its row 3 k + l."""
    for n in range(9):
        E[n * STRIDE:n * STRIDE + columns] = 0.0
    for n in range(nodes):
        for k in range(3):
            for j in range(3):
                E[column[n] + k + (3 * k + j) * STRIDE] = volume * g[n, j]
    for i in range(3):
        for j in range(3):
            _sum_of_nine(B[i, j * STRIDE:(j + 1) * STRIDE], A[27 * i + 9 * j:27 * i + 9 * j + 9], E, columns)


@njit(cache=True, fastmath={"contract"})
def _sum_of_nine(out, factor, E, columns):
    """Σ of nine rows of E times a factor each."""
    a, b, c, d, e = factor[0], factor[1], factor[2], factor[3], factor[4]
    f, g, h, i = factor[5], factor[6], factor[7], factor[8]
    three, four, five = ROWS + ROW, ROWS + ROWS, ROWS + ROWS + ROW
    six, seven, eight = three + three, four + three, four + four
    for q in range(np.uintp(columns)):
        out[q] = (a * E[q] + b * E[q + ROW] + c * E[q + ROWS] + d * E[q + three] + e * E[q + four]
                  + f * E[q + five] + g * E[q + six] + h * E[q + seven] + i * E[q + eight])


@njit(cache=True)
def add_point(K, number, nodes, deforms, g, m, B, columns):
    """Add Σ_j g_v,j B_ij,q to the rows of a point's nodes, and Σ_j m_v,j S_ij,q where m is not None, two rows at a time.

    g, m: (28, 3), zero in the row after the last one; deforms: (3,) bool, components i that are not collapsed.
    """
    for i in range(3):
        if deforms[i]:
            for n in range(0, nodes, 2):
                one, two = K[3 * number[n] + i], K[3 * number[n + 1] + i]
                if m is None:
                    _add_two_rows(one, two, g[n], g[n + 1], B[i], columns)
                else:
                    _add_two_mean_rows(one, two, g[n], g[n + 1], m[n], m[n + 1], B[i], columns)


@njit(cache=True, fastmath={"contract"})
def _add_two_rows(one, two, g, h, B, columns):
    """Each number of B is read once for two rows. All reads precede all writes."""
    gx, gy, gz, hx, hy, hz = g[0], g[1], g[2], h[0], h[1], h[2]
    for q in range(np.uintp(columns)):
        x, y, z = B[q], B[q + ROW], B[q + ROWS]
        first, second = one[q] + gx * x + gy * y + gz * z, two[q] + hx * x + hy * y + hz * z
        one[q], two[q] = first, second


@njit(cache=True, fastmath={"contract"})
def _add_two_mean_rows(one, two, g, h, m, n, B, columns):
    """The same with S, in the rows of B after the third one."""
    gx, gy, gz, hx, hy, hz = g[0], g[1], g[2], h[0], h[1], h[2]
    mx, my, mz, nx, ny, nz = m[0], m[1], m[2], n[0], n[1], n[2]
    three, four, five = ROWS + ROW, ROWS + ROWS, ROWS + ROWS + ROW
    for q in range(np.uintp(columns)):
        x, y, z, u, v, w = B[q], B[q + ROW], B[q + ROWS], B[q + three], B[q + four], B[q + five]
        first = one[q] + gx * x + gy * y + gz * z + mx * u + my * v + mz * w
        second = two[q] + hx * x + hy * y + hz * z + nx * u + ny * v + nz * w
        one[q], two[q] = first, second


@njit(cache=True)
def add_box(box, widths, shape, sparsity, values):
    """Add K of a box to the entries `values` of a matrix, and empty the box.

    The nodes that differ in z only form a *stack*: the entries for their free components are contiguous in every row of
    the matrix.
    """
    (dof, row, slot, indptr), (n_y, n_z, run) = sparsity, widths
    K, first, reached, node, local, column, unknown, stack, place = box
    _nodes_reached(box, widths, shape)
    stacks = _free_components(reached, node, dof, local, column, unknown, stack)
    columns, n = columns_reached(reached[0], run), 0
    for a in range(reached[0]):
        for b in range(reached[1]):
            for c in range(reached[2]):
                v, own = node[n], K[3 * ((a * n_y + b) * n_z + c):]
                if row[v] >= 0:
                    for s in range(stacks):
                        place[s] = slot[row[v], relative_place(local[n], stack[0, s])]
                    for i in range(3):
                        if dof[v, i] >= 0:
                            _add_row(values, indptr[dof[v, i]], place, stack, stacks, unknown, own[i])
                own[:3, :columns] = 0.0
                n += 1
    reached[:] = 0


@njit(cache=True)
def _nodes_reached(box, widths, shape):
    """Fill node, local and column of a Box."""
    (_, n_z, run), first, m = widths, box.first, 0
    for a in range(box.reached[0]):
        for b in range(box.reached[1]):
            for c in range(box.reached[2]):
                box.node[m] = node_number(shape, first[0] + a, first[1] + b, first[2] + c)
                box.local[m], box.column[m] = local_number(a, b, c), a * run + 3 * (b * n_z + c)
                m += 1


@njit(cache=True)
def _free_components(reached, node, dof, local, column, unknown, stack):
    """Find the free components of the nodes of a box; returns the number of stacks that have any.

    Fills `unknown` with their columns; stack: (2, s) local number of the first node with a free component, and index of
    the stack's first component. One more column of `stack` marks the end of the last one.
    """
    m, q, stacks = 0, 0, 0
    for _ in range(reached[0] * reached[1]):
        stack[1, stacks] = q
        for _ in range(reached[2]):
            for k in range(3):
                if dof[node[m], k] >= 0:
                    if q == stack[1, stacks]:
                        stack[0, stacks] = local[m]
                    unknown[q] = column[m] + k
                    q += 1
            m += 1
        if q > stack[1, stacks]:
            stacks += 1
    stack[1, stacks] = q
    return stacks


@njit(cache=True)
def _add_row(values, begin, place, stack, stacks, unknown, row):
    """Add the free columns of a `row` (STRIDE,) of K to the matrix row that begins at `begin`, in runs, one a stack."""
    for s in range(stacks):
        at, q, end = np.uintp(begin + place[s]), stack[1, s], stack[1, s + 1]
        if end - q == 9:
            _add_nine(values[at:], row[unknown[q]:])
        else:
            for n in range(q, end):
                values[at + np.uintp(n - q)] += row[unknown[n]]


@njit(cache=True)
def _add_nine(out, row):
    """All reads precede all writes, so that no addition has to wait for another."""
    a, b, c, d, e = out[0] + row[0], out[1] + row[1], out[2] + row[2], out[3] + row[3], out[4] + row[4]
    f, g, h, i = out[5] + row[5], out[6] + row[6], out[7] + row[7], out[8] + row[8]
    out[0], out[1], out[2], out[3], out[4], out[5], out[6], out[7], out[8] = a, b, c, d, e, f, g, h, i
