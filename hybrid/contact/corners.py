"""Corners of the points' domains that may touch a body during a step.

A corner starts at x_p ± l. From the step in which it comes within `reach` of the body it is a material point of its
own, carried by the grid,

    x_c <- x_c + Σ_v N_v(x_c) Δu_v          N_v hat functions of its cell

until it leaves the reach. If it were placed at x_p ± l anew in each step, it would move into the body where the soil is
compressed (a domain follows the average strain of its point, the corner the larger strain next to the body) and
would add energy to the springs, as much as the plastic work under a settling anchor.

Corners that coincide at the start stay together. Under a flat face four domains meet at each site of the lattice, so
each corner has a quarter of the stiffness of a point, ε_N = p_f E V0^(2/3) / 4: one point's stiffness at each site, a
pressure of p_f E per unit of overlap. With the stiffness of a point at each site, however many corners coincide there,
edges would have twice and vertices four times the stiffness of their area: a platen then overlaps a cube by 2.5 to
9.1 mm instead of 7.3 mm everywhere (tests/analytic/test_platen.py). In standard MPM all eight corners of a point
coincide and share its stiffness.

Equations: FORMULATION (39).
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from hybrid.body.closest import NO_SIDE, closest
from hybrid.contact.first_contact import predicted_contact_points
from hybrid.runtime.comm import largest, total
from hybrid.soil.basis import find_cell, hat

SHARE = 0.25  # of a point's contact stiffness, per corner
SIGNS = np.array([[1.0 if corner & bit else -1.0 for bit in (4, 2, 1)] for corner in range(8)])


@dataclass(frozen=True)
class Corners:
    """Corners near one body, frozen during a step; m of them.

    id: (m,) increasing, 8 p + corner; bits 4, 2, 1 of the corner are set at the upper end along x, y, z
    position: (m, 3) [m] at the start of the step; start: (m, 3) the same in the body frame
    node, weight: (m, 8) grid nodes and hat functions there
    stiffness: (m,) ε_N [N/m]; touching: (m,) bool, in contact at the start of the step
    anchor: (m, 3) [m] body frame, of the tangential spring: history while touching, else the predicted first-contact
        point (contact/first_contact.py); side: (m, 3) body frame, outward normal where the corner touches or is
        predicted to touch, 0 if unknown
    pressure: (m,) [N] multiplier of the augmented Lagrangian
    clearance: (m,) [m] signed distance from the surface at the start: an open corner that moves less than this cannot
        touch, so most corners are not projected
    facet: (m,) triangle that a corner is held to, -1 for those that find theirs; None where none is held
    """

    id: np.ndarray
    position: np.ndarray
    start: np.ndarray
    node: np.ndarray
    weight: np.ndarray
    stiffness: np.ndarray
    touching: np.ndarray
    anchor: np.ndarray
    side: np.ndarray
    pressure: np.ndarray
    clearance: np.ndarray
    facet: np.ndarray | None = None

    def __len__(self):
        return len(self.id)

    def moved(self, displacement):
        """Positions (m, 3) [m] after nodal increments (N, 3) [m]."""
        if displacement is None:
            return self.position
        return self.position + np.einsum("ca,cai->ci", self.weight, displacement[self.node])


def find_corners(position, half, grid, active, body, surface, reach, stiffness, history, expected, included=True):
    """Corners within `reach` [m] of the surface of `body` (a BodyState).

    position, half: (n, 3) [m] of the domains; active: (N,) bool, nodes that carry mass; stiffness: (n,) of a whole
    point [N/m]; history: ContactHistory; expected: nodal increments (N, 3) [m] (None: held soil) and pose of the body
    from which the step starts to iterate; included: (n,) bool, points that are not deactivated.
    """
    included = np.broadcast_to(included, len(position))
    id, place, touching, anchor, side, pressure, clearance = _within_reach(
        position, half, body, surface, reach, history, included)
    node, weight = _interpolation(place, grid.axes, active)
    use = np.flatnonzero(weight.any(axis=1))
    use = use[np.argsort(id[use], kind="stable")]
    id, place, node, weight, touching, anchor, side, pressure, clearance = (
        a[use] for a in (id, place, node, weight, touching, anchor, side, pressure, clearance))
    stiffness = shared_stiffness(id, place, stiffness if half.any() else stiffness / 2)
    start = (place - body.position) @ body.rotation
    corners = Corners(id, place, start, node, weight, stiffness, touching, anchor, side, pressure, clearance)
    is_open = ~touching
    anchor[is_open], side[is_open] = predicted_contact_points(
        place[is_open], corners.moved(expected[0])[is_open], body, expected[1], surface, clearance[is_open])
    return corners


def _within_reach(position, half, body, surface, reach, history, included):
    """Number, position, history (touching, anchor, side, pressure) and distance from the surface of the corners within
    reach: those of the history, carried by the grid, and new ones."""
    distance = distances((history.position - body.position) @ body.rotation, surface, reach)
    followed = np.isfinite(distance) & included[history.id // 8]
    new, new_place, new_distance = _new_corners(position, half, included, body, surface, reach, history.id)
    return (np.concatenate([history.id[followed], new]), np.concatenate([history.position[followed], new_place]),
            *(np.concatenate([old[followed], np.zeros((len(new), *old.shape[1:]), old.dtype)])
              for old in (history.touching, history.anchor, history.side, history.pressure)),
            np.concatenate([distance[followed], new_distance]))


def distances(places, surface, reach=np.inf):
    """Signed distances (m,) [m] of places (m, 3) in the body frame from the surface, inf beyond `reach` [m]; outside
    lower bounds of what a corner has to move to touch it."""
    out = np.empty(len(places))
    _distances(places, reach, surface.tree, out)
    return np.where(out > 0.0, out / surface.tree.patches.steepness, out)


def shared_stiffness(id, place, stiffness):
    """ε_N (m,) [N/m] of corners `id` at `place` (m, 3), of `stiffness` (n,) of whole points."""
    return SHARE * stiffness[id // 8]


def _new_corners(position, half, included, body, surface, reach, known):
    """Numbers, positions and distances from the surface of the corners within reach other than those `known` from the
    history. Distances are evaluated only for corners in the body's bounding box, extended by the reach."""
    in_box = np.zeros((len(position), 8), np.bool_)
    _mark(position, half, body.position, body.rotation, surface.lower - reach, surface.upper + reach,
          surface.radius + reach, in_box)
    in_box.reshape(-1)[known] = False       # the grid has carried them away from x_p ± l
    id = np.flatnonzero(in_box)
    id = id[included[id // 8]]
    place = position[id // 8] + SIGNS[id % 8] * half[id // 8]
    distance = distances((place - body.position) @ body.rotation, surface, reach)
    near = np.isfinite(distance)
    return id[near], place[near], distance[near]


def _interpolation(place, axes, active):
    """Nodes and hat functions (m, 8) at places (m, 3) [m].

    The weight of nodes without mass is distributed over the others in proportion, so that no force is lost; a corner
    all of whose nodes are without mass has zero weights.
    """
    node, weight = np.zeros((len(place), 8), np.int64), np.zeros((len(place), 8))
    _hats(place, *axes, node, weight)
    weight[~active[node]] = 0.0
    sums = weight.sum(axis=1, keepdims=True)
    return node, np.divide(weight, sums, out=np.zeros_like(weight), where=sums > 0)


def overlap(position, half, body, surface):
    """Largest overlap [m] of a corner with a body at its committed pose, and the number of corners inside."""
    y = ((position[:, None] + SIGNS * half[:, None]).reshape(-1, 3) - body.position) @ body.rotation
    y = y[np.all((y > surface.lower) & (y < surface.upper), axis=1)]
    distance = distances(np.ascontiguousarray(y), surface)
    return largest(-distance), int(total(distance < 0.0))


@njit(cache=True)
def _mark(position, half, centre, rotation, lower, upper, radius, in_box):
    """Mark the corners (n, 8) in the box from `lower` to `upper` of the body frame. Points with no part of their domain
    in the ball of `radius` [m] about the centre, outside which no corner is within reach, are skipped first."""
    for p in range(len(position)):
        d0, d1, d2 = position[p, 0] - centre[0], position[p, 1] - centre[1], position[p, 2] - centre[2]
        a = radius + half[p, 0] + half[p, 1] + half[p, 2]
        if not d0 * d0 + d1 * d1 + d2 * d2 < a * a:
            continue
        for corner in range(8):
            x0 = d0 + (half[p, 0] if corner & 4 else -half[p, 0])
            x1 = d1 + (half[p, 1] if corner & 2 else -half[p, 1])
            x2 = d2 + (half[p, 2] if corner & 1 else -half[p, 2])
            y0 = rotation[0, 0] * x0 + rotation[1, 0] * x1 + rotation[2, 0] * x2
            y1 = rotation[0, 1] * x0 + rotation[1, 1] * x1 + rotation[2, 1] * x2
            y2 = rotation[0, 2] * x0 + rotation[1, 2] * x1 + rotation[2, 2] * x2
            in_box[p, corner] = (lower[0] <= y0 <= upper[0] and lower[1] <= y1 <= upper[1]
                                 and lower[2] <= y2 <= upper[2])


@njit(cache=True)
def _distances(y, reach, tree, out):
    for n in range(len(y)):
        out[n] = closest((y[n, 0], y[n, 1], y[n, 2]), reach, tree, NO_SIDE)[4]


@njit(cache=True)
def _hats(place, x_axis, y_axis, z_axis, node, weight):
    first, second = np.empty(3, np.int64), np.empty(3)
    for n in range(len(place)):
        for axis in range(3):
            nodes = x_axis if axis == 0 else (y_axis if axis == 1 else z_axis)
            first[axis], second[axis] = 0, 0.0
            if len(nodes) > 1:
                first[axis] = find_cell(place[n, axis], nodes)
                second[axis] = min(hat(place[n, axis], first[axis] + 1, nodes), 1.0)
        for a in range(8):
            w, v = 1.0, 0
            for axis in range(3):
                upper = (a >> (2 - axis)) & 1
                w *= second[axis] if upper else 1.0 - second[axis]
                size = len(x_axis) if axis == 0 else (len(y_axis) if axis == 1 else len(z_axis))
                v = v * size + min(first[axis] + upper, size - 1)
            node[n, a], weight[n, a] = v, w
