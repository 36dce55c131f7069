"""Internal force of the soil and its consistent tangent.

With τ the Kirchhoff stress, g_v = ΔF^-T ∇_n S_v the current gradient and V0 the initial volume,

    f_v,i     = Σ_p V0 τ_ij g_v,j
    K_vw,ik   = Σ_p V0 g_v,j A_ijkl g_w,l           A_ijkl = ∂τ_ij/∂l_kl - τ_il δ_jk

(formulation section 3; there with σ = τ/J and V = J V0). In the principal frame of b_trial, with D = ∂τ_i/∂ε_j,

    ∂τ_ii/∂l_kk = D_ik      ∂τ_ij/∂l_ij = b_j κ_ij      ∂τ_ij/∂l_ji = b_i κ_ij      κ_ij = (τ_i - τ_j)/(b_i - b_j)

and κ_ij -> (D_ii - D_ij)/(2 b_i) where two principal values meet.
"""

import numpy as np
from numba import njit, prange

CENTRE = 62  # place of a node itself in its 5x5x5 stencil


def internal_force(basis, slabs, shape, trial, stress, volume):
    """Nodal internal force (N, 3) [N] from Kirchhoff stress (n, 3, 3) [Pa] and initial volumes (n,) [m³]."""
    force = np.zeros((int(np.prod(shape)), 3))
    _internal_force(slabs.order, slabs.start, basis.first, basis.count, basis.value, basis.slope, shape[1], shape[2],
                    trial.inverse, stress, volume, force)
    return force


def add_stiffness(basis, slabs, shape, trial, principal_stress, tangent, volume, pattern, values):
    """Add the consistent tangent to the entries `values` of a matrix with the given sparsity `pattern`."""
    _add_stiffness(slabs.order, slabs.start, basis.first, basis.count, basis.value, basis.slope, shape[1], shape[2],
                   trial.inverse, trial.strain, trial.directions, principal_stress, tangent, volume,
                   pattern.dof, pattern.row, pattern.slot, pattern.indptr, values)


@njit(cache=True)
def gradients(p, first, count, value, slope, ny, nz, inverse, node, code, g):
    """Nodes, their places in a 5x5x5 stencil and current gradients of one point; returns how many."""
    m = 0
    for a in range(count[p, 0]):
        for b in range(count[p, 1]):
            for c in range(count[p, 2]):
                g0 = slope[p, 0, a] * value[p, 1, b] * value[p, 2, c]
                g1 = value[p, 0, a] * slope[p, 1, b] * value[p, 2, c]
                g2 = value[p, 0, a] * value[p, 1, b] * slope[p, 2, c]
                node[m] = ((first[p, 0] + a) * ny + first[p, 1] + b) * nz + first[p, 2] + c
                code[m] = (a * 5 + b) * 5 + c
                for j in range(3):
                    g[m, j] = g0 * inverse[p, 0, j] + g1 * inverse[p, 1, j] + g2 * inverse[p, 2, j]
                m += 1
    return m


