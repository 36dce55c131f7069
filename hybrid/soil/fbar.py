"""F-bar: the volume change of a point is that of the cells around it, so that linear elements do not lock.

The volume ratio J = det ΔF of a point is replaced by det ΔF_0, where ΔF_0 is the mean, over the cells that the point's
domain overlaps, of the gradients at the middle of the soil in these cells:

    ΔF_0 = I + Σ_v Δu_v ⊗ ∇_n M_v         ∂M_v/∂x = dS_v/dx · m_v(y) m_v(z)   and so on
    ΔF̄ = s ΔF along the axes that deform, of which there are n,      s = (det ΔF_0 / det ΔF)^(1/n)

with m_v = Σ_K N_v(x_K) |domain ∩ K| / |domain| over the cells K at node v. x_K is the centre of a full cell, where the
hat functions N_v are ½, and the centre of the soil in one that it fills by less than 1 - CUT, with a blend between
(`hybrid.soil.filled_cells`). At the centre of a cell that a body cuts the gradient is partly that of the body's side, so
the soil in it lost volume at no cost: a cylinder of 6 cells, moved through clay under a pressure of 20 s_u, left 14 % of
the soil in its way nowhere, and under 60 s_u all of it. The nodes are those of the point's basis; a linear displacement
gives ΔF_0 = ΔF; and the weight of a cell that a point enters grows continuously from zero.

Volume changes that cancel in each cell cost no energy then. Clay resists them by its shear stiffness. Sand whose flow
dilates less than its friction asks for has no stiffness against some of them, and loses strength where they open it. So a
point of soil that can open (`opens` of its law) keeps a share OWN of its own volume change: for it,

    m_v = (1 - OWN) (m_v above) + OWN S_v, in each of the two directions across

The internal force is the
derivative of the stored energy of F̄, so energy and both momenta are conserved as without F-bar, and the elastic tangent
is symmetric:

    f_v = Σ_p V0 [τ g_v + q H_v]        g_v = ΔF^-T ∇_n S_v,  h_v = ΔF_0^-T ∇_n M_v,  H_v = h_v - g_v,  q = P:τ / n
    K_vw = Σ_p V0 [g_v A g_w + (c g_v) H_w + H_v (e g_w) + κ H_v H_w + q (w-transposed g_v g_w - h_v h_w)]

P the identity on the axes that deform, C_ijkl = ∂τ_ij/∂l_kl, c = C:P/n, e = P:C/n, κ = P:C:P/n². Sorted by g and h, and
with the gradients at the start of the step, which are fixed within an increment, this is

    K_vw,ik = Σ_p ∂_m S_v B_im + ∂_m M_v S_im
    B_im    = V0 [Â_imkn ∂_n S_w + ĉ_im h_w,k]
    S_im    = V0 [ΔF_0^-1_mi (ê_kn ∂_n S_w + κ h_w,k) - q ΔF_0^-1_mk h_w,i]

    Â_imkn  = ΔF^-1_mj ΔF^-1_nl [A_ijkl - c_ij δ_kl - δ_ij e_kl + κ δ_ij δ_kl + q δ_il δ_jk]
    ĉ_im    = ΔF^-1_mj (c_ij - κ δ_ij)          ê_kn = ΔF^-1_nl (e_kl - κ δ_kl)

B and S are arrays over the components (w, k) of a point's nodes, summed and added as in `hybrid.soil.boxes`. The tangent
of a point follows from COUNT numbers: Â, ĉ, ê, ΔF_0^-1, κ and q.

The value at the element's centre is used by de Souza Neto, Perić, Dutko & Owen, Int. J. Solids Struct. 33 (1996)
3277-3296, and for material points by Coombs et al., Comput. Methods Appl. Mech. Eng. 333 (2018) 1-21. Their force has
the gradient g_v in all terms; the force used here is the derivative of the energy, as in the mean dilatation method of
Simo, Taylor & Pister, ibid. 51 (1985) 177-208.

Equations: FORMULATION (22) to (24).
"""

