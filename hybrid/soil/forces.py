"""Internal force of the soil.

With τ the Kirchhoff stress, g_v = ΔF^-T ∇_n S_v the current gradient and V0 the initial volume,

    f_v,i = Σ_p V0 τ_ij g_v,j

(formulation section 3; there with σ = τ/J and V = J V0). Its derivative is in `hybrid.soil.stiffness`.
"""

import numpy as np
from numba import njit, prange


def internal_force(basis, slabs, shape, trial, stress, volume):
    """Nodal internal force (N, 3) [N] from Kirchhoff stress (n, 3, 3) [Pa] and initial volumes (n,) [m³]."""
    force = np.zeros((int(np.prod(shape)), 3))
    _internal_force(slabs.order, slabs.start, basis.first, basis.count, basis.value, basis.slope, shape[1], shape[2],
                    trial.inverse, stress, volume, force)
    return force


@njit(cache=True)
def gradients(p, first, count, value, slope, ny, nz, inverse, node, g):
    """Nodes and current gradients of one point; returns how many."""
    m = 0
    for a in range(count[p, 0]):
        for b in range(count[p, 1]):
            for c in range(count[p, 2]):
                g0 = slope[p, 0, a] * value[p, 1, b] * value[p, 2, c]
                g1 = value[p, 0, a] * slope[p, 1, b] * value[p, 2, c]
                g2 = value[p, 0, a] * value[p, 1, b] * slope[p, 2, c]
                node[m] = ((first[p, 0] + a) * ny + first[p, 1] + b) * nz + first[p, 2] + c
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
            node, g = np.empty(27, np.int64), np.empty((27, 3))
            for n in range(start[slab], start[slab + 1]):
                p = order[n]
                m = gradients(p, first, count, value, slope, ny, nz, inverse, node, g)
                for a in range(m):
                    for i in range(3):
                        force[node[a], i] += volume[p] * (stress[p, i, 0] * g[a, 0] + stress[p, i, 1] * g[a, 1]
                                                          + stress[p, i, 2] * g[a, 2])
