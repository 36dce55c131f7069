"""Penalty contact with Coulomb friction at corners, in the body frame.

    y = R^T (x_c - c)      d = y - foot = g N      A = ∂d/∂y      p = λ - ε_N g > 0
    z = y - y_anchor       g_t = P z,  P = I - N N^T
    stick  |ε_T g_t| <= μ p :  f = -p N + ε_T g_t
    slip   otherwise        :  f = -p N + μ p s,  s = g_t/|g_t|

(formulation section 6; the seed paper's eqs 3-6). f is the residual of the penalty, minus the force on the corner.
Because the normal turns with y at an edge or a vertex, ∂N/∂y = G = (A - N N^T)/g there, and

    M = ∂g_t/∂y = P - (N·z) G - N (G z)^T
    normal ∂f/∂y = ε_N A - λ G
    stick  + ε_T M                        slip  + μp/|g_t| (I - s s^T) M - μ ε_N s N^T

λ is zero under plain penalty; the augmented Lagrangian raises it between solutions (contact/contact_pair.py), and the tangent
stays that of the penalty. On a face G = 0. The anchor is history in the body frame: objective, and indifferent to
hopping between triangles. A contact born in the step takes its anchor where the corner meets the surface
(contact/first_contact.py). Without friction (μ = 0) neither anchor nor tangential law is evaluated.

The force of a step acts from the step's start, also on a corner that touches only later. Friction work of a corner
that slips is therefore counted along its way since the start.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numba import njit

from hybrid.body.closest import clear, closest, gap_geometry
from hybrid.runtime.comm import total
from hybrid.state import ContactHistory


@dataclass(frozen=True)
class CornerContact:
    """Corners in contact at a trial state; m of them, in space unless said otherwise.

    active: (m,) which of the corners; gap: (m,) [m] negative; normal: (m, 3) outward
    force: (m, 3) [N], minus the force on the corner
    tangent: (m, 3, 3) [N/m] at fixed attitude; arm: (m, 3) [m] from the body's centre; slip: (m,) bool
    anchor: (m, 3) [m] what the history becomes on commit, body frame; triangle: (m,), weights: (m, 3) of its vertices
    side: (m, 3) outward normal, body frame; pressure: (m,) p [N]
    energy: stored in the springs [J]; dissipated: friction work of the step [J]
    """

    active: np.ndarray
    gap: np.ndarray
    normal: np.ndarray
    force: np.ndarray
    tangent: np.ndarray
    arm: np.ndarray
    slip: np.ndarray
    anchor: np.ndarray
    side: np.ndarray
    pressure: np.ndarray
    triangle: np.ndarray
    weights: np.ndarray
    energy: float
    dissipated: float

    def __len__(self):
        return len(self.active)


def evaluate(corners, place, centre, rotation, surface, friction, tangential):
    """Touch of corners at `place` (m, 3) [m] with a body at `centre` (3,), `rotation` (3, 3).

    friction: μ; tangential: ε_T/ε_N.
    """
    tree = surface.tree
    y = (place - centre) @ rotation
    gap, triangle, feature = np.empty(len(y)), np.empty(len(y), np.int64), np.empty(len(y), np.int64)
    foot, weights = np.empty_like(y), np.empty_like(y)
    _project(y, corners.start, corners.clearance, corners.side, corners.pressure, surface.radius, tree, gap, triangle,
             feature, foot, weights)
    active = np.flatnonzero(np.isfinite(gap))
    active = active[corners.pressure[active] - corners.stiffness[active] * gap[active] > 0.0]
    m = len(active)
    force, tangent, anchor, side = np.empty((m, 3)), np.empty((m, 3, 3)), np.empty((m, 3)), np.empty((m, 3))
    slip, energy, dissipated = np.zeros(m, np.bool_), np.zeros(m), np.zeros(m)
    origin = np.where(corners.touching[active, None], corners.anchor[active], corners.start[active])
    _law(y[active], gap[active], triangle[active], feature[active], foot[active], corners.anchor[active], origin,
         corners.stiffness[active], corners.pressure[active], friction, tangential, tree, force, tangent, slip, anchor,
         side, energy, dissipated)
    return CornerContact(
        active, gap[active], side @ rotation.T, force @ rotation.T, rotation @ tangent @ rotation.T,
        place[active] - centre, slip, anchor, side,
        corners.pressure[active] - corners.stiffness[active] * gap[active],
        triangle[active], weights[active], float(total(energy)), float(total(dissipated)))


def gaps(y, surface, side=None):
    """Signed gaps (m,) [m] of places (m, 3) in the body frame, inf clear of the body; side: (m, 3), as in Corners."""
    gap, index = np.empty(len(y)), np.empty((2, len(y)), np.int64)
    side = np.zeros_like(y) if side is None else side
    none = np.zeros(len(y))
    _project(y, y, none, side, none, surface.radius, surface.tree, gap, index[0], index[1], np.empty_like(y),
             np.empty_like(y))
    return gap


def commit(corners, place, touch):
    """ContactHistory after acceptance: every followed corner at its place (m, 3) [m]."""
    touching = np.zeros(len(corners), bool)
    anchor, side = np.zeros((len(corners), 3)), np.zeros((len(corners), 3))
    touching[touch.active] = True
    anchor[touch.active], side[touch.active] = touch.anchor, touch.side
    none = ContactHistory.empty()
    return replace(none, id=corners.id, position=place, touching=touching, anchor=anchor, side=side,
                   pressure=np.where(touching, corners.pressure, 0.0))


@njit(cache=True)
def _project(y, start, clearance, side, pressure, radius, tree, gap, triangle, feature, foot, weights):
    """A corner with a side to stay with, or pressed across a gap by its multiplier, is looked at wherever it is."""
    for n in range(len(y)):
        s = side[n, 0], side[n, 1], side[n, 2]
        loose = pressure[n] == 0.0 and s[0] == 0.0 and s[1] == 0.0 and s[2] == 0.0
        x0, x1, x2 = y[n, 0] - start[n, 0], y[n, 1] - start[n, 1], y[n, 2] - start[n, 2]
        short = x0 * x0 + x1 * x1 + x2 * x2 < max(clearance[n], 0.0) ** 2
        if loose and (short or clear(y[n, 0], y[n, 1], y[n, 2], radius, tree)):
            gap[n] = np.inf
            continue
        t, f, x, w, g = closest((y[n, 0], y[n, 1], y[n, 2]), np.inf, tree, s)
        triangle[n], feature[n], gap[n] = t, f, g
        for i in range(3):
            foot[n, i], weights[n, i] = x[i], w[i]


@njit(cache=True)
def _law(y, gap, triangle, feature, foot, old, origin, stiffness, multiplier, friction, ratio, tree, force, tangent,
         slip, anchor, side, energy, dissipated):
    """old: (m, 3) anchors before; origin: (m, 3) where the way starts along which friction works."""
    G, work = np.empty((3, 3)), (np.empty(3), np.empty(3), np.empty((3, 3)))
    for n in range(len(y)):
        g, eps_n = gap[n], stiffness[n]
        p = multiplier[n] - eps_n * g
        N, A = gap_geometry(y[n], foot[n], triangle[n], feature[n], tree)
        for i in range(3):
            side[n, i], anchor[n, i], force[n, i] = N[i], old[n, i], -p * N[i]
            for j in range(3):
                G[i, j] = (A[i][j] - N[i] * N[j]) / g if g != 0.0 else 0.0
                tangent[n, i, j] = eps_n * N[i] * N[j] - p * G[i, j]
        energy[n] = 0.5 * (p * p - multiplier[n] ** 2) / eps_n
        if friction > 0.0:
            _add_friction(n, N, G, y, old, origin, p, eps_n, friction, ratio * eps_n, force, tangent, slip, anchor,
                          energy, dissipated, work)


@njit(cache=True)
def _add_friction(n, N, G, y, old, origin, p, eps_n, friction, eps_t, force, tangent, slip, anchor, energy, dissipated,
                  work):
    """What friction adds at one corner; work: room for g_t, which becomes s, for G z, and for M."""
    s, Gz, M = work
    z0, z1, z2 = y[n, 0] - old[n, 0], y[n, 1] - old[n, 1], y[n, 2] - old[n, 2]
    along = N[0] * z0 + N[1] * z1 + N[2] * z2
    s[0], s[1], s[2] = z0 - along * N[0], z1 - along * N[1], z2 - along * N[2]
    for i in range(3):
        Gz[i] = G[i, 0] * z0 + G[i, 1] * z1 + G[i, 2] * z2
        for j in range(3):
            M[i, j] = (1.0 if i == j else 0.0) - N[i] * N[j] - along * G[i, j]
    for i in range(3):
        for j in range(3):
            M[i, j] -= N[i] * Gz[j]
    limit, size = friction * p, math.sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2])
    slip[n] = not eps_t * size <= limit
    if not slip[n]:
        energy[n] += 0.5 * eps_t * size * size
        for i in range(3):
            force[n, i] += eps_t * s[i]
            for j in range(3):
                tangent[n, i, j] += eps_t * M[i, j]
        return
    energy[n] += 0.5 * limit * limit / eps_t
    way = -limit / eps_t
    for i in range(3):
        s[i] /= size
        way += s[i] * (y[n, i] - origin[n, i])
    dissipated[n] = limit * way
    for i in range(3):
        force[n, i] += limit * s[i]
        anchor[n, i] = y[n, i] - s[i] * (limit / eps_t)
        for j in range(3):
            sM = s[0] * M[0, j] + s[1] * M[1, j] + s[2] * M[2, j]
            tangent[n, i, j] += limit / size * (M[i, j] - s[i] * sM) - friction * eps_n * s[i] * N[j]
