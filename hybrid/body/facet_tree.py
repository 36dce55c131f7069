"""Facets of a contact surface in a tree of bounding boxes, and the facet nearest to a place.

Symbols, features and sources as in `hybrid.body.surface`, which builds the Tree.
"""

import math
from typing import NamedTuple

import numpy as np

from hybrid.body.patches import Patches, dot
from hybrid.runtime.jit import njit

NO_SIDE = (0.0, 0.0, 0.0)
OPPOSITE = -0.5  # cosine: a triangle more than 120 degrees from the side in contact belongs to the opposite side
SAME = 0.5       # cosine: a triangle less than 60 degrees from the side in contact belongs to it
ALL = -2.0       # cosine: no triangle is excluded
SECOND = 8       # offset of the second values of the features in Tree.normals and Tree.kind
# Loops over places are parallel over LANES, place n in lane n modulo LANES: those near the body, which take longest, are
# neighbours in the list, and have to be shared out. Threads take lanes next to each other, so they write to memory apart.
LANES = 64


class Tree(NamedTuple):
    """Triangles in a complete binary tree of bounding boxes: node i has children 2i and 2i + 1, the root is 1.

    boxes (2 leaves, 6)             lower and upper corners of each node [m]
    first (leaves + 1,)             where the slots of each leaf start; a slot holds one triangle
    order (t,)                      triangle in a slot
    facets (t, 12)                  v0, v1 - v0, v2 - v0 [m] and unit normal, by slot
    normals (t, 16, 3)              n̂ of the eight features, then e of each
    kind (t, 16)                    0 where a feature counts as face; then 1 where a closest point on the feature of the
                                    facet has to be projected onto patches
    patches                         curved patches over the triangles
    """

    boxes: np.ndarray
    first: np.ndarray
    order: np.ndarray
    facets: np.ndarray
    normals: np.ndarray
    kind: np.ndarray
    patches: Patches

    @property
    def parts(self):
        """(arrays, patches), for kernels with parallel loops, which take no tuples of tuples; see `tree_of_parts`."""
        return self[:-1], self.patches


@njit(cache=True)
def tree_of_parts(arrays, patches):
    """Tree from its `parts`."""
    boxes, first, order, facets, normals, kind = arrays
    return Tree(boxes, first, order, facets, normals, kind, patches)


@njit(cache=True)
def _outside(x, lower, upper):
    """Distance of x from an interval, 0 inside."""
    return lower - x if x < lower else (x - upper if x > upper else 0.0)


@njit(cache=True)
def box_distance(y0, y1, y2, boxes, node):
    """Squared distance of a point from a box, 0 inside."""
    x0 = _outside(y0, boxes[node, 0], boxes[node, 3])
    x1 = _outside(y1, boxes[node, 1], boxes[node, 4])
    x2 = _outside(y2, boxes[node, 2], boxes[node, 5])
    return x0 * x0 + x1 * x1 + x2 * x2


@njit(cache=True)
def _region(d1, d2, a, b, c):
    """Feature of a triangle closest to a point, and the weights of its vertices v1 and v2 there.

    d1, d2: products of (y - v0) with the edges v1 - v0 and v2 - v0; a, b, c: products of those edges with
    themselves and each other. Their signs determine which of the seven regions around the triangle y projects to.
    """
    d3, d4, d5, d6 = d1 - a, d2 - b, d1 - b, d2 - c      # the same products with v1 and v2 in place of v0
    if d1 <= 0.0 and d2 <= 0.0:
        return 4, 0.0, 0.0
    if d3 >= 0.0 and d4 <= d3:
        return 5, 1.0, 0.0
    w = a * d2 - b * d1
    if w <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        return 1, d1 / a, 0.0
    if d6 >= 0.0 and d5 <= d6:
        return 6, 0.0, 1.0
    v = c * d1 - b * d2
    if v <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        return 3, 0.0, d2 / c
    total = a * c - b * b
    if v + w >= total and d4 >= d3 and d5 >= d6:
        along = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        return 2, 1.0 - along, along
    return 0, v / total, w / total


