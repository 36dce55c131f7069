"""Closest points of a body's surface to contact points, in the body frame; those that cannot touch are left out."""

from typing import NamedTuple

import numpy as np

from hybrid.body.closest import closest
from hybrid.body.facet_tree import LANES, outside_bounds, tree_of_parts
from hybrid.runtime.jit import njit, prange

CLOSED = 1e-12      # gap over the body's radius up to which a point is in contact: one that just touches has its stiffness


class PointStart(NamedTuple):
    """Contact points at the start of the step, which decides whether they have to be projected: y (m, 3) [m] body frame, and
    clearance (m,) [m], side (m, 3) as in ContactPoints."""

    y: np.ndarray
    clearance: np.ndarray
    side: np.ndarray


class ClosestPoints(NamedTuple):
    """Closest points of the surface: gap (m,) [m], inf where the point cannot touch (the rest is then not set);
    triangle, feature (m,); closest_point (m, 3) [m], body frame; weights (m, 3) of the triangle's vertices."""

    gap: np.ndarray
    triangle: np.ndarray
    feature: np.ndarray
    closest_point: np.ndarray
    weights: np.ndarray

    @classmethod
    def empty(cls, m):
        return cls(np.empty(m), np.empty(m, np.int64), np.empty(m, np.int64), np.empty((m, 3)), np.empty((m, 3)))

    def select(self, index):
        return ClosestPoints(*(values[index] for values in self))


def closest_points(y, points, surface):
    """ClosestPoints of contact points at y (m, 3) [m] in the body frame."""
    closest = ClosestPoints.empty(len(y))
    start = PointStart(points.start, points.clearance, points.side)
    _project(y, start, surface.radius, *surface.tree.parts, closest)
    return closest


def gaps_within_bounds(y, surface, side=None):
    """Signed gaps (m,) [m] of places (m, 3) in the body frame, inf outside the body's bounds; side: (m, 3), as in
    ContactPoints."""
    zero, found = np.zeros(len(y)), ClosestPoints.empty(len(y))
    start = PointStart(y, zero, np.zeros_like(y) if side is None else side)
    _project(y, start, surface.radius, *surface.tree.parts, found)
    return found.gap


def nearest(y, side, surface):
    """Triangle (m,) of the surface nearest to places y (m, 3) [m] that touch its `side` (m, 3), and weights (m, 3) of its
    vertices there; all in the body frame."""
    closest = ClosestPoints.empty(len(y))
    _project(y, PointStart(y, np.zeros(len(y)), side), surface.radius, *surface.tree.parts, closest)
    return closest.triangle, closest.weights


def forces_on_vertices(contact, rotation, surface):
    """Force of the soil on each vertex of a `surface`, (V, 3) [N], by a contact with a body of this rotation (3, 3)."""
    triangle, weights = nearest(contact.arm @ rotation, contact.side, surface)
    forces = np.zeros((len(surface.vertices), 3))
    np.add.at(forces, surface.triangles[triangle], weights[:, :, None] * contact.force[:, None])
    return forces


@njit(cache=True, parallel=True)
def _project(y, start, radius, arrays, patches, out):
    """Fill `out` for contact points now at y (m, 3). One that remembers its side of the body is
    projected wherever it is; any other one is skipped within its clearance or outside the body's bounds."""
    y_start, clearance, sides = start       # once, because each access in the loop would count references
    gap, triangle, feature, closest_point, weights = out
    for lane in prange(LANES):
        tree = tree_of_parts(arrays, patches)
        for n in range(lane, len(y), LANES):
            side = sides[n, 0], sides[n, 1], sides[n, 2]
            without_history = side[0] == 0.0 and side[1] == 0.0 and side[2] == 0.0
            x0, x1, x2 = y[n, 0] - y_start[n, 0], y[n, 1] - y_start[n, 1], y[n, 2] - y_start[n, 2]
            within_clearance = x0 * x0 + x1 * x1 + x2 * x2 < max(clearance[n] - CLOSED * radius, 0.0) ** 2
            if without_history and (within_clearance or outside_bounds(y[n, 0], y[n, 1], y[n, 2], radius, tree)):
                gap[n] = np.inf
                continue
            t, f, x, w, g = closest((y[n, 0], y[n, 1], y[n, 2]), np.inf, tree, side)
            triangle[n], feature[n], gap[n] = t, f, g
            for i in range(3):
                closest_point[n, i], weights[n, i] = x[i], w[i]