@njit(cache=True, parallel=True)
def _internal_force(order, start, first, count, value, slope, ny, nz, inverse, stress, volume, force):
    slabs = len(start) - 1
    for colour in range(2):
        for pair in prange((slabs - colour + 1) // 2):
            slab = 2 * pair + colour
            node, code, g = np.empty(27, np.int64), np.empty(27, np.int64), np.empty((27, 3))
            for n in range(start[slab], start[slab + 1]):
                p = order[n]
                m = gradients(p, first, count, value, slope, ny, nz, inverse, node, code, g)
                for a in range(m):
                    for i in range(3):
                        force[node[a], i] += volume[p] * (stress[p, i, 0] * g[a, 0] + stress[p, i, 1] * g[a, 1]
                                                          + stress[p, i, 2] * g[a, 2])


@njit(cache=True, fastmath={"contract"})
def spatial_tangent(strain, directions, stress, tangent, A, work):
    """A_ijkl (9, 9) of one point, row 3i + j, column 3k + l; `work` is (9, 9) scratch."""
    work[:] = 0.0
    for i in range(3):
        bi = np.exp(2 * strain[i])
        for j in range(3):
            if i == j:
                for k in range(3):
                    work[4 * i, 4 * k] = tangent[i, k]
                continue
            bj = np.exp(2 * strain[j])
            if abs(strain[i] - strain[j]) > 1e-7:
                kappa = (stress[i] - stress[j]) / (bi - bj)
            else:
                kappa = 0.5 * (tangent[i, i] - tangent[i, j] + tangent[j, j] - tangent[j, i]) / (bi + bj)
            work[3 * i + j, 3 * i + j] = bj * kappa
            work[3 * i + j, 3 * j + i] = bi * kappa
    for i in range(3):
        for j in range(3):
            work[3 * i + j, 3 * j + i] -= stress[i]  # - τ_il δ_jk in the principal frame
    _rotate_pair(work, directions, A)
    _rotate_pair(A.T, directions, work.T)
    A[:] = work


@njit(cache=True, fastmath={"contract"})
def _rotate_pair(source, directions, out):
    """out[(ij), :] = n_ia n_jb source[(ab), :]."""
    for i in range(3):
        for j in range(3):
            for column in range(9):
                total = 0.0
                for a in range(3):
                    total += directions[i, a] * (directions[j, 0] * source[3 * a, column]
                                                 + directions[j, 1] * source[3 * a + 1, column]
                                                 + directions[j, 2] * source[3 * a + 2, column])
                out[3 * i + j, column] = total


@njit(cache=True, parallel=True)
def _add_stiffness(order, start, first, count, value, slope, ny, nz, inverse, strain, directions, stress, tangent,
                   volume, dof, row, slot, indptr, values):
    slabs = len(start) - 1
    for colour in range(2):
        for pair in prange((slabs - colour + 1) // 2):
            slab = 2 * pair + colour
            node, code, g = np.empty(27, np.int64), np.empty(27, np.int64), np.empty((27, 3))
            entry, whole = np.empty((27, 3), np.int64), np.empty(27, np.bool_)
            A, work, T = np.empty((9, 9)), np.empty((9, 9)), np.empty((3, 9))
            for n in range(start[slab], start[slab + 1]):
                p = order[n]
                m = gradients(p, first, count, value, slope, ny, nz, inverse, node, code, g)
                spatial_tangent(strain[p], directions[p], stress[p], tangent[p], A, work)
                for a in range(m):
                    whole[a] = True
                    for i in range(3):
                        d = dof[node[a], i]
                        entry[a, i] = indptr[d] if d >= 0 else -1
                        whole[a] &= d >= 0
                for a in range(m):
                    _contract(g, a, A, volume[p], T)
                    _add_rows(a, m, node, code, g, T, entry, whole, row, slot, values)


@njit(cache=True, fastmath={"contract"})
def _contract(g, a, A, volume, T):
    """T_ikl = V0 g_a,j A_ijkl."""
    g0, g1, g2 = volume * g[a, 0], volume * g[a, 1], volume * g[a, 2]
    for i in range(3):
        for kl in range(9):
            T[i, kl] = g0 * A[3 * i, kl] + g1 * A[3 * i + 1, kl] + g2 * A[3 * i + 2, kl]


@njit(cache=True, fastmath={"contract"})
def _add_rows(a, m, node, code, g, T, entry, whole, row, slot, values):
    """Add T_ikl g_w,l for every node w of the point to the free rows of node a."""
    r = row[node[a]]
    for b in range(m):
        offset = slot[r, code[b] - code[a] + CENTRE]
        g0, g1, g2 = g[b, 0], g[b, 1], g[b, 2]
        if whole[a] and whole[b]:  # nearly always
            for i in range(3):
                at = entry[a, i] + offset
                values[at] += T[i, 0] * g0 + T[i, 1] * g1 + T[i, 2] * g2
                values[at + 1] += T[i, 3] * g0 + T[i, 4] * g1 + T[i, 5] * g2
                values[at + 2] += T[i, 6] * g0 + T[i, 7] * g1 + T[i, 8] * g2
            continue
        for i in range(3):
            if entry[a, i] < 0:
                continue
            at = entry[a, i] + offset
            for k in range(3):
                if entry[b, k] >= 0:
                    values[at] += T[i, 3 * k] * g0 + T[i, 3 * k + 1] * g1 + T[i, 3 * k + 2] * g2
                    at += 1