from typing import NamedTuple

import numpy as np

from hybrid.runtime.jit import njit, prange
from hybrid.soil.basis import Basis
from hybrid.soil.boxes import STRIDE
from hybrid.soil.tangent import combine

CUT = 0.1       # share of a cell that is empty, from which on it counts as cut
OWN = 0.1       # share of its own volume change that a point of soil keeps which can open
COUNT = 110                                         # numbers that the tangent of a point follows from
C_AT, E_AT, INVERSE_AT, SCALARS_AT = 81, 90, 99, 108        # where ĉ, ê, ΔF_0^-1, and κ and q begin among them


def mean_basis(basis, cells, opens):
    """Basis with the values m_v and the gradients of `basis`: evaluated as `basis` for ∇_n S_v, it gives ∇_n M_v. cells:
    FilledCells of the same points; opens: (n,) bool, points of soil that can open, or one for all."""
    value, cut = np.zeros_like(basis.value), np.clip((1.0 - cells.share) / CUT, 0.0, 1.0)
    _mean_values(cells.first, basis.count, cells.parts, 0.5 + cut * (cells.centre - 0.5), value)
    own = np.reshape(np.where(opens, OWN, 0.0), (-1, 1, 1))
    return Basis(basis.first, basis.count, value + own * (basis.value - value), basis.gradient)


@njit(cache=True, parallel=True)
def _mean_values(first, count, parts, middle, value):
    """Fill m_v (n, 3, 3), with the middle of the soil along an axis as its mean over the cells across it."""
    for p in prange(len(first)):
        for a in range(2):
            for b in range(2):
                for c in range(2):
                    part = parts[p, 0, a] * parts[p, 1, b] * parts[p, 2, c]
                    if part == 0.0:
                        continue
                    i, j, k = first[p, 0] + a, first[p, 1] + b, first[p, 2] + c
                    for axis in range(3):
                        if count[p, axis] == 1:     # of a collapsed axis
                            value[p, axis, 0] += part
                            continue
                        node = a if axis == 0 else b if axis == 1 else c
                        value[p, axis, node] += part * (1.0 - middle[axis, i, j, k])
                        value[p, axis, node + 1] += part * middle[axis, i, j, k]


class MeanDilatation(NamedTuple):
    """Data of F-bar for a trial: values m_v (n, 3, 3) of the mean basis, ΔF_0^-1 (n, 3, 3), and the axes that deform
    (3,) bool."""

    value: np.ndarray
    inverse: np.ndarray
    deforms: np.ndarray


def mean_dilatation(mean, collapsed, trial):
    """MeanDilatation of a `trial` (TrialStrain), None without a `mean` basis; collapsed: (3,) bool, axes of the grid."""
    return None if mean is None else MeanDilatation(mean.value, trial.mean_inverse, ~collapsed)


@njit(cache=True, fastmath={"contract"})
def project(A, directions, stress, deforms, c, e):
    """Fill c = C:P/n and e = P:C/n (3, 3) of one point, C_ijkl = A_ijkl + τ_il δ_jk; returns κ and q."""
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
    return kappa, q


