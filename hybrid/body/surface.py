"""Contact surface of a rigid body: closest point, signed gap and normal, in the body frame.

    closest point  foot(y) = argmin |y - x| over the triangles, found in a tree of bounding boxes
    gap            g = ± |y - foot|, negative inside: the sign is that of (y - foot)·n̂
    normal         N = (y - foot)/g = dg/dy
    derivative     A = d(y - foot)/dy = N N^T on a face, I - e e^T on an edge, I at a vertex

| symbol | meaning                                                     | shape     | unit |
|--------|-------------------------------------------------------------|-----------|------|
| y      | query point, from the centre of mass                        | (3,)      | m    |
| foot   | closest point of the surface                                | (3,)      | m    |
| n̂      | pseudo-normal of a feature: of the face, of an edge (mean   | (t, 7, 3) | -    |
|        | of its faces), of a vertex (mean weighted by face angles)   |           |      |
| e      | direction of an edge                                        | (t, 7, 3) | -    |

Features of triangle (v0, v1, v2): 0 face; 1, 2, 3 edge v0v1, v1v2, v2v0; 4, 5, 6 vertex v0, v1, v2. What
matters to contact is the shape, not how it was cut into triangles: an edge between coplanar triangles, and
a vertex with only such edges, count as face, because there the foot slides freely. A vertex along a
straight edge keeps its number but has that edge's direction; at a true corner e = 0, and A = I - e e^T = I.

Triangles and tree never change; rotating the body is rotating y. The surface may be open: the edge of a cut
has the normal of its one triangle.

Sources: J. A. Baerentzen and H. Aanaes, IEEE Trans. Vis. Comput. Graph. 11 (2005) 243-253 (sign by
pseudo-normals); C. Ericson, Real-Time Collision Detection (2005), sec. 5.1.5 (regions of a triangle).
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from hybrid.errors import GeometryError

LEAF = 4               # triangles in a leaf of the tree, at most
FLAT = 1e-6            # two directions closer than this [rad] are the same
DEGENERATE = 1e-6      # smallest (twice area)/(longest edge)²; its square must stand out of round-off


class Tree(NamedTuple):
    """What the kernels read. Complete binary tree: node i has children 2i and 2i + 1, the root is 1.

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


@dataclass(frozen=True)
class ContactSurface:
    """Oriented triangles with their pseudo-normals; lengths in m, body frame, about the centre of mass.

    vertices (V, 3); triangles (t, 3) counter-clockwise seen from outside; normals (t, 3); edge_normals and
    vertex_normals (t, 3, 3) of the edges v0v1, v1v2, v2v0 and of the vertices; lower, upper (3,) bounds.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray
    edge_normals: np.ndarray
    vertex_normals: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    tree: Tree


def tree_arrays(surface):
    """The Tree of `surface`, a tuple of arrays: the last argument of `closest`."""
    return surface.tree


# ---------------------------------------------------------------- building, once


def build_surface(vertices, triangles):
    """ContactSurface of `triangles` (t, 3) int into `vertices` (n, 3) [m]; unused vertices are dropped.

    Triangles meet where they share vertex numbers, so coinciding vertices must have been merged. Raises
    GeometryError for no triangles, coordinates that are not finite, numbers out of range, a triangle
    without area, an edge of more than two triangles, or neighbours of opposite orientation.
    """
    vertices = np.asarray(vertices, dtype=float)
    triangles = np.asarray(triangles, dtype=np.int64)
    _check_arrays(vertices, triangles)
    used, compact = np.unique(triangles, return_inverse=True)
    vertices, triangles = vertices[used], compact.reshape(-1, 3)

    corners = vertices[triangles]
    normals = _face_normals(corners)
    edges = np.roll(corners, -1, axis=1) - corners
    edges /= np.linalg.norm(edges, axis=2)[:, :, None]
    edge_normals, sharp = _edge_normals(triangles, normals, edges)
    vertex_normals = _vertex_normals(triangles, normals, edges, len(vertices))
    creases, corner_kind = _creases(triangles, edges, sharp, len(vertices))

    kind = np.hstack((np.zeros((len(triangles), 1)), sharp, 2 * corner_kind)).astype(np.int64)
    tree = _build_tree(corners, normals, kind)._replace(
        normals=np.concatenate((normals[:, None], edge_normals, vertex_normals), axis=1),
        directions=np.concatenate((np.zeros((len(triangles), 1, 3)), edges, creases), axis=1),
    )
    lower, upper = vertices.min(axis=0), vertices.max(axis=0)
    return ContactSurface(vertices, triangles, normals, edge_normals, vertex_normals, lower, upper, tree)


def _check_arrays(vertices, triangles):
    if triangles.ndim != 2 or triangles.shape[1] != 3 or len(triangles) == 0:
        raise GeometryError(
            f"contact surface: triangles have shape {triangles.shape}, expected (t, 3) with t > 0; "
            'put at least one surface into the physical group "contact"')
    if vertices.ndim != 2 or vertices.shape[1] != 3 or not np.isfinite(vertices).all():
        raise GeometryError(
            f"contact surface: vertices of shape {vertices.shape} must be finite numbers of shape (n, 3); "
            "check the parameters of the geometry")
    if triangles.min() < 0 or triangles.max() >= len(vertices):
        raise GeometryError(
            f"contact surface: vertex numbers run from {triangles.min()} to {triangles.max()}, but there are "
            f"{len(vertices)} vertices, numbered from 0; pass the vertices the triangles refer to")


def _face_normals(corners):
    """Unit normals (t, 3) of `corners` (t, 3, 3), refusing triangles without area."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice = np.linalg.norm(normals, axis=1)
    longest = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max(axis=1)
    bad = np.flatnonzero(~(twice > DEGENERATE * longest**2))
    if len(bad):
        k = bad[0]
        raise GeometryError(
            f"contact surface: {len(bad)} triangle(s) without area, first number {k} with area "
            f"{twice[k] / 2:g} m² near {corners[k].mean(axis=0).tolist()} (limit "
            f"{DEGENERATE / 2 * longest[k]**2:g} m² for its longest edge of {longest[k]:g} m); "
            "change the mesh size or remove slivers from the geometry")
    return normals / twice[:, None]


