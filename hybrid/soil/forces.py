"""Internal force of the soil.

With τ the Kirchhoff stress, g_v = ΔF^-T ∇_n S_v the current gradient and V0 the initial volume,

    f_v,i = Σ_p V0 τ_ij g_v,j = Σ_p P_ij ∂_n,j S_v       P = V0 τ ΔF^-T

(FORMULATION (11); there with σ = τ/J and V = J V0). With F-bar (`hybrid.soil.fbar`) q h_v is added and q g_v subtracted,
q = P:τ / n, in the same pass over the points. Its derivative is in `hybrid.soil.stiffness`.
"""

import numpy as np

from hybrid.grid.numbering import node_number
from hybrid.runtime.jit import njit, prange


def internal_force(basis, slabs, shape, trial, stress, volume, dilatation=None):
    """Nodal internal force (N, 3) [N] from Kirchhoff stress (n, 3, 3) [Pa] and initial volumes (n,) [m³].

    dilatation: MeanDilatation of F-bar, None without.
    """
    force = np.zeros((int(np.prod(shape)), 3))
    _internal_force(slabs, basis, shape, trial.inverse, stress, volume, dilatation, force)
    return force


@njit(cache=True)
def reference_gradients(p, first, count, value, gradient, shape, node, g):
    """Nodes and gradients ∇_n S of one point; returns how many."""
    m = 0
    for a in range(count[p, 0]):
        for b in range(count[p, 1]):
            along_x, along_y = gradient[p, 0, a] * value[p, 1, b], value[p, 0, a] * gradient[p, 1, b]
            both = value[p, 0, a] * value[p, 1, b]
            for c in range(count[p, 2]):
                node[m] = node_number(shape, first[p, 0] + a, first[p, 1] + b, first[p, 2] + c)
                g[m, 0], g[m, 1], g[m, 2] = along_x * value[p, 2, c], along_y * value[p, 2, c], both * gradient[p, 2, c]
                m += 1
    return m


@njit(cache=True, parallel=True)
def _internal_force(slabs, basis, shape, inverse, stress, volume, dilatation, force):
    (order, start), (first, count, value, gradient) = slabs, basis     # at no cost, unlike access in the loops
    for colour in range(2):
        for pair in prange((len(start) - colour) // 2):
            slab, T, P = 2 * pair + colour, np.empty((3, 3)), np.empty((3, 3))
            for n in range(start[slab], start[slab + 1]):
                p = order[n]
                for i in range(3):
                    for j in range(3):
                        T[i, j] = volume[p] * stress[p, i, j]
                if dilatation is not None:
                    q = _mean_pressure(T, dilatation.deforms)
                    for i in range(3):
                        T[i, i] -= q
                        for j in range(3):
                            P[i, j] = q * dilatation.inverse[p, j, i]
                    _add_force(p, first, count, dilatation.value, gradient, shape, P, force)
                for i in range(3):
                    for j in range(3):
                        P[i, j] = T[i, 0] * inverse[p, j, 0] + T[i, 1] * inverse[p, j, 1] + T[i, 2] * inverse[p, j, 2]
                _add_force(p, first, count, value, gradient, shape, P, force)


@njit(cache=True)
def _mean_pressure(stress, deforms):
    """P:τ / n of one point; deforms: (3,) bool, the n axes that deform."""
    q, axes = 0.0, 0
    for i in range(3):
        if deforms[i]:
            q += stress[i, i]
            axes += 1
    return q / axes


@njit(cache=True, fastmath={"contract"})
def _add_force(p, first, count, value, gradient, shape, P, force):
    """Add P_ij ∂_n,j S_v of one point; what nodes that differ in z only share is formed once."""
    for a in range(count[p, 0]):
        for b in range(count[p, 1]):
            along_x, along_y = gradient[p, 0, a] * value[p, 1, b], value[p, 0, a] * gradient[p, 1, b]
            along_z = value[p, 0, a] * value[p, 1, b]
            fx, gx = P[0, 0] * along_x + P[0, 1] * along_y, P[0, 2] * along_z
            fy, gy = P[1, 0] * along_x + P[1, 1] * along_y, P[1, 2] * along_z
            fz, gz = P[2, 0] * along_x + P[2, 1] * along_y, P[2, 2] * along_z
            v = node_number(shape, first[p, 0] + a, first[p, 1] + b, first[p, 2])
            for c in range(count[p, 2]):
                s, d = value[p, 2, c], gradient[p, 2, c]
                force[v + c, 0] += fx * s + gx * d
                force[v + c, 1] += fy * s + gy * d
                force[v + c, 2] += fz * s + gz * d