@njit(cache=True, fastmath={"contract"})
def mean_tangent(A, c, e, scalars, inverse, mean_inverse, work, out):
    """Fill `out` (COUNT,) with the numbers that the tangent of a point follows from.

    A: (81,), c, e: (3, 3), which are overwritten, and scalars: of `project`; inverse, mean_inverse: ΔF^-1, ΔF_0^-1
    (3, 3); work: (81,).
    """
    kappa, q = scalars
    for i in range(3):
        e[i, i] -= kappa
    for i in range(3):
        for j in range(3):
            for k in range(3):
                A[27 * i + 9 * j + 4 * k] -= c[i, j]
                A[36 * k + 3 * i + j] -= e[i, j]
            A[28 * i + 12 * j] += q
    for i in range(3):
        c[i, i] -= kappa
    for i in range(3):
        for m in range(3):
            combine(work, 27 * i + 9 * m, A, 27 * i, 27 * i + 9, 27 * i + 18, inverse[m, 0], inverse[m, 1], inverse[m, 2])
    for row in range(27):
        x, y, z = work[3 * row], work[3 * row + 1], work[3 * row + 2]
        for n in range(3):
            out[3 * row + n] = inverse[n, 0] * x + inverse[n, 1] * y + inverse[n, 2] * z
    for i in range(3):
        for m in range(3):
            at = 3 * i + m
            out[C_AT + at] = inverse[m, 0] * c[i, 0] + inverse[m, 1] * c[i, 1] + inverse[m, 2] * c[i, 2]
            out[E_AT + at] = inverse[m, 0] * e[i, 0] + inverse[m, 1] * e[i, 1] + inverse[m, 2] * e[i, 2]
            out[INVERSE_AT + at] = mean_inverse[i, m]
    out[SCALARS_AT], out[SCALARS_AT + 1] = kappa, q


@njit(cache=True, fastmath={"contract"})
def add_mean_terms(numbers, volume, column, nodes, columns, g, d, work, B):
    """Add the terms of ĉ to B_im, which contains V0 Â_imkn ∂_n S_w, and all terms to S_im, for the components of the
    nodes of a point.

    numbers: (COUNT,) of `mean_tangent`; volume: V0, negative to subtract; column, nodes, columns, B: as in
    `hybrid.soil.boxes`, S_im in row i after B_im; g, d: (28, 3) ∂S and ∂M; work: (8 STRIDE,) scratch. It takes, for the
    columns (w, k), h_w,k of the column's own component, what ΔF_0^-1_mi multiplies, q h_w,i and ΔF_0^-1_mk.
    """
    T, kappa, q = numbers[INVERSE_AT:SCALARS_AT], numbers[SCALARS_AT], numbers[SCALARS_AT + 1]
    c, e = numbers[C_AT:E_AT], numbers[E_AT:INVERSE_AT]
    for row in range(8):
        work[row * STRIDE:row * STRIDE + columns] = 0.0
    for n in range(nodes):
        dx, dy, dz = volume * d[n, 0], volume * d[n, 1], volume * d[n, 2]
        h = (T[0] * dx + T[3] * dy + T[6] * dz, T[1] * dx + T[4] * dy + T[7] * dz, T[2] * dx + T[5] * dy + T[8] * dz)
        for k in range(3):
            at = column[n] + k
            work[at] = h[k]
            work[at + STRIDE] = kappa * h[k] + volume * (
                e[3 * k] * g[n, 0] + e[3 * k + 1] * g[n, 1] + e[3 * k + 2] * g[n, 2])
            for i in range(3):
                work[at + (2 + i) * STRIDE], work[at + (5 + i) * STRIDE] = q * h[i], T[3 * i + k]
    own, both = work, work[STRIDE:]
    for i in range(3):
        turned = work[(2 + i) * STRIDE:]
        for m in range(3):
            _add_multiple(B[i, m * STRIDE:], c[3 * i + m], own, columns)
            _add_mean_row(B[i, (3 + m) * STRIDE:], T[3 * m + i], both, work[(5 + m) * STRIDE:], turned, columns)


@njit(cache=True, fastmath={"contract"})
def _add_multiple(out, factor, values, columns):
    for q in range(np.uintp(columns)):
        out[q] += factor * values[q]


@njit(cache=True, fastmath={"contract"})
def _add_mean_row(out, factor, both, inverse, turned, columns):
    """Add factor both - inverse turned to S_im."""
    for q in range(np.uintp(columns)):
        out[q] += factor * both[q] - inverse[q] * turned[q]
