"""Contact points that a step would carry through a body: the step is too long for the body's thickness and must be rejected.

Only points that were outside at the start of the step are checked. In the body frame they move straight from `start`
to `end`, and have tunnelled if they are

    pierced     outside at the end, having entered by one side and left by the opposite one, or having been deeper than
                `depth` on the path
    pushed on   inside at the end, where the nearest side pushes them on along their path: the side opposite to that of
                entry, or any other side if they have been deeper than `depth`

Soil that flows round an edge cuts it: it enters by one side of the edge and is pushed out by the other one, a
millimetre deep. That is no tunnelling, and a shorter step does not prevent it.

The path is walked in steps as long as the distance to the surface, so no facet is skipped, however thin the body is.
"""

import math

import numpy as np

from hybrid.body.closest import closest
from hybrid.body.facet_tree import LANES, NO_SIDE, OPPOSITE, tree_of_parts
from hybrid.contact.closest_points import gaps_within_bounds
from hybrid.runtime.comm import total
from hybrid.runtime.jit import njit, prange

ALONG = 0.5            # smallest cosine between the path of a point and a normal that pushes it on
FINEST = 0.02          # of `depth`: shortest step of the walk, and the distance that counts as on the surface
FRACTIONS = 0.25, 0.5, 0.75  # of the path, where its depth is checked


def count_tunnelled(points, contact, position, centre, rotation, surface, depth):
    """Number of `points` that tunnelled, at `position` (m, 3) [m] at the end of the step.

    contact: their PointContact there; centre (3,) [m], rotation (3, 3): pose of the body there; depth: [m].
    """
    end = (position - centre) @ rotation
    path = end - points.start
    beyond_clearance = np.einsum("ci,ci->c", path, path) >= points.clearance**2   # the others cannot have touched
    checked = ~points.touching & (points.clearance >= 0.0) & beyond_clearance
    if not checked.any():
        return int(total(checked))      # 0 here, but another process may have points to check
    end_gap = np.full(len(points), np.inf)
    end_gap[checked] = gaps_within_bounds(end[checked], surface, points.side[checked])
    outward = np.einsum("ci,ci->c", path[contact.active], contact.side)
    pushed_on = contact.active[outward > ALONG * np.linalg.norm(path[contact.active], axis=1)]
    walked = checked & (end_gap >= 0.0)
    walked[pushed_on] = checked[pushed_on]
    tunnelled = np.zeros(len(points), bool)
    tunnelled[walked] = pierced(points.start[walked], path[walked], FINEST * depth, surface.tree)
    for fraction in FRACTIONS:
        tunnelled[walked] |= gaps_within_bounds(points.start[walked] + fraction * path[walked], surface) < -depth
    return int(total(checked & tunnelled))


def pierced(start, path, finest, tree):
    """(m,) bool, whether a path (m, 3) from `start` (m, 3) enters by one side and leaves by the opposite one, or ends
    inside nearest to the opposite one; finest: [m] shortest step of the walk."""
    found = np.zeros(len(start), np.bool_)
    _walk(start, path, finest, *tree.parts, found)
    return found


@njit(cache=True, parallel=True)
def _walk(start, path, finest, arrays, patches, found):
    for lane in prange(LANES):
        tree = tree_of_parts(arrays, patches)
        for n in range(lane, len(start), LANES):
            found[n] = _pierces((start[n, 0], start[n, 1], start[n, 2]), (path[n, 0], path[n, 1], path[n, 2]), finest, tree)


@njit(cache=True)
def _pierces(start, path, finest, tree):
    """As `pierced`, for one path from `start`, both tuples of three."""
    length, walked = math.sqrt(path[0] ** 2 + path[1] ** 2 + path[2] ** 2), 0.0
    inside, side = False, (0.0, 0.0, 0.0)
    entry = side
    while length > 0.0:
        f = walked / length
        y = start[0] + f * path[0], start[1] + f * path[1], start[2] + f * path[2]
        triangle, feature, _, _, gap = closest(y, np.inf, tree, NO_SIDE)
        side = (tree.normals[triangle, feature, 0], tree.normals[triangle, feature, 1],
                tree.normals[triangle, feature, 2])
        if not inside and gap < finest:
            inside, entry = True, side
        elif inside and gap >= finest:
            if _opposite(entry, side):
                return True
            inside = False
        if walked == length:
            break
        walked = min(walked + max(abs(gap), finest), length)
    return inside and _opposite(entry, side)


@njit(cache=True)
def _opposite(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] < OPPOSITE
