"""Predicted first-contact point of each open contact point: the anchor of its tangential spring if it closes in this step.

    y(s) = R(s)^T (x_c + s Δx_c - c - s Δc),   R(s) = exp(s φ~) R_n,   0 <= s <= 1
    anchor = y(s)  where the gap vanishes first, else at s = min(1/2, g/(GRAZING |y(1) - y(0)|)), g the gap at the start

along the predicted motion of the step (everything keeps its velocity, and a body that touches nothing falls). In the
frame of a rolling body the point comes down a curved path: before it touches it moves a³/(3r²) along the surface of a
sphere of radius r, a being its distance from the point of rest. At a = 50 mm and r = 0.25 m that is 0.7 mm, more than a
stiff tangential spring needs to slip: with the anchor at the place of the point at the start of the step, a rolling
sphere creeps by 1-2 %. With the anchor at the end of the step, the friction of the step in which the contact closes
would be lost. A point that is predicted to stay open may close all the same. If it slides along the surface, nearer to
it than GRAZING of its path, it may do so anywhere on the path, and its anchor is near the start; else halfway. A
block towed over elastic ground rocks on a few rows of points, of which others bear it every few steps: with their
anchors at the end of the path, friction was down to a third of μ N in such a step, 16 % too low on average. And a block
that is braked ends before the end of its predicted path: with anchors there, friction pushed it on. The
predicted motion is constant in a step, so the anchor adds nothing to the tangent. Without motion the anchor is the
place at the start.

The side of the body by which the path enters is remembered: in a thin body the opposite side may soon be nearer.

Equations: FORMULATION (43).
"""

import math
from typing import NamedTuple

import numpy as np

from hybrid.body.attitude import log_so3, turned
from hybrid.body.closest import closest
from hybrid.body.facet_tree import LANES, NO_SIDE, outside_bounds, tree_of_parts
from hybrid.runtime.jit import njit, prange

GRAZING = 0.05     # of its path: a point nearer than this that is predicted to stay off may touch on the way
UNFORESEEN = 0.5   # of the path: anchor of a point that is predicted to stay off, at most
HALVINGS = 12      # bisections of the path: 10 μm of 40 mm
ON_SURFACE = 1e-9  # of the body's radius: a contact point within this depth at the start, by round-off, counts as outside


class PredictedMotion(NamedTuple):
    """Motion of m contact points relative to a body in one step: arm (m, 3) [m] from the body's centre at the start,
    displacement (m, 3) [m] less that of the centre; the body turns by `angle` [rad] about `axis` (3,) from `rotation`
    (3, 3)."""

    arm: np.ndarray
    displacement: np.ndarray
    axis: np.ndarray
    angle: float
    rotation: np.ndarray


def predicted_contact_points(start, end, body, pose, surface, clearance):
    """First-contact points (m, 3) [m] and outward normals there (m, 3), 0 without contact, in the body frame.

    They are predicted to move from `start` to `end` (m, 3) [m] in space, and the body from `body` (a BodyState) to
    `pose` (position, rotation). clearance: (m,) [m] as in ContactPoints.
    """
    point = (start - body.position) @ body.rotation
    turn, side = log_so3(pose[1] @ body.rotation.T), np.zeros_like(point)
    angle = math.sqrt(turn @ turn)
    motion = PredictedMotion(start - body.position, end - start - (pose[0] - body.position),
                             turn / angle if angle > 0.0 else turn, angle, body.rotation)
    _find(motion, clearance, surface.radius, *surface.tree.parts, point, side)
    return point, side


@njit(cache=True, parallel=True)
def _find(motion, clearance, radius, arrays, patches, point, side):
    """point: (m, 3) places in the body frame at the start; replaced by the first-contact points."""
    for lane in prange(LANES):
        tree = tree_of_parts(arrays, patches)
        for n in range(lane, len(point), LANES):
            first, last = (point[n, 0], point[n, 1], point[n, 2]), _position(n, motion, 1.0)
            x0, x1, x2 = last[0] - first[0], last[1] - first[1], last[2] - first[2]
            within_clearance = x0 * x0 + x1 * x1 + x2 * x2 < max(clearance[n], 0.0) ** 2
            if within_clearance or outside_bounds(last[0], last[1], last[2], radius, tree) or _gap(last, tree) >= 0.0:
                point[n, 0], point[n, 1], point[n, 2] = _position(n, motion, _grazing(x0, x1, x2, clearance[n]))
            elif _gap(first, tree) >= -ON_SURFACE * radius:
                y = _entry(n, motion, tree)
                triangle, feature, _, _, _ = closest(y, np.inf, tree, NO_SIDE)
                for i in range(3):
                    point[n, i], side[n, i] = y[i], tree.normals[triangle, feature, i]


@njit(cache=True)
def _entry(n, motion, tree):
    """Place (3,) where the path of point n, open at the start and inside at the end, enters the body."""
    outside, inside = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = 0.5 * (outside + inside)
        if _gap(_position(n, motion, middle), tree) > 0.0:
            outside = middle
        else:
            inside = middle
    return _position(n, motion, inside)


@njit(cache=True)
def _grazing(x0, x1, x2, clearance):
    """Fraction of a path x along the surface after which a point that is predicted to stay `clearance` [m] off may touch."""
    length = GRAZING * math.sqrt(x0 * x0 + x1 * x1 + x2 * x2)
    return min(max(clearance, 0.0) / length, UNFORESEEN) if length > 0.0 else UNFORESEEN


@njit(cache=True)
def _gap(y, tree):
    return closest(y, np.inf, tree, NO_SIDE)[4]


@njit(cache=True)
def _position(n, motion, fraction):
    """Place (3,) of point n in the body frame at a `fraction` of the step."""
    arm, displacement, R = motion.arm, motion.displacement, motion.rotation
    x = (arm[n, 0] + fraction * displacement[n, 0], arm[n, 1] + fraction * displacement[n, 1],
         arm[n, 2] + fraction * displacement[n, 2])
    y = turned(x, motion.axis, -fraction * motion.angle)
    return (R[0, 0] * y[0] + R[1, 0] * y[1] + R[2, 0] * y[2], R[0, 1] * y[0] + R[1, 1] * y[1] + R[2, 1] * y[2],
            R[0, 2] * y[0] + R[1, 2] * y[1] + R[2, 2] * y[2])
