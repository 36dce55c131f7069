"""Closest point on the smooth surface that facets approximate, from the nearest facet on.

The place is projected onto the patch over that facet, and from patch to patch (`hybrid.body.patches`). Beyond a sharp
edge of the smooth surface the closest point is on the edge, curved or straight, or on the other side of it. Near and
beyond a centre of curvature, where the projection fails, the place belongs to another patch or face: that of the smallest
gap nearby, or to the place of the nearest facet on its patch.

A closest point is (triangle, feature, closest_point, weights, gap), as `hybrid.body.closest.closest` returns it;
triangle -1 for none.
"""

import math


from hybrid.body.facet_tree import ALL, SECOND, box_distance, signed_distance, to_triangle
from hybrid.body.patches import FAILED, INSIDE, SMOOTH, along_edge, dot, geometry, neighbour, point, project, project_on_edge
from hybrid.runtime.jit import njit

FIXED = 7   # feature: a place on a patch that is not projected


@njit(cache=True)
def closest_on_patches(y, slot, feature, v, w, side, excluded, tree):
    """Closest point to y, a tuple of three [m], from the closest feature of the facet in a slot and the weights of its
    corners v1 and v2 there. side: a tuple of three; excluded: cosine with it below which facets are excluded, ALL for
    none.
    """
    distance, bulge = _to_facet(y, slot, feature, v, w, tree), tree.patches.bulge
    found = _projected(y, tree.order[slot], v, w, excluded == ALL, tree)
    # beside a tip the smooth surface may end at an edge that has the point on its inner side
    if found[0] < 0 or (found[4] < 0.0) != (distance < 0.0) and abs(found[4]) > 2.0 * bulge:
        found = _on_any_patch(y, slot, v, w, distance, side, excluded, tree)
    return found


@njit(cache=True)
def _to_facet(y, slot, feature, v, w, tree):
    """Signed distance [m] of y from a feature of the facet in a slot, at the weights v, w."""
    f = tree.facets[slot]
    x = (y[0] - f[0] - v * f[3] - w * f[6], y[1] - f[1] - v * f[4] - w * f[7], y[2] - f[2] - v * f[5] - w * f[8])
    return signed_distance(x, tree.order[slot], feature, tree)


@njit(cache=True)
def _projected(y, triangle, v, w, whole, tree):
    """Closest point on the smooth surface around the triangle; none near a centre of curvature.

    whole: whether the side beyond a sharp edge may be chosen.
    """
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
    """Closest point on the patch or face of a triangle, from the weights and the gap of a projection."""
    if tree.kind[triangle, SECOND]:
        N, _, _ = geometry(triangle, v, w, gap, tree.patches.nodes)
    else:
        N = tree.normals[triangle, 0, 0], tree.normals[triangle, 0, 1], tree.normals[triangle, 0, 2]
    return triangle, 0, (y[0] - gap * N[0], y[1] - gap * N[1], y[2] - gap * N[2]), (1.0 - v - w, v, w), gap


@njit(cache=True)
def _on_edge(y, triangle, edge, s, tree):
    """Closest point on a sharp edge of the smooth surface, from the fraction s of the edge."""
    s, closest_point = project_on_edge(y, triangle, edge, s, tree.patches.nodes)
    at_start, at_end = (1.0 - s, s) if 0.0 < s < 1.0 else ((1.0, 0.0) if s <= 0.0 else (0.0, 1.0))
    feature = 1 + edge if 0.0 < s < 1.0 else (4 + edge if s <= 0.0 else 4 + (edge + 1) % 3)
    if edge == 0:
        weights = at_start, at_end, 0.0
    elif edge == 1:
        weights = 0.0, at_start, at_end
    else:
        weights = at_end, 0.0, at_start
    x = y[0] - closest_point[0], y[1] - closest_point[1], y[2] - closest_point[2]
    return triangle, feature, closest_point, weights, signed_distance(x, triangle, feature, tree)


@njit(cache=True)
def _on_any_patch(y, slot, v, w, distance, side, excluded, tree):
    """Closest point on the patch or plane face of the smallest gap with the sign of `distance` [m], that to the nearest
    facet, which is in `slot`, at the weights v, w; where there is none, the place of that facet on its patch, if it has
    one. Others as in `closest_on_patches`.
    """
    boxes, first, facets, leaves = tree.boxes, tree.first, tree.facets, len(tree.first) - 1
    inside, reach, least = distance < 0.0, (abs(distance) + 2.0 * tree.patches.bulge) ** 2, math.inf
    found = -1, 0, y, (0.0, 0.0, 0.0), math.inf
    nearest, weights = tree.order[slot], (1.0 - v - w, v, w)
    for leaf in range(leaves):
        if box_distance(y[0], y[1], y[2], boxes, leaves + leaf) > reach:
            continue
        for k in range(first[leaf], first[leaf + 1]):
            if facets[k, 9] * side[0] + facets[k, 10] * side[1] + facets[k, 11] * side[2] < excluded:
                continue
            near, feature, v, w = to_triangle(y[0], y[1], y[2], facets, k, reach)
            triangle = tree.order[k]
            if near > reach or not tree.kind[triangle, SECOND] and feature != 0:
                continue
            t, v, w, gap, outcome = project(y, triangle, v, w, tree.patches)
            if outcome == INSIDE and abs(gap) < least and (gap < 0.0) == inside:
                least, found = abs(gap), _on_patch(y, t, v, w, gap, tree)
    if found[0] >= 0 or not tree.kind[nearest, SECOND]:
        return found
    closest_point = point(nearest, weights[1], weights[2], tree.patches.nodes)[0]
    x = y[0] - closest_point[0], y[1] - closest_point[1], y[2] - closest_point[2]
    return nearest, FIXED, closest_point, weights, -math.sqrt(dot(x, x)) if inside else math.sqrt(dot(x, x))
