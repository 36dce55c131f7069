"""F-bar: points take the volume change of the cells around them, so that linear elements do not lock.

The volume ratio J = det ΔF of a point is replaced by that of the mean gradient over the cells its domain overlaps, each
cell's taken at its centre:

    ΔF_0 = I + Σ_v Δu_v ⊗ ∇_n M_v         ∂M_v/∂x = dS_v/dx · m_v(y) m_v(z)   and so on
    ΔF̄ = s ΔF along the axes that deform, of which there are n,      s = (det ΔF_0 / det ΔF)^(1/n)

with m_v = Σ_K ½ |domain ∩ K| / |domain| over the cells K at node v. Nodes are those of the point's basis, a linear
displacement gives ΔF_0 = ΔF, and a point that moves into a cell sees it gradually. Replacing F by F̄ in the stored
energy gives the internal force, so energy and both momenta stay what they are and the elastic tangent is symmetric:

    f_v = Σ_p V0 [τ g_v + q H_v]        g_v = ΔF^-T ∇_n S_v,  h_v = ΔF_0^-T ∇_n M_v,  H_v = h_v - g_v,  q = P:τ / n
    K_vw = Σ_p V0 [g_v A g_w + (c g_v) H_w + H_v (e g_w) + κ H_v H_w + q (w-transposed g_v g_w - h_v h_w)]

P the identity on the axes that deform, C_ijkl = ∂τ_ij/∂l_kl, c = C:P/n, e = P:C/n, κ = P:C:P/n². A row takes two forms
in the free components (w, k) of a point, in runs as in `hybrid.soil.stiffness`:

    K_vw,ik = Σ_p g_v,j B_ij + H_v,j S_ij        B_ij = V0 [A_ijkl g_w,l + c_ij H_w,k - q δ_jk H_w,i]
                                                 S_ij = V0 [δ_ij (κ H_w,k + e_kl g_w,l) - q δ_jk h_w,i]

The replacement at the element's centre is that of de Souza Neto, Perić, Dutko & Owen, Int. J. Solids Struct. 33 (1996)
3277-3296, for material points Coombs et al., Comput. Methods Appl. Mech. Eng. 333 (2018) 1-21. Their force keeps the
gradient g_v everywhere; this one is the derivative of the energy, the mean dilatation of Simo, Taylor & Pister, ibid.
51 (1985) 177-208.

Equations: FORMULATION (22) to (24).
"""

import numpy as np
from numba import njit, prange

from hybrid.soil.basis import Basis, support
from hybrid.soil.forces import gradients
from hybrid.soil.stiffness import WIDTH, add_row, contract, find_stacks, free_components, scratch
from hybrid.soil.tangent import point_tangent


def mean_basis(position, half, axes, basis):
    """Basis whose values are m_v: with the slopes of `basis` it gives ∇_n M_v where that gives ∇_n S_v."""
    value = np.zeros_like(basis.value)
    for axis, nodes in enumerate(axes):
        _mean_values(position[:, axis], half[:, axis], nodes, axis, value)
    return Basis(basis.first, basis.count, value, basis.gradient)


@njit(cache=True, parallel=True)
def _mean_values(x, half, nodes, axis, value):
    for p in prange(len(x)):
        if len(nodes) == 1:
            value[p, axis, 0] = 1.0
            continue
        first, last, low, high = support(x[p], half[p], nodes)
        for a in range(last - first):
            share = 1.0
            if last - first > 1:
                share = (min(high, nodes[first + a + 1]) - max(low, nodes[first + a])) / (high - low)
            value[p, axis, a] += 0.5 * share
            value[p, axis, a + 1] += 0.5 * share


def add_force(step, shape, collapsed, trial, stress, volume, force):
    """Add V0 q H_v to nodal forces (N, 3) [N]; stress: (n, 3, 3) Kirchhoff [Pa]; volume: (n,) initial [m³]."""
    basis, mean, slabs = step.basis, step.mean, step.slabs
    _add_force(slabs.order, slabs.start, basis.first, basis.count, basis.value, mean.value, basis.gradient, shape[1],
               shape[2], trial.inverse, trial.mean_inverse, ~collapsed, np.count_nonzero(~collapsed), stress, volume,
               force)


def add_stiffness(step, shape, collapsed, trial, principal_stress, tangent, volume, pattern, values):
    """Add the consistent tangent with F-bar to the entries `values` of a matrix of sparsity `pattern`."""
    basis, mean, slabs = step.basis, step.mean, step.slabs
    _add_stiffness(slabs.order, slabs.start, basis.first, basis.count, basis.value, mean.value, basis.gradient, shape[1],
                   shape[2], trial.inverse, trial.mean_inverse, ~collapsed, trial.strain, trial.directions,
                   principal_stress, tangent, volume, pattern.dof, pattern.row, pattern.slot, pattern.indptr, values)


