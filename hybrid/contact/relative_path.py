"""Predicted first contact of places of one body with another one, along the path of the first relative to the second.

    y(s) = R_b(s)ᵀ [ R_a(s) X + c_a(s) - c_b(s) ]       0 <= s <= 1

with centres that move on straight lines and attitudes that turn about one axis each. The anchor of the tangential spring of
a place that closes is the place where it is predicted to touch first: see `hybrid.contact.first_contact`, the same for
points of soil, and FORMULATION (43), (62).
"""

from typing import NamedTuple

import numpy as np

from hybrid.body.attitude import log_so3, turned
from hybrid.body.closest import closest_facing
from hybrid.body.facet_tree import outside_bounds
from hybrid.contact.first_contact import UNFORESEEN
from hybrid.runtime.jit import njit

FACING = 0.1    # cosine between a place's normal and that of the other body, reversed, above which it presses
HALVINGS = 14   # bisections of the path to the first contact


class Path(NamedTuple):
    """Motion from pose to pose of body a, relative to body b: way (3,) [m] between their centres and its change; attitudes
    (3, 3) at the start, axes (3,) and angles [rad] of their rotations."""

    way: np.ndarray
    change: np.ndarray
    turn_a: np.ndarray
    axis_a: np.ndarray
    angle_a: float
    turn_b: np.ndarray
    axis_b: np.ndarray
    angle_b: float


def relative_path(start_a, start_b, end_a, end_b, collapsed):
    """Path from poses of both bodies to others; collapsed: (3,) bool, axes along which centres count as at one place."""
    turns = []
    for start, end in ((start_a, end_a), (start_b, end_b)):
        turn = log_so3(end[1] @ start[1].T)
        angle = float(np.linalg.norm(turn))
        turns.append((np.ascontiguousarray(start[1]), turn / angle if angle > 0.0 else turn, angle))
    way = np.where(collapsed, 0.0, start_a[0] - start_b[0])
    return Path(way, np.where(collapsed, 0.0, end_a[0] - end_b[0]) - way, *turns[0], *turns[1])


@njit(cache=True)
def predict(point, normal, beyond, depth, touching, path, radius, tree, anchor, rest, overlap):
    """Replace the `anchor` (m, 3) of places that do not touch by the place where they are predicted to touch first, or to
    be UNFORESEEN; and lower the `rest` (m,) of those that are deep in the body when they do, because they looked away until
    then, or came in by a side at which they do not look: to that of the deepest of those that touch. Fill `overlap` (m,) as
    in SideStep. Returns whether any is predicted to touch."""
    deepest, closes = 0.0, False
    for n in range(len(point)):
        if touching[n]:
            overlap[n] = max(rest[n] - _gap(path, point, normal, beyond, n, 0.0, tree), 0.0)
            deepest = max(deepest, overlap[n] if depth[n] == 0.0 else 0.0)
    for n in range(len(point)):
        if touching[n]:
            continue
        overlap[n] = deepest if depth[n] == 0.0 else 0.0
        y = _at(path, point, n, 1.0)
        outside = outside_bounds(y[0], y[1], y[2], radius, tree)
        if not outside and _gap(path, point, normal, beyond, n, 1.0, tree) < -depth[n]:
            before, after = 0.0, 1.0
            for _ in range(HALVINGS):
                middle = 0.5 * (before + after)
                if _gap(path, point, normal, beyond, n, middle, tree) < -depth[n]:
                    after = middle
                else:
                    before = middle
            closes = True
            y, gap = _at(path, point, n, after), _gap(path, point, normal, beyond, n, after, tree)
            if gap < -depth[n] - 2.0 * _length(path, point, n) / 2**HALVINGS:     # by more than what bisection leaves
                rest[n] = min(rest[n], gap + overlap[n])
        else:
            y = _at(path, point, n, UNFORESEEN)
        for i in range(3):
            anchor[n, i] = y[i]
    return closes


@njit(cache=True)
def _length(path, point, n):
    """[m] between place n at the start and at the end of the path."""
    a, b = _at(path, point, n, 0.0), _at(path, point, n, 1.0)
    return np.sqrt((b[0] - a[0])**2 + (b[1] - a[1])**2 + (b[2] - a[2])**2)


@njit(cache=True)
def _gap(path, point, normal, beyond, n, fraction, tree):
    outward = _carried(path, normal, n, fraction, 0.0)
    return closest_facing(_at(path, point, n, fraction), outward, FACING, beyond[n], tree)[4]


@njit(cache=True)
def _at(path, point, n, fraction):
    """Place n in the frame of body b at a fraction of the path."""
    return _carried(path, point, n, fraction, 1.0)


@njit(cache=True)
def _carried(path, vector, n, fraction, moved):
    """Vector n of body a in the frame of body b, with `moved` times the way between their centres."""
    R = path.turn_a
    x = (R[0, 0] * vector[n, 0] + R[0, 1] * vector[n, 1] + R[0, 2] * vector[n, 2],
         R[1, 0] * vector[n, 0] + R[1, 1] * vector[n, 1] + R[1, 2] * vector[n, 2],
         R[2, 0] * vector[n, 0] + R[2, 1] * vector[n, 1] + R[2, 2] * vector[n, 2])
    x = turned(x, path.axis_a, fraction * path.angle_a)
    x = (x[0] + moved * (path.way[0] + fraction * path.change[0]), x[1] + moved * (path.way[1] + fraction * path.change[1]),
         x[2] + moved * (path.way[2] + fraction * path.change[2]))
    x = turned(x, path.axis_b, -fraction * path.angle_b)
    R = path.turn_b
    return (R[0, 0] * x[0] + R[1, 0] * x[1] + R[2, 0] * x[2], R[0, 1] * x[0] + R[1, 1] * x[1] + R[2, 1] * x[2],
            R[0, 2] * x[0] + R[1, 2] * x[1] + R[2, 2] * x[2])
