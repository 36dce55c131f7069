"""Corners that a step would carry through a body: the step is too long for its thickness and must not be accepted.

Only corners that were outside when the step began are asked. Seen from the body they go straight from `start` to `end`.

    pierced     outside at the end, in by one side and out by the opposite one, or deeper than `depth` on the way
    pushed on   inside at the end, where the nearest side would push them on along their way: the opposite one of that
                by which they came in, or any other one after they have been deeper than `depth`
    buried      deeper than their own domain at the end, where no sample of the body is given to their face any more;
                asked only of a second pass

Soil that flows round an edge cuts it: it comes in by one side of the edge and is pushed out by the other one, a
millimetre deep. That is no passage, and a shorter step does not do away with it.

The path is walked with steps as long as the distance to the surface, so it skips no facet, however thin the body is.
"""

import math

import numpy as np
from numba import njit

from hybrid.body.closest import NO_SIDE, OPPOSITE, closest
from hybrid.contact.soil_to_body import gaps
from hybrid.runtime.comm import total

ALONG = 0.5            # cosine between the way of a corner and the normal that pushes it on
FINEST = 0.02          # of `depth`: shortest step of the walk, and distance that counts as at the surface
FRACTIONS = 0.25, 0.5, 0.75  # of the way, where its depth is looked at


def tunnelled(corners, touch, place, centre, rotation, surface, depth, width=None):
    """Number of `corners`, at `place` (m, 3) [m] at the end and in contact as in `touch`, that passed through.

    depth: [m]; width: (m,) [m] of the domains of the corners, None without a second pass.
    """
    end = (place - centre) @ rotation
    way = end - corners.start
    far = np.einsum("ci,ci->c", way, way) >= corners.clearance**2    # the others cannot have come to the surface
    free = ~corners.touching & (corners.clearance >= 0.0) & far
    if not free.any():
        return 0
    ends = np.full(len(corners), np.inf)
    ends[free] = gaps(end[free], surface, corners.side[free])
    outward = np.einsum("ci,ci->c", way[touch.active], touch.side)
    pushed = outward > ALONG * np.linalg.norm(way[touch.active], axis=1)
    asked = free & (ends >= 0.0)
    asked[touch.active[pushed]] = free[touch.active[pushed]]
    wrong = np.zeros(len(corners), bool)
    wrong[asked] = _pierced(corners.start[asked], way[asked], FINEST * depth, surface.tree)
    for fraction in FRACTIONS:
        wrong[asked] |= gaps(corners.start[asked] + fraction * way[asked], surface) < -depth
    if width is not None:
        wrong |= ends < -width
    return int(total(free & wrong))


@njit(cache=True)
def _pierced(start, way, finest, tree):
    """(m,) bool, paths that enter on one side and leave, or end nearest to, the opposite one."""
    out = np.zeros(len(start), np.bool_)
    for n in range(len(start)):
        length, gone = math.sqrt(way[n, 0] ** 2 + way[n, 1] ** 2 + way[n, 2] ** 2), 0.0
        within, side = False, (0.0, 0.0, 0.0)
        entry = side
        while length > 0.0:
            share = gone / length
            y = start[n, 0] + share * way[n, 0], start[n, 1] + share * way[n, 1], start[n, 2] + share * way[n, 2]
            triangle, feature, _, _, gap = closest(y, np.inf, tree, NO_SIDE)
            side = (tree.normals[triangle, feature, 0], tree.normals[triangle, feature, 1],
                    tree.normals[triangle, feature, 2])
            if not within and gap < finest:
                within, entry = True, side
            elif within and gap >= finest:
                if _opposite(entry, side):
                    out[n] = True
                    break
                within = False
            if gone == length:
                break
            gone = min(gone + max(abs(gap), finest), length)
        if within and _opposite(entry, side):
            out[n] = True
    return out


@njit(cache=True)
def _opposite(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] < OPPOSITE
