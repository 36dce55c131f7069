"""Transfer between points and nodes.

    m_v = Σ_p S_vp m_p      q_v = Σ_p S_vp m_p q_p / m_v      (projection with the lumped mass: v, a)
    q_p = Σ_v S_vp q_v                                        (interpolation)

Mass and momentum are conserved to round-off because the basis is a partition of unity.
"""

import numpy as np
from numba import njit, prange


def project(basis, slabs, shape, mass, *fields):
    """Nodal mass (N,) [kg] and fields (N, 3) from those of the points, each (n, 3); zero where no point reaches."""
    nodes = int(np.prod(shape))
    m, nodal = np.zeros(nodes), np.zeros((len(fields), nodes, 3))
    _project(slabs.order, slabs.start, basis.first, basis.count, basis.value, shape[1], shape[2],
             mass, np.stack(fields), m, nodal)
    filled = m > 0
    nodal[:, filled] /= m[filled, None]
    return m, *nodal


def interpolate(basis, shape, nodal):
    """Values (n, k) at the points of nodal fields (N, k)."""
    out = np.empty((len(basis.first), nodal.shape[1]))
    _interpolate(basis.first, basis.count, basis.value, shape[1], shape[2], nodal, out)
    return out


@njit(cache=True, parallel=True)
def _project(order, start, first, count, value, ny, nz, mass, fields, m, nodal):
    slabs = len(start) - 1
    for colour in range(2):
        for half in prange((slabs - colour + 1) // 2):
            slab = 2 * half + colour
            for n in range(start[slab], start[slab + 1]):
                p = order[n]
                for a in range(count[p, 0]):
                    for b in range(count[p, 1]):
                        for c in range(count[p, 2]):
                            v = ((first[p, 0] + a) * ny + first[p, 1] + b) * nz + first[p, 2] + c
                            w = value[p, 0, a] * value[p, 1, b] * value[p, 2, c] * mass[p]
                            m[v] += w
                            for f in range(len(fields)):
                                for i in range(3):
                                    nodal[f, v, i] += w * fields[f, p, i]


@njit(cache=True, parallel=True)
def _interpolate(first, count, value, ny, nz, nodal, out):
    for p in prange(len(first)):
        for i in range(nodal.shape[1]):
            total = 0.0
            for a in range(count[p, 0]):
                for b in range(count[p, 1]):
                    for c in range(count[p, 2]):
                        v = ((first[p, 0] + a) * ny + first[p, 1] + b) * nz + first[p, 2] + c
                        total += value[p, 0, a] * value[p, 1, b] * value[p, 2, c] * nodal[v, i]
            out[p, i] = total
