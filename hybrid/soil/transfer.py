"""Transfer between points and nodes.

    m_v = Σ_p S_vp m_p      q_v = Σ_p S_vp m_p q_p / m_v      (projection with the lumped mass: v, a)
    q_p = Σ_v S_vp q_v                                        (interpolation)

Mass and momentum are conserved to round-off because the basis is a partition of unity. The projection also conserves
angular momentum, because the basis reproduces positions.

`soil.transfer` selects how velocities of the points follow from those of the nodes, with Δv_v = v_v,n+1 - v_v,n:

    increments   v_p + Σ S_vp Δv_v                                       keeps what the grid does not resolve
    affine       Σ S_vp v_v,n+1, and C_p (x_v - x_p) in the projection   C_p = Σ S_vp v_v ⊗ (x_v - x_p) D_p^-1,
                                                                         D_p = Σ S_vp (x_v - x_p) ⊗ (x_v - x_p)

D_p is diagonal on a tensor-product grid. Accelerations of the points are always interpolated from the nodes; with
affine transfer their gradients are too, because projection and interpolation without gradients smooth the
accelerations, which acts as damping of first order in Δt.

Affine: Jiang, Schroeder, Selle, Teran & Stomakhin, ACM Trans. Graph. 34 (2015) 51.

Equations: FORMULATION (5) to (7).
"""

from typing import NamedTuple

import numpy as np

from hybrid.grid.numbering import node_number
from hybrid.runtime.jit import njit, prange
from hybrid.soil.basis import with_margin


class _PointFields(NamedTuple):
    """Data of the points that are projected: position (n, 3) [m], mass (n,) [kg], fields (f, n, 3), and affine
    (n, k, 3, 3), the gradients C_p of the first k fields."""

    position: np.ndarray
    mass: np.ndarray
    fields: np.ndarray
    affine: np.ndarray


def points_to_grid(basis, slabs, axes, position, mass, *fields, affine=None, summed=None):
    """Nodal mass (N,) [kg], and a nodal field (N, 3) for each field (n, 3) of the points; zero at nodes without mass.

    position: (n, 3) [m]; mass: (n,) [kg]; affine: (n, k, 3, 3), the gradients C_p of the first k fields, or None; summed:
    function that adds up nodal values (N, ...) over processes.
    """
    affine = np.empty((len(position), 0, 3, 3)) if affine is None else np.ascontiguousarray(affine)
    nodes = int(np.prod([len(a) for a in axes]))
    m, nodal = np.zeros(nodes), np.zeros((len(fields), nodes, 3))
    _points_to_grid(slabs, basis, tuple(axes), _PointFields(position, mass, np.stack(fields), affine), m, nodal)
    if summed is not None:
        m, nodal = summed(m), np.stack([summed(values) for values in nodal])
    filled = m > 0
    nodal[:, filled] /= m[filled, None]
    return m, *nodal


def interpolate(basis, shape, nodal):
    """Values (n, 3) of a nodal field (N, 3) at the points."""
    out = np.empty((len(basis.first), 3))
    _interpolate(basis, tuple(shape), with_margin(nodal, shape), out)
    return out


def grid_to_points(basis, axes, position, fields):
    """Values and gradients C_p of k nodal fields, each (N, 3), at points at `position` (n, 3) [m].

    Returns a list of k arrays (n, 3), and C_p (n, k, 3, 3).
    """
    values, affine = [np.empty((len(position), 3)) for _ in fields], np.empty((len(position), len(fields), 3, 3))
    shape = [len(nodes) for nodes in axes]
    for f, nodal in enumerate(fields):
        _grid_to_points(basis, tuple(axes), position, with_margin(nodal, shape), values[f], affine[:, f])
    return values, affine


