"""Contact points held to a facet while a step is solved: the remedy where Newton's method jumps between two of them.

Inside a body the nearest facet changes on the surface that bisects the angle between two facets. The gap is continuous
there and its normal is not, so the force of a contact point jumps. A solution with friction may lie just beyond the
jump, seen from either side: each of the facets sends the point to the other one, however short the step is. On the
planes of given facets the residual is continuous, and the solution exists:

    g = N · (y - v0)        N, v0: normal and a vertex of the facet that is held

Only plane facets are held: the normal of a curved patch is continuous.

It is accepted where the facet held is the nearest one but for a small share of the overlap
(`hybrid.step.newton.AMBIGUOUS`): at a bisector either facet is as near. Otherwise the points are held to the facets
that are nearest then, and in short increments they stay with those that were held (`BETWEEN`). After the step every
point finds its facet again.
"""

import numpy as np

from hybrid.contact.closest_points import gaps_within_bounds
from hybrid.runtime.comm import anywhere, largest

ON_FACE = 1e-9  # 1 - cosine between the normal of a contact point and that of its triangle, up to which it is on the face
TURNED = 0.01   # between the normals of two facets, from which a change from one to the other is a jump of the force


def facets(points, contact, surface):
    """Facets (m,) to hold contact points to: those that carry them in a PointContact, -1 for points that are open, pull, or
    lie on an edge, a vertex or a curved patch."""
    facet = np.full(len(points), -1)
    plane = ~surface.curved[contact.triangle] & (contact.pressure > 0.0)
    on_face = plane & (np.einsum("ci,ci->c", contact.side, surface.normals[contact.triangle]) > 1 - ON_FACE)
    facet[contact.active[on_face]] = contact.triangle[on_face]
    return facet


def hold(closest, y, facet, surface):
    """Put the ClosestPoints of contact points at y (m, 3) [m] in the body frame on the planes of the facets (m,) to which
    they are held."""
    held = np.flatnonzero(facet >= 0)
    normal = surface.tree.normals[facet[held], 0]
    gap = np.einsum("ci,ci->c", y[held] - surface.vertices[surface.triangles[facet[held], 0]], normal)
    closest.gap[held], closest.triangle[held], closest.feature[held] = gap, facet[held], 0
    closest.closest_point[held] = y[held] - gap[:, None] * normal


def facet_error(points, contact, position, centre, rotation, surface):
    """Largest difference of the gap to a held facet from that to the surface, relative to the overlap that gives the
    pressure [-]. position: (m, 3) [m] of the points; centre, rotation: pose of the body."""
    held = (points.facet[contact.active] >= 0) & (contact.pressure > 0.0)
    index = contact.active[held]
    y = np.ascontiguousarray((position[index] - centre) @ rotation)
    difference = np.abs(gaps_within_bounds(y, surface, points.side[index]) - contact.gap[held])
    return largest(difference * points.stiffness[index] / contact.pressure[held])


def switched(before, after, surface):
    """Whether points that touch in both of two PointContacts of a step are carried by facets that face elsewhere, at least
    one of them plane: they could be held to it."""
    _, i, j = np.intersect1d(before.active, after.active, assume_unique=True, return_indices=True)
    turned = np.linalg.norm(before.side[i] - after.side[j], axis=1) > TURNED
    old, new = before.triangle[i], after.triangle[j]
    return anywhere(turned & (old != new) & ~(surface.curved[old] & surface.curved[new]))