@njit(cache=True)
def to_triangle(y0, y1, y2, facets, k, best):
    """Squared distance to the triangle in slot k, closest feature and weights; if its plane is already farther than
    `best` (squared), the distance to the plane."""
    x0, x1, x2 = y0 - facets[k, 0], y1 - facets[k, 1], y2 - facets[k, 2]
    height = x0 * facets[k, 9] + x1 * facets[k, 10] + x2 * facets[k, 11]
    if height * height > best:
        return height * height, 0, 0.0, 0.0
    p0, p1, p2 = facets[k, 3], facets[k, 4], facets[k, 5]
    q0, q1, q2 = facets[k, 6], facets[k, 7], facets[k, 8]
    feature, v, w = _region(
        x0 * p0 + x1 * p1 + x2 * p2, x0 * q0 + x1 * q1 + x2 * q2,
        p0 * p0 + p1 * p1 + p2 * p2, p0 * q0 + p1 * q1 + p2 * q2, q0 * q0 + q1 * q1 + q2 * q2)
    if feature == 0:
        return height * height, feature, v, w
    x0, x1, x2 = x0 - v * p0 - w * q0, x1 - v * p1 - w * q1, x2 - v * p2 - w * q2
    return x0 * x0 + x1 * x1 + x2 * x2, feature, v, w


@njit(cache=True)
def search(y0, y1, y2, reach, tree, side=NO_SIDE, limit=OPPOSITE):
    """Slot of the triangle nearest to (y0, y1, y2), if nearer than reach, else -1; its closest feature; the
    weights of v1 and v2 there; and the number of triangles visited. Triangles whose normal has a product below
    `limit` with `side` are excluded.

    Depth first, nearer child first. In a complete tree the number of a node gives its sibling and its parent, so the
    stack of farther siblings still to visit is one bit per level of the integer `waiting`: nothing is allocated.
    """
    boxes, first, order, facets = tree.boxes, tree.first, tree.order, tree.facets
    leaves = len(first) - 1
    best, slot, feature, v, w, visited = reach * reach, -1, 0, 0.0, 0.0, 0
    if not box_distance(y0, y1, y2, boxes, 1) <= best:
        return slot, feature, v, w, visited
    node, waiting = 1, 0
    while True:
        if node < leaves:
            node *= 2
            nearer = box_distance(y0, y1, y2, boxes, node)
            farther = box_distance(y0, y1, y2, boxes, node + 1)
            if farther < nearer:
                nearer, farther, node = farther, nearer, node + 1
            waiting = 2 * waiting + (1 if farther <= best else 0)
            if nearer <= best:
                continue
        else:
            for k in range(first[node - leaves], first[node - leaves + 1]):
                visited += 1
                if facets[k, 9] * side[0] + facets[k, 10] * side[1] + facets[k, 11] * side[2] < limit:
                    continue
                distance, found, fv, fw = to_triangle(y0, y1, y2, facets, k, best)
                # of equidistant triangles the one with the lowest number; no triangle (slot -1) never ties
                if distance < best or (distance == best and slot >= 0 and order[k] < order[slot]):
                    best, slot, feature, v, w = distance, k, found, fv, fw
        while True:
            if waiting == 0:
                return slot, feature, v, w, visited
            while waiting & 1 == 0:
                waiting >>= 1
                node >>= 1
            waiting ^= 1
            node ^= 1
            if box_distance(y0, y1, y2, boxes, node) <= best:
                break


@njit(cache=True)
def outside_bounds(y0, y1, y2, radius, tree):
    """Whether a point is outside the ball of `radius` [m] about the centre or the bounding box of the surface.

    Its gap is then positive and no search is needed. With the slack, points on the plane of a cut count as inside, and
    patches that stand out of the box of the facets.
    """
    slack = 1e-6 * radius + tree.patches.bulge
    if y0 * y0 + y1 * y1 + y2 * y2 > (radius + slack) ** 2:
        return True
    return box_distance(y0, y1, y2, tree.boxes, 1) > slack * slack


@njit(cache=True)
def signed_distance(x, triangle, feature, tree):
    """Length [m] of x, the way from an edge or vertex of a triangle to the point, negative inside."""
    n, gap = tree.normals, math.sqrt(dot(x, x))
    side = x[0] * n[triangle, feature, 0] + x[1] * n[triangle, feature, 1] + x[2] * n[triangle, feature, 2]
    return -gap if side < 0.0 else gap
