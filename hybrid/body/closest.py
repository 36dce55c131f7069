"""Kernels of the contact surface: closest point by tree traversal, and the geometry of the gap there.

The tree finds the closest facet. Where facets approximate a curved surface, the point is projected from there onto the
smooth surface (`hybrid.body.closest_on_patches`), whose gap, normal and derivatives are those returned.

Symbols, features and sources as in `hybrid.body.surface`.
"""

import math


from hybrid.body.closest_on_patches import FIXED, closest_on_patches
from hybrid.body.facet_tree import ALL, NO_SIDE, OPPOSITE, SAME, SECOND, search, signed_distance
from hybrid.body.patches import SMOOTH, dot, edge_curve, geometry
from hybrid.runtime.jit import njit


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

    Returns (triangle, feature, closest_point, weights, gap): triangle number, -1 when none is nearer than reach;
    feature as in the module's head; closest_point y_s = y - gap N [m] and weights of the triangle's corners there
    (barycentric, or parameters of the curved patch) as tuples of three; gap [m], negative inside.
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

    beyond: [m] that y may be behind a side that looks at it for this to count although another one is nearer. A flank
    that overlaps the edge of a body by a hair is far behind that body's other flank. At the edge of a body whose flank
    lies in that of the other one none counts: the side would come and go with round-off."""
    found = closest(y, math.inf, tree, NO_SIDE)
    triangle, feature, closest_point, weights, gap = found
    if gap >= 0.0:
        return found
    N, _, _ = gap_geometry(y, closest_point, weights, gap, triangle, feature, tree)
    if dot(N, outward) < -least:
        return found
    none = -1, 0, (y[0], y[1], y[2]), (0.0, 0.0, 0.0), math.inf
    if beyond <= 0.0:
        return none
    side = -outward[0], -outward[1], -outward[2]
    slot, feature, v, w, _ = search(y[0], y[1], y[2], math.inf, tree, side, least)
    if slot < 0 or not _behind(y[0], y[1], y[2], slot, feature, tree):
        return none
    found = _place((y[0], y[1], y[2]), slot, feature, v, w, side, least, math.inf, tree)
    return found if found[4] > -beyond else none


@njit(cache=True)
def _place(y, slot, feature, v, w, side, excluded, reach, tree):
    """As `closest`, from the closest feature of the facet in a slot and the weights of its corners there. excluded: cosine
    with `side` below which facets are excluded, ALL for none."""
    y0, y1, y2 = y
    found = -1, 0, y, (0.0, 0.0, 0.0), math.inf
    if tree.kind[tree.order[slot], SECOND + feature]:
        found = closest_on_patches((y0, y1, y2), slot, feature, v, w, side, excluded, tree)
    if found[0] >= 0:
        return found if abs(found[4]) < reach else (-1, 0, (y0, y1, y2), (0.0, 0.0, 0.0), math.inf)
    triangle, facets, weights = tree.order[slot], tree.facets, (max(1.0 - v - w, 0.0), v, w)
    x0, x1, x2 = y0 - facets[slot, 0], y1 - facets[slot, 1], y2 - facets[slot, 2]
    if tree.kind[triangle, feature] == 0:
        # along the normal, so that y - y_s = gap N to round-off
        n0, n1, n2 = facets[slot, 9], facets[slot, 10], facets[slot, 11]
        gap = x0 * n0 + x1 * n1 + x2 * n2
        return triangle, 0, (y0 - gap * n0, y1 - gap * n1, y2 - gap * n2), weights, gap
    x0 -= v * facets[slot, 3] + w * facets[slot, 6]
    x1 -= v * facets[slot, 4] + w * facets[slot, 7]
    x2 -= v * facets[slot, 5] + w * facets[slot, 8]
    gap = signed_distance((x0, x1, x2), triangle, feature, tree)
    return triangle, feature, (y0 - x0, y1 - x1, y2 - x2), weights, gap


@njit(cache=True)
def gap_geometry(y, closest_point, weights, gap, triangle, feature, tree):
    """Normal N, gradient of the gap ∂g/∂y and G = ∂N/∂y at the closest point that `closest` found for y, with its results.

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
    x = y[0] - closest_point[0], y[1] - closest_point[1], y[2] - closest_point[2]
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
    # the closest point slides along the edge: ∂(y - y_s)/∂y = I - d d^T/slide
    return N, N, (
        _turning(0, N, d, slide, distance), _turning(1, N, d, slide, distance), _turning(2, N, d, slide, distance))


@njit(cache=True)
def _turning(i, N, d, slide, gap):
    """Row i of G = (I - d d^T/slide - N N^T)/gap."""
    one = (1.0 if i == 0 else 0.0), (1.0 if i == 1 else 0.0), (1.0 if i == 2 else 0.0)
    return ((one[0] - d[i] * d[0] / slide - N[i] * N[0]) / gap, (one[1] - d[i] * d[1] / slide - N[i] * N[1]) / gap,
            (one[2] - d[i] * d[2] / slide - N[i] * N[2]) / gap)
