"""Kernels of the contact surface: closest point by tree traversal, and the geometry of the gap there.

The tree finds the closest facet. Where facets approximate a curved surface, the point is projected from there onto the
smooth surface (`hybrid.body.patches`), whose gap, normal and derivatives are those returned. Beyond a sharp edge of it
the closest point is on the edge, curved or straight. Near and beyond a centre of curvature, where the projection fails, the
point belongs to another patch or face: that of the smallest gap nearby, or to the place of the nearest facet on its patch.

Symbols, features and sources as in `hybrid.body.surface`, which builds the Tree.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from hybrid.body.patches import (
    FAILED,
    INSIDE,
    SMOOTH,
    Patches,
    along_edge,
    dot,
    edge_curve,
    geometry,
    neighbour,
    point,
    project,
    project_on_edge,
)

NO_SIDE = (0.0, 0.0, 0.0)
OPPOSITE = -0.5  # cosine: a triangle more than 120 degrees from the side in contact belongs to the opposite side
SAME = 0.5       # cosine: a triangle less than 60 degrees from the side in contact belongs to it
ALL = -2.0       # cosine: no triangle is excluded
FIXED = 7        # feature: a place on a patch that is not projected
# Loops over places are parallel over LANES, place n in lane n modulo LANES: those near the body, which take longest, are
# neighbours in the list, and have to be shared out. Threads take lanes next to each other, so they write to memory apart.
LANES = 64
SECOND = 8       # offset of the second values of the features in Tree.normals and Tree.kind


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
        """(arrays, patches), for kernels with parallel loops, which take no tuples of tuples; see `joined`."""
        return self[:-1], self.patches


@njit(cache=True)
def joined(arrays, patches):
    """Tree from its `parts`."""
    boxes, first, order, facets, normals, kind = arrays
    return Tree(boxes, first, order, facets, normals, kind, patches)


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

    Its gap is then positive and no search is needed. With the slack, points on the plane of a cut count as inside, and
    patches that stand out of the box of the facets.
    """
    slack = 1e-6 * radius + tree.patches.bulge
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
    feature as in the module's head; foot = y - gap N [m] and weights of the triangle's corners there (barycentric, or
    parameters of the curved patch) as tuples of three; gap [m], negative inside.
    """
    y0, y1, y2 = y[0], y[1], y[2]
    excluded, widened = ALL, reach + tree.patches.bulge
    slot, feature, v, w, _ = search(y0, y1, y2, widened, tree, side, ALL)
    if slot >= 0 and _facing(slot, feature, side, tree) < OPPOSITE:
        excluded = OPPOSITE
        slot, feature, v, w, _ = search(y0, y1, y2, widened, tree, side, SAME)
        if slot < 0 or not _behind(y0, y1, y2, slot, feature, tree):
            slot, feature, v, w, _ = search(y0, y1, y2, widened, tree, side, OPPOSITE)
    if slot < 0:
        return -1, 0, (y0, y1, y2), (0.0, 0.0, 0.0), math.inf
    return _place((y0, y1, y2), slot, feature, v, w, side, excluded, reach, tree)


@njit(cache=True)
def closest_facing(y, outward, least, beyond, tree):
    """As `closest`, for a point y on the surface of another body with the normal `outward` there, a tuple of three: where
    it is inside, the closest point on a side that looks at it, N·outward < -least; gap inf where there is none.

    beyond: whether a side that looks at it counts although another one is nearer. At the edge of a body whose flank lies in
    that of the other one it does not: the side would come and go with round-off."""
    found = closest(y, math.inf, tree, NO_SIDE)
    triangle, feature, foot, weights, gap = found
    if gap >= 0.0:
        return found
    N, _, _ = gap_geometry(y, foot, weights, gap, triangle, feature, tree)
    if dot(N, outward) < -least:
        return found
    if not beyond:
        return -1, 0, (y[0], y[1], y[2]), (0.0, 0.0, 0.0), math.inf
    side = -outward[0], -outward[1], -outward[2]
    slot, feature, v, w, _ = search(y[0], y[1], y[2], math.inf, tree, side, least)
    if slot < 0 or not _behind(y[0], y[1], y[2], slot, feature, tree):
        return -1, 0, (y[0], y[1], y[2]), (0.0, 0.0, 0.0), math.inf
    return _place((y[0], y[1], y[2]), slot, feature, v, w, side, least, math.inf, tree)


@njit(cache=True)
def _place(y, slot, feature, v, w, side, excluded, reach, tree):
    """As `closest`, from the closest feature of the facet in a slot and the weights of its corners there. excluded: cosine
    with `side` below which facets are excluded, ALL for none."""
    y0, y1, y2 = y
    found = -1, 0, y, (0.0, 0.0, 0.0), math.inf
    if tree.kind[tree.order[slot], SECOND + feature]:
        distance, bulge = _to_facet((y0, y1, y2), slot, feature, v, w, tree), tree.patches.bulge
        found = _on_patches((y0, y1, y2), tree.order[slot], v, w, excluded == ALL, tree)
        # beside a tip the smooth surface may end at an edge that has the point on its inner side
        if found[0] < 0 or (found[4] < 0.0) != (distance < 0.0) and abs(found[4]) > 2.0 * bulge:
            found = _on_any_patch((y0, y1, y2), slot, v, w, distance, side, excluded, tree)
    if found[0] >= 0:
        return found if abs(found[4]) < reach else (-1, 0, (y0, y1, y2), (0.0, 0.0, 0.0), math.inf)
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
    gap = _signed((x0, x1, x2), triangle, feature, tree)
    return triangle, feature, (y0 - x0, y1 - x1, y2 - x2), weights, gap


@njit(cache=True)
def _to_facet(y, slot, feature, v, w, tree):
    """Signed distance [m] of y from a feature of the facet in a slot, at the weights v, w."""
    f = tree.facets[slot]
    x = (y[0] - f[0] - v * f[3] - w * f[6], y[1] - f[1] - v * f[4] - w * f[7], y[2] - f[2] - v * f[5] - w * f[8])
    return _signed(x, tree.order[slot], feature, tree)


@njit(cache=True)
def _on_any_patch(y, slot, v, w, distance, side, excluded, tree):
    """As `closest`, on the patch or plane face of the smallest gap with the sign of `distance`, that to the nearest facet, which is
    in `slot`, at the weights v, w; where there is none, the place of that facet on its patch. Others as in `_place`."""
    boxes, first, facets, leaves = tree.boxes, tree.first, tree.facets, len(tree.first) - 1
    inside, reach, least = distance < 0.0, (abs(distance) + 2.0 * tree.patches.bulge) ** 2, math.inf
    found = -1, 0, y, (0.0, 0.0, 0.0), math.inf
    nearest, weights = tree.order[slot], (1.0 - v - w, v, w)
    for leaf in range(leaves):
        if _box_distance(y[0], y[1], y[2], boxes, leaves + leaf) > reach:
            continue
        for k in range(first[leaf], first[leaf + 1]):
            if facets[k, 9] * side[0] + facets[k, 10] * side[1] + facets[k, 11] * side[2] < excluded:
                continue
            near, feature, v, w = _to_triangle(y[0], y[1], y[2], facets, k, reach)
            triangle = tree.order[k]
            if near > reach or not tree.kind[triangle, SECOND] and feature != 0:
                continue
            t, v, w, gap, outcome = project(y, triangle, v, w, tree.patches)
            if outcome == INSIDE and abs(gap) < least and (gap < 0.0) == inside:
                least, found = abs(gap), _on_patch(y, t, v, w, gap, tree)
    if found[0] >= 0 or not tree.kind[nearest, SECOND]:
        return found
    foot = point(nearest, weights[1], weights[2], tree.patches.nodes)[0]
    x = y[0] - foot[0], y[1] - foot[1], y[2] - foot[2]
    return nearest, FIXED, foot, weights, -math.sqrt(dot(x, x)) if inside else math.sqrt(dot(x, x))


@njit(cache=True)
def _signed(x, triangle, feature, tree):
    """Length of x, the way from an edge or vertex to the point, negative inside."""
    n, gap = tree.normals, math.sqrt(dot(x, x))
    side = x[0] * n[triangle, feature, 0] + x[1] * n[triangle, feature, 1] + x[2] * n[triangle, feature, 2]
    return -gap if side < 0.0 else gap


@njit(cache=True)
def _on_patches(y, triangle, v, w, whole, tree):
    """As `closest`, on the smooth surface around the triangle; triangle -1 near a centre of curvature.

    whole: whether the side beyond a sharp edge may be chosen."""
    patches = tree.patches
    triangle, v, w, gap, outcome = project(y, triangle, v, w, patches)
    if outcome == FAILED:
        return -1, 0, y, (0.0, 0.0, 0.0), math.inf
    if outcome >= 0:
        s = along_edge(outcome, v, w)
        if whole and patches.across[triangle, outcome, 0] >= 0:
            t, v, w = neighbour(triangle, outcome, s, patches)
            t, v, w, gap, beyond = project(y, t, v, w, patches)
            if beyond == INSIDE:
                return _on_patch(y, t, v, w, gap, tree)
        return _on_edge(y, triangle, outcome, s, tree)
    if whole:
        for edge in range(3):
            if patches.across[triangle, edge, 1] != SMOOTH and patches.across[triangle, edge, 0] >= 0:
                t, v2, w2 = neighbour(triangle, edge, along_edge(edge, v, w), patches)
                t, v2, w2, gap2, beyond = project(y, t, v2, w2, patches)
                if beyond == INSIDE and abs(gap2) < abs(gap):
                    return _on_patch(y, t, v2, w2, gap2, tree)
    return _on_patch(y, triangle, v, w, gap, tree)


@njit(cache=True)
def _on_patch(y, triangle, v, w, gap, tree):
    if tree.kind[triangle, SECOND]:
        N, _, _ = geometry(triangle, v, w, gap, tree.patches.nodes)
    else:
        N = tree.normals[triangle, 0, 0], tree.normals[triangle, 0, 1], tree.normals[triangle, 0, 2]
    return triangle, 0, (y[0] - gap * N[0], y[1] - gap * N[1], y[2] - gap * N[2]), (1.0 - v - w, v, w), gap


@njit(cache=True)
def _on_edge(y, triangle, edge, s, tree):
    """As `closest`, on a sharp edge of the smooth surface."""
    s, foot = project_on_edge(y, triangle, edge, s, tree.patches.nodes)
    at_start, at_end = (1.0 - s, s) if 0.0 < s < 1.0 else ((1.0, 0.0) if s <= 0.0 else (0.0, 1.0))
    feature = 1 + edge if 0.0 < s < 1.0 else (4 + edge if s <= 0.0 else 4 + (edge + 1) % 3)
    if edge == 0:
        weights = at_start, at_end, 0.0
    elif edge == 1:
        weights = 0.0, at_start, at_end
    else:
        weights = at_end, 0.0, at_start
    x = y[0] - foot[0], y[1] - foot[1], y[2] - foot[2]
    return triangle, feature, foot, weights, _signed(x, triangle, feature, tree)


@njit(cache=True)
def gap_geometry(y, foot, weights, gap, triangle, feature, tree):
    """Normal N, gradient of the gap ∂g/∂y and G = ∂N/∂y where `closest` found triangle, feature, foot, weights and gap.

    N and ∂g/∂y are tuples of three, G a tuple of three rows, G[i][j] = ∂N_i/∂y_j. N = ∂g/∂y, except on curved patches,
    where N is normal to the surface up to second order in the facets' size. On an edge or vertex without distance,
    where N has no limit, it is the pseudo-normal and G zero. Tuples, because threads that allocate or slice arrays here
    wait for each other's reference counts.
    """
    n, e, patches = tree.normals, SECOND + feature, tree.patches
    zero = 0.0, 0.0, 0.0
    N = n[triangle, feature, 0], n[triangle, feature, 1], n[triangle, feature, 2]
    if feature == 0:
        if tree.kind[triangle, SECOND]:
            return geometry(triangle, weights[1], weights[2], gap, patches.nodes)
        return N, N, (zero, zero, zero)
    x = y[0] - foot[0], y[1] - foot[1], y[2] - foot[2]
    distance = math.sqrt(dot(x, x))
    if distance == 0.0:
        return N, N, (zero, zero, zero)
    if gap < 0.0:
        distance = -distance
    N = x[0] / distance, x[1] / distance, x[2] / distance
    d, slide = (n[triangle, e, 0], n[triangle, e, 1], n[triangle, e, 2]) if feature != FIXED else zero, 1.0
    if 0 < feature < 4 and tree.kind[triangle, SECOND + feature] and patches.across[triangle, feature - 1, 1] != SMOOTH:
        _, d, c = edge_curve(triangle, feature - 1, weights[feature % 3], patches.nodes)
        slide = dot(d, d) - 2.0 * dot(x, c)
    # the foot slides along the edge: ∂(y - foot)/∂y = I - d d^T/slide
    return N, N, (
        _turning(0, N, d, slide, distance), _turning(1, N, d, slide, distance), _turning(2, N, d, slide, distance))


@njit(cache=True)
def _turning(i, N, d, slide, gap):
    """Row i of G = (I - d d^T/slide - N N^T)/gap."""
    one = (1.0 if i == 0 else 0.0), (1.0 if i == 1 else 0.0), (1.0 if i == 2 else 0.0)
    return ((one[0] - d[i] * d[0] / slide - N[i] * N[0]) / gap, (one[1] - d[i] * d[1] / slide - N[i] * N[1]) / gap,
            (one[2] - d[i] * d[2] / slide - N[i] * N[2]) / gap)
