"""Consistent tangent of the internal force, added into the sparse soil block.

    K_vw,ik   = Σ_p V0 g_v,j A_ijkl g_w,l           A_ijkl = ∂τ_ij/∂l_kl - τ_il δ_jk

(FORMULATION (12); g, τ and V0 as in `hybrid.soil.forces`, A in `hybrid.soil.tangent`).

The nodes of a point that differ in z only are a *stack*: their free components are neighbours in every row of the
matrix. So B_ij,q = V0 A_ijkl g_w,l is formed once for the free components q = (w, k) of a point, and a row takes
g_v,j B_ij,q in runs, one for each stack.

Within an increment ∇_n S is fixed, so a point's part of K is linear in the 81 numbers

    Â_imkn = ΔF^-1_mj A_ijkl ΔF^-1_nl        K_vw,ik = Σ_p V0 ∂_m S_v Â_imkn ∂_n S_w

From one Newton iteration to the next these hardly change but in the few points that yield, so what has been assembled
is kept, and only points whose Â has changed by more than a tolerance add the difference.
"""

from weakref import ref

import numpy as np
from numba import njit, prange

from hybrid.linalg.stencil import local_number, relative_place
from hybrid.soil.forces import reference_gradients
from hybrid.soil.tangent import FIVE, FOUR, NINE, ONE, SIX, THREE, TWO, point_tangent, pulled_back

WIDTH = np.uintp(81)


NOTHING = np.zeros((0, 81)), np.zeros(0)


def add_stiffness(basis, slabs, shape, trial, principal_stress, tangent, volume, pattern, values):
    """Add the consistent tangent to the entries `values` of a matrix with the given sparsity `pattern`."""
    _add(basis, slabs, shape, trial, principal_stress, tangent, volume, pattern, values, *NOTHING, True)


class KeptStiffness:
    """Tangent of one increment after another. Within an increment only points whose Â has changed by more than
    `tolerance` times Young's modulus (n,) [Pa] are assembled again.

    values: entries of the matrix, for the pattern of the last update
    """

    def __init__(self, tolerance, young):
        self._limit, self._tensors = tolerance * young, np.empty((len(young), 81))
        self._increment, self._pattern, self.values = lambda: None, None, np.zeros(0)

    def update(self, increment, shape, trial, principal_stress, tangent, volume, pattern, share=1.0):
        """Bring `values` up to date with a trial strain of an `increment` (SoilStep); the first update of an increment
        assembles all points. share: [-] of the tolerance to apply."""
        fresh = increment is not self._increment() or pattern is not self._pattern
        if pattern is not self._pattern:
            self._pattern = self.values = None      # frees the old values before the new ones are allocated
            self.values = np.empty(len(pattern.indices))
        if fresh:
            self._increment, self._pattern = ref(increment), pattern    # a weak reference: a past step can be freed
            self.values[...] = 0.0
        _add(increment.basis, increment.slabs, shape, trial, principal_stress, tangent, volume, pattern, self.values,
             self._tensors, share * self._limit, fresh)


def _add(basis, slabs, shape, trial, principal_stress, tangent, volume, pattern, values, kept, limit, fresh):
    _add_stiffness(slabs.order, slabs.start, basis.first, basis.count, basis.value, basis.gradient, shape[1], shape[2],
                   trial.inverse, trial.strain, trial.directions, principal_stress, tangent, volume,
                   pattern.dof, pattern.row, pattern.slot, pattern.indptr, values, kept, limit, fresh)