@njit(cache=True, parallel=True)
def _add_force(order, start, first, count, value, mean, slope, ny, nz, inverse, mean_inverse, deforms, axes, stress,
               volume, force):
    slabs = len(start) - 1
    for colour in range(2):
        for pair in prange((slabs - colour + 1) // 2):
            slab = 2 * pair + colour
            node, g, h = np.empty(27, np.int64), np.empty((27, 3)), np.empty((27, 3))
            for n in range(start[slab], start[slab + 1]):
                p = order[n]
                m = gradients(p, first, count, value, slope, ny, nz, inverse, node, g)
                gradients(p, first, count, mean, slope, ny, nz, mean_inverse, node, h)
                q = 0.0
                for i in range(3):
                    if deforms[i]:
                        q += volume[p] * stress[p, i, i] / axes
                for a in range(m):
                    for i in range(3):
                        force[node[a], i] += q * (h[a, i] - g[a, i])


@njit(cache=True, fastmath={"contract"})
def _projections(A, directions, stress, deforms, c, e):
    """Fill c = C:P/n and e = P:C/n; returns q and κ. C_ijkl = A_ijkl + τ_il δ_jk."""
    axes, q, kappa = np.sum(deforms), 0.0, 0.0
    for i in range(3):
        for j in range(3):
            tau = 0.0
            for a in range(3):
                tau += stress[a] * directions[i, a] * directions[j, a]
            c[i, j] = tau if deforms[j] else 0.0
            e[i, j] = tau if deforms[i] else 0.0
            for k in range(3):
                if deforms[k]:
                    c[i, j] += A[27 * i + 9 * j + 4 * k]
                    e[i, j] += A[36 * k + 3 * i + j]
            c[i, j] /= axes
            e[i, j] /= axes
            if i == j and deforms[i]:
                q += tau / axes
    for i in range(3):
        if deforms[i]:
            kappa += c[i, i] / axes
    return q, kappa


@njit(cache=True, fastmath={"contract"})
def _forms(unknown, size, volume, g, h, c, e, kappa, q, H, B, S):
    """Fill H_v of the nodes of a point and S_ij of its free components, in nine rows of WIDTH, and add to B_ij, which
    is V0 A_ijkl g_w,l, what H makes of it."""
    for a in range(len(H)):
        for i in range(3):
            H[a, i] = h[a, i] - g[a, i]
    for n in range(size):
        w, k = unknown[0, n], unknown[1, n]
        own = volume * H[w, k]
        both = kappa * own + volume * (e[k, 0] * g[w, 0] + e[k, 1] * g[w, 1] + e[k, 2] * g[w, 2])
        for i in range(3):
            for j in range(3):
                at = (3 * i + j) * WIDTH + np.uintp(n)
                B[at] += c[i, j] * own
                S[at] = both if i == j else 0.0
            at = (3 * i + k) * WIDTH + np.uintp(n)
            B[at] -= volume * q * H[w, i]
            S[at] -= volume * q * h[w, i]


@njit(cache=True, parallel=True)
def _add_stiffness(order, start, first, count, value, mean, slope, ny, nz, inverse, mean_inverse, deforms, strain,
                   directions, stress, tangent, volume, dof, row, slot, indptr, values):
    slabs = len(start) - 1
    for colour in range(2):
        for pair in prange((slabs - colour + 1) // 2):
            slab = 2 * pair + colour
            node, g, code, unknown, stack, place = scratch()
            h, H, B, S = np.empty((27, 3)), np.empty((27, 3)), np.empty(9 * 81), np.empty(9 * 81)
            A, work, c, e = np.empty(81), np.empty((3, 81)), np.empty((3, 3)), np.empty((3, 3))
            for n in range(start[slab], start[slab + 1]):
                p = order[n]
                m = gradients(p, first, count, value, slope, ny, nz, inverse, node, g)
                gradients(p, first, count, mean, slope, ny, nz, mean_inverse, node, h)
                stacks = free_components(count[p], node, dof, code, unknown, stack)
                point_tangent(directions[p], directions[p], strain[p], stress[p], tangent[p], A, work)
                q, kappa = _projections(A, directions[p], stress[p], deforms, c, e)
                contract(A, g, volume[p], unknown, stack[1, stacks], B)
                _forms(unknown, stack[1, stacks], volume[p], g[:m], h[:m], c, e, kappa, q, H[:m], B, S)
                for a in range(m):
                    if find_stacks(row[node[a]], code[a], stack, stacks, slot, place):
                        for i in range(3):
                            if dof[node[a], i] >= 0:
                                begin, x = indptr[dof[node[a], i]], np.uintp(3 * i) * WIDTH
                                add_row(values, begin, place, stack, stacks, B, x, g[a, 0], g[a, 1], g[a, 2])
                                add_row(values, begin, place, stack, stacks, S, x, H[a, 0], H[a, 1], H[a, 2])