def _edge_normals(triangles, normals, edges):
    """Pseudo-normals (t, 3, 3) of the edges and whether each edge is sharp or a rim, (t, 3) bool."""
    ends = np.stack((triangles, np.roll(triangles, -1, axis=1)), axis=2).reshape(-1, 2)
    _, edge, sharing = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True, return_counts=True)
    edge = edge.reshape(-1)
    forward = np.bincount(edge, weights=np.where(ends[:, 0] < ends[:, 1], 1, -1))
    if (sharing > 2).any():
        a, b = ends[np.flatnonzero(sharing[edge] > 2)[0]]
        raise GeometryError(
            f"contact surface: edge ({a}, {b}) belongs to {sharing.max()} triangles, the limit is 2: inside "
            "and outside are not defined there; fuse or separate the solids that touch along that edge")
    wrong = np.flatnonzero((sharing == 2) & (forward != 0))
    if len(wrong):
        a, b = ends[np.flatnonzero(edge == wrong[0])[0]]
        raise GeometryError(
            f"contact surface: the triangles at {len(wrong)} edge(s), first ({a}, {b}), are oriented against "
            "each other; orient all counter-clockwise seen from outside")

    own = np.repeat(normals, 3, axis=0)
    total = np.zeros((len(sharing), 3))
    np.add.at(total, edge, own)
    # sine of the angle to the neighbour; a fold by half a turn has none, but there the sum vanishes
    sine = np.linalg.norm(np.cross(own, total[edge]), axis=1)
    length = np.linalg.norm(total, axis=1)[edge]
    if (length < FLAT).any():
        a, b = ends[np.argmin(length)]
        raise GeometryError(
            f"contact surface: its two triangles at edge ({a}, {b}) lie on each other (limit {FLAT:g} rad "
            "between them), so the body has no thickness there; give it some")
    sharp = (sine > FLAT) | (sharing[edge] == 1) | (length < 1.0)
    return (total[edge] / length[:, None]).reshape(-1, 3, 3), sharp.reshape(-1, 3)


def _vertex_normals(triangles, normals, edges, count):
    """Pseudo-normals (t, 3, 3) of the vertices: face normals weighted by the angle of the face there."""
    cosine = -np.einsum("tki,tki->tk", edges, np.roll(edges, 1, axis=1))
    sine = np.linalg.norm(np.cross(edges, np.roll(edges, 1, axis=1)), axis=2)
    weighted = np.arctan2(sine, cosine)[:, :, None] * normals[:, None]
    total = np.zeros((count, 3))
    np.add.at(total, triangles.ravel(), weighted.reshape(-1, 3))
    # the sum can only vanish at a saddle that is closest to no point but itself
    return (total / np.maximum(np.linalg.norm(total, axis=1), FLAT)[:, None])[triangles]