@njit(cache=True, parallel=True)
def _add_stiffness(order, start, first, count, value, slope, ny, nz, inverse, strain, directions, stress, tangent,
                   volume, dof, row, slot, indptr, values, kept, limit, fresh):
    slabs = len(start) - 1
    for colour in range(2):
        for pair in prange((slabs - colour + 1) // 2):
            slab = 2 * pair + colour
            node, g, code, unknown, stack, place = scratch()
            A, work, second, B = np.empty(81), np.empty((3, 81)), np.empty((3, 3)), np.empty(9 * 81)
            for n in range(start[slab], start[slab + 1]):
                p = order[n]
                pulled_back(inverse[p], directions[p], second)
                point_tangent(directions[p], second, strain[p], stress[p], tangent[p], A, work)
                if len(kept) > 0 and not _replace(kept[p], A, limit[p], fresh):
                    continue
                m = reference_gradients(p, first, count, value, slope, ny, nz, node, g)
                stacks = free_components(count[p], node, dof, code, unknown, stack)
                contract(A, g, volume[p], unknown, stack[1, stacks], B)
                for a in range(m):
                    if find_stacks(row[node[a]], code[a], stack, stacks, slot, place):
                        for i in range(3):
                            if dof[node[a], i] >= 0:
                                add_row(values, indptr[dof[node[a], i]], place, stack, stacks, B,
                                        np.uintp(3 * i) * WIDTH, g[a, 0], g[a, 1], g[a, 2])


@njit(cache=True)
def _replace(kept, A, limit, fresh):
    """Keep A of a point and leave in it what has to be added; False when it has not changed by more than `limit`."""
    change = 0.0
    for n in range(81):
        change = max(change, abs(A[n] - kept[n]))
    if not fresh and change <= limit:
        return False
    for n in range(81):
        new = A[n]
        if not fresh:
            A[n] = new - kept[n]
        kept[n] = new
    return True


@njit(cache=True)
def scratch():
    """Arrays that a thread fills for one point after another: node (27,), g (27, 3), code (27,), unknown (2, 81),
    stack (2, 10), place (9,)."""
    return (np.empty(27, np.int64), np.empty((27, 3)), np.empty(27, np.int64), np.empty((2, 81), np.int64),
            np.empty((2, 10), np.int64), np.empty(9, np.int64))


@njit(cache=True)
def free_components(count, node, dof, code, unknown, stack):
    """Free components of the nodes of one point; returns the number of stacks that have any.

    code: (m,) places of the nodes in a 5x5x5 stencil. unknown: (2, q) node of the point and component. stack: (2, s)
    place in the stencil of the first node with a free component, and the number of the stack's first component; one
    more column ends the last stack.
    """
    m, q, stacks = 0, 0, 0
    for a in range(count[0]):
        for b in range(count[1]):
            stack[1, stacks] = q
            for c in range(count[2]):
                code[m] = local_number(a, b, c)
                for k in range(3):
                    if dof[node[m], k] >= 0:
                        if q == stack[1, stacks]:
                            stack[0, stacks] = code[m]
                        unknown[0, q], unknown[1, q] = m, k
                        q += 1
                m += 1
            if q > stack[1, stacks]:
                stacks += 1
    stack[1, stacks] = q
    return stacks


@njit(cache=True)
def find_stacks(row, code, stack, stacks, slot, place):
    """Offsets of the stacks in the rows of a node at `code` of the stencil; False when the node has no rows."""
    if row >= 0:
        for s in range(stacks):
            place[s] = slot[row, relative_place(code, stack[0, s])]
    return row >= 0


@njit(cache=True, fastmath={"contract"})
def contract(A, g, volume, unknown, size, B):
    """B_ij,q = V0 A_ijkl g_w,l of the free components q = (w, k), in nine rows of WIDTH."""
    for q in range(size):
        w, k, at = np.uintp(unknown[0, q]), np.uintp(3 * unknown[1, q]), np.uintp(q)
        x, y, z = volume * g[w, 0], volume * g[w, 1], volume * g[w, 2]
        for _ in range(9):
            B[at] = A[k] * x + A[k + ONE] * y + A[k + TWO] * z
            at += WIDTH
            k += NINE


@njit(cache=True, fastmath={"contract"})
def add_row(values, begin, place, stack, stacks, B, x, gx, gy, gz):
    """Add g_j B_ij,q to the row that begins at `begin`; x is where B_i0 begins."""
    for s in range(stacks):
        at, q, length = np.uintp(begin + place[s]), x + np.uintp(stack[1, s]), stack[1, s + 1] - stack[1, s]
        if length == 9:
            _add_six(values, at, B, q, gx, gy, gz)
            _add_three(values, at + SIX, B, q + SIX, gx, gy, gz)
        elif length == 6:
            _add_six(values, at, B, q, gx, gy, gz)
        else:
            for _ in range(length):
                values[at] += gx * B[q] + gy * B[q + WIDTH] + gz * B[q + WIDTH + WIDTH]
                at += ONE
                q += ONE


@njit(cache=True, fastmath={"contract"})
def _add_six(values, at, B, x, gx, gy, gz):
    """Six neighbouring entries. All is read before anything is written, so that no addition waits for another."""
    y = x + WIDTH
    z = y + WIDTH
    one = values[at] + gx * B[x] + gy * B[y] + gz * B[z]
    two = values[at + ONE] + gx * B[x + ONE] + gy * B[y + ONE] + gz * B[z + ONE]
    three = values[at + TWO] + gx * B[x + TWO] + gy * B[y + TWO] + gz * B[z + TWO]
    four = values[at + THREE] + gx * B[x + THREE] + gy * B[y + THREE] + gz * B[z + THREE]
    five = values[at + FOUR] + gx * B[x + FOUR] + gy * B[y + FOUR] + gz * B[z + FOUR]
    six = values[at + FIVE] + gx * B[x + FIVE] + gy * B[y + FIVE] + gz * B[z + FIVE]
    values[at], values[at + ONE], values[at + TWO] = one, two, three
    values[at + THREE], values[at + FOUR], values[at + FIVE] = four, five, six


@njit(cache=True, fastmath={"contract"})
def _add_three(values, at, B, x, gx, gy, gz):
    y = x + WIDTH
    z = y + WIDTH
    one = values[at] + gx * B[x] + gy * B[y] + gz * B[z]
    two = values[at + ONE] + gx * B[x + ONE] + gy * B[y + ONE] + gz * B[z + ONE]
    three = values[at + TWO] + gx * B[x + TWO] + gy * B[y + TWO] + gz * B[z + TWO]
    values[at], values[at + ONE], values[at + TWO] = one, two, three
