"""Forces and tangent of contact into the residual and the block system.

With F the force of the penalty on a contact point (as a residual), r = x_c - c, B = [I, -I, r̃] acting on (δx_c, δc, δφ),
δφ spatial, and D = ∂F/∂x_c at fixed attitude,

    residual B^T F          K = B^T D B - B^T F̃ E_φ + E_φ^T F̃ [I, -I, 0]

(FORMULATION (42)). δx_c = Σ_v N_v δu_v distributes the first block over the nodes of the point's cell. Point and
body get opposite forces: the columns of B cancel, so force and moment vanish in sum to round-off.
"""

from enum import Enum

import numpy as np

from hybrid.body.attitude import skews
from hybrid.linalg.stencil import CELL, Blocks, entry, relative_place
from hybrid.runtime.comm import total
from hybrid.runtime.jit import njit


class Tangent(Enum):
    """Which tangent of contact Newton's method uses (`hybrid.step.newton`)."""

    CONSISTENT = "derivative of the forces"
    UNSOFTENED = "without the softening of contact at convex edges"
    DEFINITE = "nor with shear on the ramp of adhesion following the pressure"


def add_residual(contact, points, force):
    """Add contact to nodal residuals (N, 3) [N], None when the soil is held; returns the body's residual (6,)
    [N, N m about its centre]."""
    if force is not None:
        _scatter(contact.active, points.node, points.weight, contact.force, force)
    return -contact.resultant


def derivative(contact, kind):
    """∂F/∂x_c (m, 3, 3) [N/m] of a kind of Tangent.

    UNSOFTENED: without the negative eigenvalues of its turning part, FORMULATION (42a): a convex edge pushes a contact point
    aside with a stiffness of -p/r, and Newton's method may go to and fro there. DEFINITE: nor with shear on the ramp of
    adhesion following the pressure, ten times as much: points that just touch make it singular."""
    if kind is Tangent.CONSISTENT:
        return contact.tangent
    turning = 0.5 * (contact.turning + contact.turning.transpose(0, 2, 1))
    values, vectors = np.linalg.eigh(turning)
    tangent = contact.tangent - contact.ramp if kind is Tangent.DEFINITE else contact.tangent
    return tangent - (vectors * np.minimum(values, 0.0)[:, None]) @ vectors.transpose(0, 2, 1)


def body_tangent(contact, D=None):
    """K_ww (6, 6) of contact and Q (m, 3, 6) = ∂F/∂(δc, δφ) of every contact point. D: (m, 3, 3) [N/m] ∂F/∂x_c, that of the
    `contact` unless given."""
    F, arm, D = skews(contact.force), skews(contact.arm), contact.tangent if D is None else D
    Q = np.concatenate([-D, D @ arm - F], axis=2)
    moments = arm @ Q
    moments[:, :, :3] += F
    return -total(np.concatenate([Q, moments], axis=1)), Q


def add_tangent(contact, points, D, Q, pattern, values, free, uw, wu):
    """Add K_uu to `values`, K_uw and K_wu to dense blocks (n, m) and (m, n) over the soil unknowns and the m
    components of the body that are `free` (6,); D, Q: as in `body_tangent`."""
    arm = skews(contact.arm)
    rows = np.concatenate([-D, skews(contact.force) - arm @ D], axis=1)  # ∂(body residual)/∂x_c, (m, 6, 3)
    _add_tangent(contact.active, points.node, points.weight, D,
                 np.ascontiguousarray(Q[:, :, free]), np.ascontiguousarray(rows[:, free]),
                 pattern.sparsity, Blocks(values, uw, wu))


@njit(cache=True)
def _scatter(active, node, weight, contact_force, force):
    """Add the forces (m, 3) of points `active` to those of their nodes, (N, 3)."""
    for n in range(len(active)):
        c = active[n]
        for a in range(8):
            for i in range(3):
                force[node[c, a], i] += weight[c, a] * contact_force[n, i]


@njit(cache=True)
def _add_tangent(active, node, weight, D, Q, rows, sparsity, blocks):
    """D: (m, 3, 3) ∂F/∂x_c; Q: (m, 3, q) ∂F/∂(body unknowns); rows: (m, q, 3) ∂(body residual)/∂x_c."""
    dof, values, uw, wu = sparsity.dof, blocks.uu, blocks.uw, blocks.wu
    for n in range(len(active)):
        c = active[n]
        for a in range(8):
            v = node[c, a]
            for i in range(3):
                if dof[v, i] < 0 or weight[c, a] == 0.0:
                    continue
                for q in range(len(wu)):
                    uw[dof[v, i], q] += weight[c, a] * Q[n, i, q]
                    wu[q, dof[v, i]] += weight[c, a] * rows[n, q, i]
                for b in range(8):
                    w = node[c, b]
                    if weight[c, b] == 0.0:
                        continue
                    at = entry(sparsity, v, i, relative_place(CELL[a], CELL[b]))
                    for k in range(3):
                        if dof[w, k] >= 0:
                            values[at] += weight[c, a] * weight[c, b] * D[n, i, k]
                            at += 1