@njit(cache=True, parallel=True, fastmath={"contract"})
def _points_to_grid(slabs, basis, axes, points, m, nodal):
    (order, start), (x, y, z), (position, mass, fields, affine) = slabs, axes, points
    first, count, value, _ = basis
    shape = len(x), len(y), len(z)
    for colour in range(2):
        for pair in prange((len(start) - colour) // 2):
            slab = 2 * pair + colour
            for n in range(start[slab], start[slab + 1]):
                p = order[n]
                for a in range(count[p, 0]):
                    for b in range(count[p, 1]):
                        v = node_number(shape, first[p, 0] + a, first[p, 1] + b, first[p, 2])
                        along = mass[p] * value[p, 0, a] * value[p, 1, b]
                        for c in range(count[p, 2]):
                            m[v + c] += along * value[p, 2, c]
                        for f in range(len(fields)):
                            q0, q1, q2, g0, g1, g2 = fields[f, p, 0], fields[f, p, 1], fields[f, p, 2], 0.0, 0.0, 0.0
                            if f < affine.shape[1]:
                                r0, r1 = x[first[p, 0] + a] - position[p, 0], y[first[p, 1] + b] - position[p, 1]
                                q0 += affine[p, f, 0, 0] * r0 + affine[p, f, 0, 1] * r1
                                q1 += affine[p, f, 1, 0] * r0 + affine[p, f, 1, 1] * r1
                                q2 += affine[p, f, 2, 0] * r0 + affine[p, f, 2, 1] * r1
                                g0, g1, g2 = affine[p, f, 0, 2], affine[p, f, 1, 2], affine[p, f, 2, 2]
                            for c in range(count[p, 2]):
                                w, r2 = along * value[p, 2, c], z[first[p, 2] + c] - position[p, 2]
                                nodal[f, v + c, 0] += w * (q0 + g0 * r2)
                                nodal[f, v + c, 1] += w * (q1 + g1 * r2)
                                nodal[f, v + c, 2] += w * (q2 + g2 * r2)


@njit(cache=True, parallel=True, fastmath={"contract"})
def _interpolate(basis, shape, nodal, out):
    first, value = basis.first, basis.value
    for p in prange(len(first)):
        q0, q1, q2, w0, w1, w2 = 0.0, 0.0, 0.0, value[p, 2, 0], value[p, 2, 1], value[p, 2, 2]
        for a in range(3):
            for b in range(3):
                v = node_number(shape, first[p, 0] + a, first[p, 1] + b, first[p, 2])
                w = value[p, 0, a] * value[p, 1, b]
                q0 += w * (nodal[v, 0] * w0 + nodal[v + 1, 0] * w1 + nodal[v + 2, 0] * w2)
                q1 += w * (nodal[v, 1] * w0 + nodal[v + 1, 1] * w1 + nodal[v + 2, 1] * w2)
                q2 += w * (nodal[v, 2] * w0 + nodal[v + 1, 2] * w1 + nodal[v + 2, 2] * w2)
        out[p, 0], out[p, 1], out[p, 2] = q0, q1, q2


@njit(cache=True, parallel=True, fastmath={"contract"})
def _grid_to_points(basis, axes, position, nodal, out, affine):
    """Values q and gradients C_p of one field, summed along z, then y, then x.

    C_p uses weight times arm, S_vp (x_v - x_p), where the gradient of the field would use ∇S_vp. Beyond the last node
    of the grid the weight is zero, so that any arm may be used there.
    """
    (x, y, z), first, value = axes, basis.first, basis.value
    shape = len(x), len(y), len(z)
    for p in prange(len(first)):
        k, top, w0, w1, w2 = first[p, 2], len(z) - 1, value[p, 2, 0], value[p, 2, 1], value[p, 2, 2]
        r0, r1, r2 = z[k] - position[p, 2], z[min(k + 1, top)] - position[p, 2], z[min(k + 2, top)] - position[p, 2]
        arm0, arm1, arm2 = w0 * r0, w1 * r1, w2 * r2
        dx, dy, dz = 0.0, 0.0, arm0 * r0 + arm1 * r1 + arm2 * r2
        q0, q1, q2 = 0.0, 0.0, 0.0
        xx, xy, xz, yx, yy, yz, zx, zy, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for a in range(3):
            t0, t1, t2, tx, ty, tz, ux, uy, uz, squares = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            for b in range(3):
                r1 = y[min(first[p, 1] + b, len(y) - 1)] - position[p, 1]
                v = node_number(shape, first[p, 0] + a, first[p, 1] + b, k)
                s0 = nodal[v, 0] * w0 + nodal[v + 1, 0] * w1 + nodal[v + 2, 0] * w2
                s1 = nodal[v, 1] * w0 + nodal[v + 1, 1] * w1 + nodal[v + 2, 1] * w2
                s2 = nodal[v, 2] * w0 + nodal[v + 1, 2] * w1 + nodal[v + 2, 2] * w2
                w, along = value[p, 1, b], value[p, 1, b] * r1
                squares += along * r1
                t0 += s0 * w
                t1 += s1 * w
                t2 += s2 * w
                tx += s0 * along
                ty += s1 * along
                tz += s2 * along
                ux += w * (nodal[v, 0] * arm0 + nodal[v + 1, 0] * arm1 + nodal[v + 2, 0] * arm2)
                uy += w * (nodal[v, 1] * arm0 + nodal[v + 1, 1] * arm1 + nodal[v + 2, 1] * arm2)
                uz += w * (nodal[v, 2] * arm0 + nodal[v + 1, 2] * arm1 + nodal[v + 2, 2] * arm2)
            r0, w = x[min(first[p, 0] + a, len(x) - 1)] - position[p, 0], value[p, 0, a]
            along = w * r0
            dx += along * r0
            dy += w * squares
            q0 += t0 * w
            q1 += t1 * w
            q2 += t2 * w
            xx += t0 * along
            yx += t1 * along
            zx += t2 * along
            xy += tx * w
            yy += ty * w
            zy += tz * w
            xz += ux * w
            yz += uy * w
            zz += uz * w
        out[p, 0], out[p, 1], out[p, 2] = q0, q1, q2
        # D_p is zero along a collapsed axis, and for a point of standard MPM at the position of a node: no gradient
        dx = 1.0 / dx if dx > 0.0 and len(x) > 1 else 0.0
        dy = 1.0 / dy if dy > 0.0 and len(y) > 1 else 0.0
        dz = 1.0 / dz if dz > 0.0 and len(z) > 1 else 0.0
        affine[p, 0, 0], affine[p, 0, 1], affine[p, 0, 2] = xx * dx, xy * dy, xz * dz
        affine[p, 1, 0], affine[p, 1, 1], affine[p, 1, 2] = yx * dx, yy * dy, yz * dz
        affine[p, 2, 0], affine[p, 2, 1], affine[p, 2, 2] = zx * dx, zy * dy, zz * dz
