"""Transfer between points and nodes.

    m_v = Σ_p S_vp m_p      q_v = Σ_p S_vp m_p q_p / m_v      (projection with the lumped mass: v, a)
    q_p = Σ_v S_vp q_v                                        (interpolation)

Mass and momentum are conserved to round-off because the basis is a partition of unity; so is angular momentum by
the projection, because the basis reproduces positions.

How points take up the rates of the nodes, Δv_v = v_v,n+1 - v_v,n, is a choice (`soil.transfer`):

    increments   v_p + Σ S_vp Δv_v                                       keeps what the grid does not see
    blended      (1 - s) of that and s Σ S_vp v_v,n+1                    s of what the grid does not see goes a step
    affine       Σ S_vp v_v,n+1, and C_p (x_v - x_p) in the projection   C_p = Σ S_vp v_v ⊗ (x_v - x_p) D_p^-1,
                                                                         D_p = Σ S_vp (x_v - x_p) ⊗ (x_v - x_p)

D_p is diagonal on a tensor-product grid. Accelerations are always taken from the nodes, by affine transfer with their
gradients too: what the way there and back takes off them acts as damping of first order in Δt.

Affine: Jiang, Schroeder, Selle, Teran & Stomakhin, ACM Trans. Graph. 34 (2015) 51; blended: Stomakhin, Schroeder,
Chai, Teran & Selle, ibid. 32 (2013) 102.
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


def affine_part(basis, slabs, axes, position, mass, affine, nodal_mass):
    """What gradients C_p (n, k, 3, 3) of points at `position` (n, 3) [m] add to the projection of k fields,
    (N, k, 3)."""
    out = np.zeros((len(nodal_mass), affine.shape[1], 3))
    _affine_part(slabs.order, slabs.start, basis.first, basis.count, basis.value, *axes, position, mass,
                 np.ascontiguousarray(affine), out)
    filled = nodal_mass > 0
    out[filled] /= nodal_mass[filled, None, None]
    return out


def gradient(basis, axes, position, nodal):
    """C_p (n, k, 3, 3) of nodal fields (N, k, 3) at points of `position` (n, 3) [m]."""
    out = np.zeros((len(position), *nodal.shape[1:], 3))
    _gradient(basis.first, basis.count, basis.value, *axes, position, nodal, out)
    return out


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
        at = out[p]
        for i in range(len(at)):
            at[i] = 0.0
        for a in range(count[p, 0]):
            for b in range(count[p, 1]):
                along = value[p, 0, a] * value[p, 1, b]
                for c in range(count[p, 2]):
                    v, w = ((first[p, 0] + a) * ny + first[p, 1] + b) * nz + first[p, 2] + c, along * value[p, 2, c]
                    for i in range(len(at)):
                        at[i] += w * nodal[v, i]


@njit(cache=True, parallel=True)
def _affine_part(order, start, first, count, value, x, y, z, position, mass, affine, out):
    slabs = len(start) - 1
    for colour in range(2):
        for half in prange((slabs - colour + 1) // 2):
            slab = 2 * half + colour
            for n in range(start[slab], start[slab + 1]):
                p = order[n]
                C = affine[p]
                for a in range(count[p, 0]):
                    for b in range(count[p, 1]):
                        for c in range(count[p, 2]):
                            i, j, k = first[p, 0] + a, first[p, 1] + b, first[p, 2] + c
                            w = value[p, 0, a] * value[p, 1, b] * value[p, 2, c] * mass[p]
                            r0, r1, r2 = x[i] - position[p, 0], y[j] - position[p, 1], z[k] - position[p, 2]
                            v = (i * len(y) + j) * len(z) + k
                            for f in range(len(C)):
                                for q in range(3):
                                    out[v, f, q] += w * (C[f, q, 0] * r0 + C[f, q, 1] * r1 + C[f, q, 2] * r2)


@njit(cache=True, parallel=True)
def _gradient(first, count, value, x, y, z, position, nodal, out):
    for p in prange(len(first)):
        d0, d1, d2 = 0.0, 0.0, 0.0
        for a in range(count[p, 0]):
            d0 += value[p, 0, a] * (x[first[p, 0] + a] - position[p, 0]) ** 2
        for b in range(count[p, 1]):
            d1 += value[p, 1, b] * (y[first[p, 1] + b] - position[p, 1]) ** 2
        for c in range(count[p, 2]):
            d2 += value[p, 2, c] * (z[first[p, 2] + c] - position[p, 2]) ** 2
        for a in range(count[p, 0]):
            for b in range(count[p, 1]):
                for c in range(count[p, 2]):
                    i, j, k = first[p, 0] + a, first[p, 1] + b, first[p, 2] + c
                    w = value[p, 0, a] * value[p, 1, b] * value[p, 2, c]
                    v = (i * len(y) + j) * len(z) + k
                    r0, r1, r2 = w * (x[i] - position[p, 0]), w * (y[j] - position[p, 1]), w * (z[k] - position[p, 2])
                    for f in range(nodal.shape[1]):
                        for q in range(3):
                            out[p, f, q, 0] += nodal[v, f, q] * r0
                            out[p, f, q, 1] += nodal[v, f, q] * r1
                            out[p, f, q, 2] += nodal[v, f, q] * r2
        for f in range(nodal.shape[1]):
            for q in range(3):   # a point that sits on a node line of standard MPM has no arm, and no gradient
                out[p, f, q, 0] = out[p, f, q, 0] / d0 if d0 > 0.0 and len(x) > 1 else 0.0
                out[p, f, q, 1] = out[p, f, q, 1] / d1 if d1 > 0.0 and len(y) > 1 else 0.0
                out[p, f, q, 2] = out[p, f, q, 2] / d2 if d2 > 0.0 and len(z) > 1 else 0.0