def _creases(triangles, edges, sharp, count):
    """Direction (t, 3, 3) of the straight edge through each vertex, 0 if none, and (t, 3) 0 flat, 1 not."""
    # of each triangle, the two edges that leave each of its vertices
    leaving = np.stack((edges, -np.roll(edges, 1, axis=1)), axis=2)
    is_sharp = np.stack((sharp, np.roll(sharp, 1, axis=1)), axis=2)
    out_of = np.repeat(triangles[:, :, None], 2, axis=2)[is_sharp]
    into = np.stack((np.roll(triangles, -1, axis=1), np.roll(triangles, 1, axis=1)), axis=2)[is_sharp]
    # once per edge, not once per face
    _, single = np.unique(np.stack((out_of, into), axis=1), axis=0, return_index=True)
    out_of, direction = out_of[single], leaving[is_sharp][single]

    edges_at = np.bincount(out_of, minlength=count)
    one = np.zeros((count, 3))
    one[out_of] = direction
    bend = np.zeros((count, 3))
    np.add.at(bend, out_of, direction)   # opposite directions cancel
    straight = (edges_at == 2) & (np.linalg.norm(bend, axis=1) < FLAT)
    return np.where(straight[:, None], one, 0.0)[triangles], (edges_at > 0)[triangles]


def _build_tree(corners, face, kind):
    """Halve the triangles at the median centroid along the longest axis until LEAF or fewer remain."""
    leaves = 1
    while leaves * LEAF < len(corners):
        leaves *= 2
    centroids, lower, upper = corners.mean(axis=1), corners.min(axis=1), corners.max(axis=1)
    members = [None, np.arange(len(corners))]
    for node in range(1, leaves):
        own = members[node]
        axis = np.argmax(np.ptp(centroids[own], axis=0))
        own = own[np.argsort(centroids[own, axis], kind="stable")]
        members += [np.sort(own[: len(own) // 2]), np.sort(own[len(own) // 2:])]
    boxes = np.zeros((2 * leaves, 6))
    for node in range(1, 2 * leaves):
        boxes[node] = np.hstack((lower[members[node]].min(axis=0), upper[members[node]].max(axis=0)))
    order = np.concatenate(members[leaves:])
    first = np.cumsum([0] + [len(own) for own in members[leaves:]])
    v0, v1, v2 = (corners[order, k] for k in range(3))
    return Tree(boxes, first, order, np.hstack((v0, v1 - v0, v2 - v0, face[order])), None, None, kind)


# ---------------------------------------------------------------- kernels


@njit(cache=True)
def _outside(x, lower, upper):
    """How far x is outside an interval, 0 inside."""
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
    themselves and each other. The signs of these tell in which of seven regions around the triangle y
    projects.
    """
    d3, d4, d5, d6 = d1 - a, d2 - b, d1 - b, d2 - c      # the same products seen from v1 and from v2
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
    """Squared distance to the triangle in slot k, closest feature, weights; beyond best only its plane's."""
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
def search(y0, y1, y2, reach, boxes, first, order, facets):
    """Slot of the triangle nearest to (y0, y1, y2), if nearer than reach, else -1; its closest feature; the
    weights of v1 and v2 there; and how many triangles were looked at.

    Depth first, nearer child first. In a complete tree sibling and parent of a node are known by its
    number, so the stack of farther siblings still to visit is one bit per level, kept in the integer
    `waiting`: nothing is allocated.
    """
    leaves = len(first) - 1
    best, slot, feature, v, w, visited = reach * reach, -1, 0, 0.0, 0.0, 0
    if not _box_distance(y0, y1, y2, boxes, 1) <= best:
        return slot, feature, v, w, visited
    node, waiting = 1, 0
    while True:
        if node < leaves:
            node *= 2
            near = _box_distance(y0, y1, y2, boxes, node)
            far = _box_distance(y0, y1, y2, boxes, node + 1)
            if far < near:
                near, far, node = far, near, node + 1
            waiting = 2 * waiting + (1 if far <= best else 0)
            if near <= best:
                continue
        else:
            for k in range(first[node - leaves], first[node - leaves + 1]):
                visited += 1
                distance, found, fv, fw = _to_triangle(y0, y1, y2, facets, k, best)
                # of equally near triangles the one with the lowest number; none (slot -1) never ties
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
def closest(y, reach, tree):
    """Closest point of the surface to y (3,), array or tuple [m], if nearer than reach [m], which may be inf.

    Returns (triangle, feature, foot, weights, gap): triangle number, -1 when none is nearer than reach;
    feature as in the module's head; foot [m] and barycentric weights as tuples of three; gap [m], negative
    inside.
    """
    y0, y1, y2 = y[0], y[1], y[2]
    slot, feature, v, w, _ = search(y0, y1, y2, reach, tree.boxes, tree.first, tree.order, tree.facets)
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
