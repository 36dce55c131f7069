"""Second pass of contact: samples of the body's surface against exposed faces of the points' domains.

Corners miss what fits between them: a sharp edge, a tip, the smooth bottom of a sphere. With the symbols of
contact/exposed_faces.py, for a sample at x_s = c + R y_s assigned to a face,

    w_a = 1/4 + ξ^α s_αa/4      foot = Σ w_a x_a = x_s - g n      p = λ - ε_N g > 0      ε_N = -p_f E n·a_s
    τ = (ξ^α - ξ_0^α) e_α       stick  t = ε_T τ,  |t| <= μ p      slip  t = μ p s,  s = τ/|τ|
    F = -p n + t                residual:  F on the body with moment (foot - c) × F,  -w_a F on the corners

with the vector area a_s of the sample; force and moment cancel to round-off. τ is the tangential gap, ξ_0 the anchor of
the tangential spring. With u = δx_s - Σ w_a δx_a, h_β = n·δe_β and m_αβ = e_α·e_β,

    δg = n·u     δn = -h_α e^α     δξ^α = e^α·u + g m^αβ h_β     δτ = δξ^α e_α + (ξ^α - ξ_0^α) δe_α

gives the full tangent. Between steps the anchor is a material point of the soil, kept in space, so that a sample may go
on to the next face. Frozen during a step: the face of each sample, ε_N and ξ_0.

Equations: FORMULATION (45).
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from hybrid.contact.assembly import skew
from hybrid.contact.exposed_faces import Frame, U, V, assign, crossing, exposed_faces
from hybrid.grid.numbering import node_indices
from hybrid.linalg.stencil import Blocks, in_stencil, offset_in_row, place_of_offset, row_start
from hybrid.runtime.comm import total

SLOPES = np.stack([U, V])  # c_αa = ∂w_a/∂ξ^α


@dataclass(frozen=True)
class SampleSet:
    """Samples of a body near the soil, frozen during a step; m of them.

    id: (m,) increasing, number of the sample; position: (m, 3) [m] y_s, body frame; corner: (m, 4) of its face, indices
    into Corners; stiffness: (m,) ε_N [N/m]; anchor: (m, 2) ξ_0; origin: (m, 2) ξ where the path begins along which
    friction does work in this step; pressure: (m,) [N] multiplier of the augmented Lagrangian; triangle: (m,) and
    weights: (m, 3), as in body.samples.Samples
    """

    id: np.ndarray
    position: np.ndarray
    corner: np.ndarray
    stiffness: np.ndarray
    anchor: np.ndarray
    origin: np.ndarray
    pressure: np.ndarray
    triangle: np.ndarray
    weights: np.ndarray

    def __len__(self):
        return len(self.id)


@dataclass(frozen=True)
class SampleContact:
    """Samples in contact at a trial state; m of them, in space.

    active, gap, arm, slip, pressure, triangle, weights, energy, dissipated: as in soil_to_body.CornerContact
    normal: (m, 3) n of the face; force: (m, 3) [N] -F, minus the force on the soil
    anchor: (m, 3) [m] in space, the anchor of the history once the state is accepted; shares: (m, 4) w_a of the corners
    matrix: (m, 18, 18) tangent of (force, moment, corners) with respect to (δc, δφ, δx_a)
    """

    active: np.ndarray
    gap: np.ndarray
    normal: np.ndarray
    force: np.ndarray
    arm: np.ndarray
    slip: np.ndarray
    anchor: np.ndarray
    pressure: np.ndarray
    triangle: np.ndarray
    weights: np.ndarray
    shares: np.ndarray
    matrix: np.ndarray
    energy: float
    dissipated: float

    def __len__(self):
        return len(self.active)


def find_samples(samples, points, grid, corners, body, reach, stiffness, history, expected):
    """SampleSet of those `samples` (body.samples.Samples) that the predicted motion brings near an exposed face.

    points: soil points; body: BodyState; reach: [m]; stiffness: (n,) ε_N per area of contact [N/m³] against each point;
    history: (id, anchor (m, 3) [m] in space, pressure [N]) of the samples in contact; expected: nodal increments and
    pose as for find_corners.
    """
    face, point = exposed_faces(points.position, points.half_width, grid, corners)
    start, end = corners.position[face], corners.moved(expected[0])[face]
    position, rotation = expected[1]
    x, area = position + samples.position @ rotation.T, samples.area @ rotation.T
    touching = np.zeros(len(samples), bool)
    touching[history[0]] = True
    chosen, facing_area = assign(x, area, end, 2 * points.half_width[point].max(axis=1, initial=0.0), reach, touching)
    id = np.flatnonzero(facing_area > 0)
    chosen, facing_area = chosen[id], facing_area[id]
    anchor, origin = crossing(samples.position[id], body, expected[1], start[chosen], end[chosen])
    pressure = np.zeros(len(id))
    _, old, new = np.intersect1d(history[0], id, assume_unique=True, return_indices=True)
    anchor[new] = origin[new] = Frame.from_corners(start[chosen[new]]).local_coordinates(history[1][old])[0]
    pressure[new] = history[2][old]
    return SampleSet(id, samples.position[id], face[chosen], facing_area * stiffness[point[chosen]], anchor, origin,
                     pressure, samples.triangle[id], samples.weights[id])


def evaluate(samples, position, centre, rotation, friction, tangential):
    """SampleContact of a SampleSet with all corners at `position` (., 3) [m] and the body at `centre` (3,) [m],
    `rotation` (3, 3). friction: μ; tangential: ε_T/ε_N."""
    arm = samples.position @ rotation.T
    frame = Frame.from_corners(position[samples.corner])
    xi, gap = frame.local_coordinates(centre + arm)
    active = np.flatnonzero(samples.pressure - samples.stiffness * gap > 0.0)
    frame = frame.select(active)
    arm, xi, gap, stiffness = arm[active], xi[active], gap[active], samples.stiffness[active]
    p, from_anchor = samples.pressure[active] - stiffness * gap, xi - samples.anchor[active]
    shares = 0.25 + xi @ SLOPES
    variations = _variations(frame, shares, gap, from_anchor)
    t, by_t, slip = _friction(frame, from_anchor, p, stiffness, friction, tangential, variations)
    force = t - p[:, None] * frame.normal
    by_force = by_t + _outer(frame.normal, stiffness[:, None] * variations.gap) - p[:, None, None] * variations.normal
    foot = arm - gap[:, None] * frame.normal
    matrix = _matrix(arm, foot, force, by_force, shares, frame, gap, variations)
    eps_t, size = tangential * stiffness, np.linalg.norm(t, axis=1)
    path = np.einsum("ma,mai->mi", xi - samples.origin[active], frame.edges)
    s = np.divide(t, size[:, None], out=np.zeros_like(t), where=size[:, None] > 0)
    dissipated = np.where(slip, size * (np.einsum("mi,mi->m", s, path) - size / eps_t), 0.0)
    energy = 0.5 * (p**2 - samples.pressure[active] ** 2) / stiffness + 0.5 * size**2 / eps_t
    return SampleContact(active, gap, frame.normal, -force, foot, slip, centre + foot - t / eps_t[:, None], p,
                         samples.triangle[active], samples.weights[active], shares, matrix, float(total(energy)),
                         float(total(dissipated)))


@dataclass(frozen=True)
class _Variations:
    """Derivatives with respect to (x_s, x_a): u (m, 3, 15), gap g (m, 15), normal n (m, 3, 15), xi ξ^α (m, 2, 15),
    tau τ (m, 3, 15)."""

    u: np.ndarray
    gap: np.ndarray
    normal: np.ndarray
    xi: np.ndarray
    tau: np.ndarray


def _variations(frame, shares, gap, from_anchor):
    """_Variations of the module's head; from_anchor: (m, 2) ξ - ξ_0."""
    eye = np.eye(3)
    u = np.concatenate([np.broadcast_to(eye, (len(gap), 3, 3)),
                        *(-shares[:, a, None, None] * eye for a in range(4))], axis=2)
    edges = np.concatenate([np.zeros((2, 3, 3)), *(SLOPES[:, a, None, None] * eye for a in range(4))], axis=2)
    h = np.einsum("mi,bij->mbj", frame.normal, edges)
    metric = np.einsum("mai,mbi->mab", frame.dual, frame.dual)
    xi = np.einsum("mai,mij->maj", frame.dual, u) + gap[:, None, None] * (metric @ h)
    tau = np.einsum("mai,maj->mij", frame.edges, xi) + np.einsum("ma,aij->mij", from_anchor, edges)
    return _Variations(u, np.einsum("mi,mij->mj", frame.normal, u), -np.einsum("mai,maj->mij", frame.dual, h), xi, tau)


