"""F-bar: the volume change of a point is that of the cells around it, so that linear elements do not lock.

The volume ratio J = det ΔF of a point is replaced by det ΔF_0, where ΔF_0 is the mean, over the cells that the point's
domain overlaps, of the gradients at the centres of these cells:

    ΔF_0 = I + Σ_v Δu_v ⊗ ∇_n M_v         ∂M_v/∂x = dS_v/dx · m_v(y) m_v(z)   and so on
    ΔF̄ = s ΔF along the axes that deform, of which there are n,      s = (det ΔF_0 / det ΔF)^(1/n)

with m_v = Σ_K ½ |domain ∩ K| / |domain| over the cells K at node v. The nodes are those of the point's basis; a linear
displacement gives ΔF_0 = ΔF; and the weight of a cell that a point enters grows continuously from zero. The internal
force is the derivative of the stored energy of F̄, so energy and both momenta are conserved as without F-bar, and the
elastic tangent is symmetric:

    f_v = Σ_p V0 [τ g_v + q H_v]        g_v = ΔF^-T ∇_n S_v,  h_v = ΔF_0^-T ∇_n M_v,  H_v = h_v - g_v,  q = P:τ / n
    K_vw = Σ_p V0 [g_v A g_w + (c g_v) H_w + H_v (e g_w) + κ H_v H_w + q (w-transposed g_v g_w - h_v h_w)]

P the identity on the axes that deform, C_ijkl = ∂τ_ij/∂l_kl, c = C:P/n, e = P:C/n, κ = P:C:P/n². A row needs
two arrays, B and S, over the free components (w, k) of a point, and is added in runs as in `hybrid.soil.rows`:

    K_vw,ik = Σ_p g_v,j B_ij + H_v,j S_ij        B_ij = V0 [A_ijkl g_w,l + c_ij H_w,k - q δ_jk H_w,i]
                                                 S_ij = V0 [δ_ij (κ H_w,k + e_kl g_w,l) - q δ_jk h_w,i]

The value at the element's centre is used by de Souza Neto, Perić, Dutko & Owen, Int. J. Solids Struct. 33 (1996)
3277-3296, and for material points by Coombs et al., Comput. Methods Appl. Mech. Eng. 333 (2018) 1-21. Their force has
the gradient g_v in all terms; the force used here is the derivative of the energy, as in the mean dilatation method of
Simo, Taylor & Pister, ibid. 51 (1985) 177-208.

Equations: FORMULATION (22) to (24).
"""

from typing import NamedTuple

import numpy as np
from numba import njit, prange

from hybrid.soil.basis import Basis, support
from hybrid.soil.forces import current_gradients, reference_gradients
from hybrid.soil.rows import WIDTH


def mean_basis(position, half, axes, basis):
    """Basis with the values m_v and the gradients of `basis`: evaluated as `basis` for ∇_n S_v, it gives ∇_n M_v."""
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


class MeanDilatation(NamedTuple):
    """Data of F-bar for a trial: values m_v (n, 3, 3) of the mean basis, ΔF_0^-1 (n, 3, 3), and the axes that deform
    (3,) bool."""

    value: np.ndarray
    inverse: np.ndarray
    deforms: np.ndarray


def mean_dilatation(step, collapsed, trial):
    """MeanDilatation of a `trial` (TrialStrain) of a `step` (SoilStep); collapsed: (3,) bool, axes of the grid."""
    return MeanDilatation(step.mean.value, trial.mean_inverse, ~collapsed)


def add_force(step, shape, collapsed, trial, stress, volume, force):
    """Add V0 q H_v to nodal forces (N, 3) [N]; stress: (n, 3, 3) Kirchhoff [Pa]; volume: (n,) initial [m³]."""
    dilatation = mean_dilatation(step, collapsed, trial)
    _add_force(step.slabs, step.basis, shape, trial.inverse, dilatation, stress, volume, force)


@njit(cache=True, parallel=True)
def _add_force(slabs, basis, shape, inverse, dilatation, stress, volume, force):
    (order, start), (first, count, value, gradient) = slabs, basis
    mean_value, mean_inverse, deforms = dilatation
    axes = np.sum(deforms)
    for colour in range(2):
        for pair in prange((len(start) - colour) // 2):
            slab = 2 * pair + colour
            node, g, h = np.empty(27, np.int64), np.empty((27, 3)), np.empty((27, 3))
            for n in range(start[slab], start[slab + 1]):
                p = order[n]
                m = reference_gradients(p, first, count, value, gradient, shape, node, g)
                reference_gradients(p, first, count, mean_value, gradient, shape, node, h)
                current_gradients(inverse[p], m, g)
                current_gradients(mean_inverse[p], m, h)
                q = 0.0
                for i in range(3):
                    if deforms[i]:
                        q += volume[p] * stress[p, i, i] / axes
                for a in range(m):
                    for i in range(3):
                        force[node[a], i] += q * (h[a, i] - g[a, i])


@njit(cache=True)
def subtract(h, g, m, H):
    """Fill H_v = h_v - g_v of the m nodes of a point, each (27, 3)."""
    for a in range(m):
        for i in range(3):
            H[a, i] = h[a, i] - g[a, i]


@njit(cache=True, fastmath={"contract"})
def project(A, directions, stress, volume, deforms, ce):
    """Fill `ce` (2, 3, 3) with c = C:P/n and e = P:C/n of one point, C_ijkl = A_ijkl + τ_il δ_jk; returns V0, q, κ."""
    axes, q, kappa = np.sum(deforms), 0.0, 0.0
    c, e = ce[0], ce[1]
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
    return volume, q, kappa


@njit(cache=True, fastmath={"contract"})
def add_mean_dilatation(unknown, size, scalars, ce, g, h, H, B, S):
    """Fill S_ij for the free components of a point, and add the terms of F-bar to B_ij, which contains V0 A_ijkl g_w,l;
    both in nine rows of WIDTH.

    unknown: (2, size) as `free_components` fills it; scalars, ce: from `project`; g, h, H: (27, 3). There are nine
    arguments because arrays that each thread allocates, passed as a tuple, cost 4 % of the assembly time.
    """
    (volume, q, kappa), c, e = scalars, ce[0], ce[1]
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
