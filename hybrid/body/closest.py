"""Kernels of the contact surface: closest point by tree traversal, and the geometry of the gap there.

Symbols, features and sources as in `hybrid.body.surface`, which builds the Tree.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

NO_SIDE = (0.0, 0.0, 0.0)
OPPOSITE = -0.5  # cosine: a triangle more than 120 degrees from the side in contact belongs to the opposite side
SAME = 0.5       # cosine: a triangle less than 60 degrees from the side in contact belongs to it
ALL = -2.0       # cosine: no triangle is excluded


class Tree(NamedTuple):
    """Triangles in a complete binary tree of bounding boxes: node i has children 2i and 2i + 1, the root is 1.

    boxes (2 leaves, 6)             lower and upper corners of each node [m]
    first (leaves + 1,)             where the slots of each leaf start; a slot holds one triangle
    order (t,)                      triangle in a slot
    facets (t, 12)                  v0, v1 - v0, v2 - v0 [m] and unit normal, by slot
    normals, directions (t, 7, 3)   n̂ and e, by triangle and feature
    kind (t, 7)                     0 where a feature counts as face, by triangle and feature
    """

    boxes: np.ndarray
    first: np.ndarray
    order: np.ndarray
    facets: np.ndarray
    normals: np.ndarray
    directions: np.ndarray
    kind: np.ndarray


@njit(cache=True)
def _outside(x, lower, upper):
    """Distance of x from an interval, 0 inside."""
    return lower - x if x < lower else (x - upper if x > upper else 0.0)


@njit(cache=True)
def _box_distance(y0, y1, y2, boxes, node):
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
def _to_triangle(y0, y1, y2, facets, k, best):
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
    if not _box_distance(y0, y1, y2, boxes, 1) <= best:
        return slot, feature, v, w, visited
    node, waiting = 1, 0
    while True:
        if node < leaves:
            node *= 2
            nearer = _box_distance(y0, y1, y2, boxes, node)
            farther = _box_distance(y0, y1, y2, boxes, node + 1)
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
                distance, found, fv, fw = _to_triangle(y0, y1, y2, facets, k, best)
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
            if _box_distance(y0, y1, y2, boxes, node) <= best:
                break


@njit(cache=True)
def outside_bounds(y0, y1, y2, radius, tree):
    """Whether a point is outside the ball of `radius` [m] about the centre or the bounding box of the surface.

    Its gap is then positive and no search is needed. With the slack, points on the plane of a cut count as inside.
    """
    slack = 1e-6 * radius
    if y0 * y0 + y1 * y1 + y2 * y2 > (radius + slack) ** 2:
        return True
    return _box_distance(y0, y1, y2, tree.boxes, 1) > slack * slack


@njit(cache=True)
def _facing(slot, feature, side, tree):
    """Cosine between the pseudo-normal of a feature and a side, 0 without a side."""
    n, triangle = tree.normals, tree.order[slot]
    return n[triangle, feature, 0] * side[0] + n[triangle, feature, 1] * side[1] + n[triangle, feature, 2] * side[2]


@njit(cache=True)
def _behind(y0, y1, y2, slot, feature, tree):
    """Whether the closest feature of the triangle in `slot` is its face and the point is on the inner side of it."""
    f = tree.facets
    height = (y0 - f[slot, 0]) * f[slot, 9] + (y1 - f[slot, 1]) * f[slot, 10] + (y2 - f[slot, 2]) * f[slot, 11]
    return height < 0.0 and tree.kind[tree.order[slot], feature] == 0


@njit(cache=True)
def closest(y, reach, tree, side=NO_SIDE):
    """Closest point of the surface to y (3,), array or tuple [m], if nearer than reach [m], which may be inf.

    side: outward normal, a tuple of three, of the side of the body that the point is in contact with; zero for all of
    the surface. A point in contact with one side of a thin body stays with that side, however deep it is pressed in:
    once the opposite side is nearer, that side and the rim between both are excluded as long as the point projects onto
    its own side from within.

    Returns (triangle, feature, foot, weights, gap): triangle number, -1 when none is nearer than reach;
    feature as in the module's head; foot [m] and barycentric weights as tuples of three; gap [m], negative
    inside.
    """
    y0, y1, y2 = y[0], y[1], y[2]
    slot, feature, v, w, _ = search(y0, y1, y2, reach, tree, side, ALL)
    if slot >= 0 and _facing(slot, feature, side, tree) < OPPOSITE:
        slot, feature, v, w, _ = search(y0, y1, y2, reach, tree, side, SAME)
        if slot < 0 or not _behind(y0, y1, y2, slot, feature, tree):
            slot, feature, v, w, _ = search(y0, y1, y2, reach, tree, side, OPPOSITE)
    if slot < 0:
        return -1, 0, (y0, y1, y2), (0.0, 0.0, 0.0), math.inf
    triangle, facets, weights = tree.order[slot], tree.facets, (max(1.0 - v - w, 0.0), v, w)
    x0, x1, x2 = y0 - facets[slot, 0], y1 - facets[slot, 1], y2 - facets[slot, 2]
    if tree.kind[triangle, feature] == 0:
        # along the normal, so that y - foot = gap N to round-off
        n0, n1, n2 = facets[slot, 9], facets[slot, 10], facets[slot, 11]
        gap = x0 * n0 + x1 * n1 + x2 * n2
        return triangle, 0, (y0 - gap * n0, y1 - gap * n1, y2 - gap * n2), weights, gap
    x0 -= v * facets[slot, 3] + w * facets[slot, 6]
    x1 -= v * facets[slot, 4] + w * facets[slot, 7]
    x2 -= v * facets[slot, 5] + w * facets[slot, 8]
    gap = math.sqrt(x0 * x0 + x1 * x1 + x2 * x2)
    normals = tree.normals
    side = x0 * normals[triangle, feature, 0] + x1 * normals[triangle, feature, 1]
    if side + x2 * normals[triangle, feature, 2] < 0.0:
        gap = -gap
    return triangle, feature, (y0 - x0, y1 - x1, y2 - x2), weights, gap


@njit(cache=True)
def gap_geometry(y, foot, triangle, feature, tree):
    """Normal N = d gap/dy and A = d(y - foot)/dy where `closest` found triangle, feature and foot.

    Returns N, a tuple of three, and A, a tuple of three rows: A[i][j]. On an edge or vertex without distance,
    where N has no limit, it is the pseudo-normal. Tuples, because threads that allocate or slice arrays here
    wait for each other's reference counts.
    """
    n, e = tree.normals, tree.directions
    n0, n1, n2 = n[triangle, feature, 0], n[triangle, feature, 1], n[triangle, feature, 2]
    if feature == 0:
        return (n0, n1, n2), (
            (n0 * n0, n0 * n1, n0 * n2), (n1 * n0, n1 * n1, n1 * n2), (n2 * n0, n2 * n1, n2 * n2))
    x0, x1, x2 = y[0] - foot[0], y[1] - foot[1], y[2] - foot[2]
    distance = math.sqrt(x0 * x0 + x1 * x1 + x2 * x2)
    if distance > 0.0:
        if x0 * n0 + x1 * n1 + x2 * n2 < 0.0:
            distance = -distance
        n0, n1, n2 = x0 / distance, x1 / distance, x2 / distance
    e0, e1, e2 = e[triangle, feature, 0], e[triangle, feature, 1], e[triangle, feature, 2]
    return (n0, n1, n2), (
        (1.0 - e0 * e0, -e0 * e1, -e0 * e2),
        (-e1 * e0, 1.0 - e1 * e1, -e1 * e2),
        (-e2 * e0, -e2 * e1, 1.0 - e2 * e2))