def _friction(frame, from_anchor, p, stiffness, friction, tangential, variations):
    """Tangential part t (m, 3) of F, its derivative (m, 3, 15), and slip (m,) bool."""
    m = len(p)
    if friction == 0.0:
        return np.zeros((m, 3)), np.zeros((m, 3, 15)), np.zeros(m, bool)
    tau, eps_t, limit = np.einsum("ma,mai->mi", from_anchor, frame.edges), tangential * stiffness, friction * p
    size = np.linalg.norm(tau, axis=1)
    slip = eps_t * size > limit
    s = np.divide(tau, size[:, None], out=np.zeros_like(tau), where=size[:, None] > 0)
    across = variations.tau - _outer(s, np.einsum("mi,mij->mj", s, variations.tau))
    ratio = np.divide(limit, size, out=np.zeros(m), where=size > 0)
    by_slip = ratio[:, None, None] * across - _outer(s, (friction * stiffness)[:, None] * variations.gap)
    t = np.where(slip[:, None], limit[:, None] * s, eps_t[:, None] * tau)
    return t, np.where(slip[:, None, None], by_slip, eps_t[:, None, None] * variations.tau), slip


def _matrix(arm, foot, force, by_force, shares, frame, gap, variations):
    """(m, 18, 18): rows force, moment, corners; columns δc, δφ, δx_a."""
    by_foot = -_outer(frame.normal, variations.gap) - gap[:, None, None] * variations.normal
    by_foot[:, :, :3] += np.eye(3)
    F = skew(force)
    rows = [by_force, skew(foot) @ by_force - F @ by_foot]
    for a in range(4):
        slope = np.einsum("b,mbj->mj", SLOPES[:, a], variations.xi)
        rows.append(-shares[:, a, None, None] * by_force - _outer(force, slope))
    by_positions = np.concatenate(rows, axis=1)
    by_rotation = -by_positions[:, :, :3] @ skew(arm)
    matrix = np.concatenate([by_positions[:, :, :3], by_rotation, by_positions[:, :, 3:]], axis=2)
    matrix[:, 3:6, :3] += F  # the centre, about which moments are taken, moves too
    return matrix


def _outer(a, b):
    return a[:, :, None] * b[:, None, :]


def add_residual(contact, samples, corners, force):
    """Add the second pass to nodal residuals (N, 3) [N], None when the soil is held; returns the body's residual (6,)
    [N, N m about its centre]."""
    if force is not None and len(contact):
        on_corner = contact.shares[:, :, None] * contact.force[:, None]
        corner = samples.corner[contact.active]
        np.add.at(force, corners.node[corner], corners.weight[corner][..., None] * on_corner[:, :, None])
    return -np.concatenate([total(contact.force), total(np.cross(contact.arm, contact.force))])


def add_tangent(contact, samples, corners, pattern, shape, values, free, uw, wu):
    """Add the second pass to the soil block `values`, and to dense blocks K_uw (n, m) and K_wu (m, n) over the soil
    unknowns and the m components of the body that are `free` (6,); shape: of the grid."""
    if len(contact):
        corner = samples.corner[contact.active]
        _add_tangent(corners.node[corner].reshape(len(contact), -1), corners.weight[corner].reshape(len(contact), -1),
                     np.ascontiguousarray(contact.matrix[:, 6:, 6:]),
                     np.ascontiguousarray(contact.matrix[:, 6:, :6][:, :, free]),
                     np.ascontiguousarray(contact.matrix[:, :6, 6:][:, free]), shape,
                     pattern.sparsity, Blocks(values, uw, wu))


@njit(cache=True)
def _add_tangent(node, weight, K, Q, rows, shape, sparsity, blocks):
    """node, weight: (m, 32), eight nodes of each of four corners; K (m, 12, 12), Q (m, 12, q), rows (m, q, 12)."""
    dof, row, values, uw, wu = sparsity.dof, sparsity.row, blocks.uu, blocks.uw, blocks.wu
    nodes, place, W, M = np.empty(32, np.int64), np.empty((32, 3), np.int64), np.empty((32, 4)), np.empty((3, 12))
    for n in range(len(node)):
        count = _merge_nodes(node[n], weight[n], shape, nodes, place, W)
        for u in range(count):
            v = nodes[u]
            if row[v] < 0:
                continue
            for i in range(3):
                for j in range(12):
                    M[i, j] = (W[u, 0] * K[n, i, j] + W[u, 1] * K[n, 3 + i, j]
                               + W[u, 2] * K[n, 6 + i, j] + W[u, 3] * K[n, 9 + i, j])
                if dof[v, i] >= 0:
                    for f in range(4):
                        for q in range(len(wu)):
                            uw[dof[v, i], q] += W[u, f] * Q[n, 3 * f + i, q]
                            wu[q, dof[v, i]] += W[u, f] * rows[n, q, 3 * f + i]
            for t in range(count):
                w = nodes[t]
                di, dj, dk = place[t, 0] - place[u, 0], place[t, 1] - place[u, 1], place[t, 2] - place[u, 2]
                # corners more than a cell apart, as domains stretch, have no entries for each other
                if row[w] < 0 or not in_stencil(di, dj, dk):
                    continue
                offset = offset_in_row(sparsity, v, place_of_offset(di, dj, dk))
                for i in range(3):
                    if dof[v, i] >= 0:
                        at = row_start(sparsity, v, i) + offset
                        for k in range(3):
                            if dof[w, k] >= 0:
                                values[at] += (W[t, 0] * M[i, k] + W[t, 1] * M[i, 3 + k]
                                               + W[t, 2] * M[i, 6 + k] + W[t, 3] * M[i, 9 + k])
                                at += 1


@njit(cache=True)
def _merge_nodes(node, weight, shape, nodes, place, W):
    """Fill the distinct `nodes` among those (32,) of four corners, their `place` (i, j, k) in the grid, and their
    weights W (., 4) for each corner; returns the number of distinct nodes."""
    count = 0
    for a in range(32):
        if weight[a] == 0.0:
            continue
        u = 0
        while u < count and nodes[u] != node[a]:
            u += 1
        if u == count:
            nodes[u], W[u] = node[a], 0.0
            place[u, 0], place[u, 1], place[u, 2] = node_indices(shape, node[a])
            count += 1
        W[u, a // 8] += weight[a]
    return count
