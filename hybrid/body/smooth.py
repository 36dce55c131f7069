"""The smooth surface that a body's triangles approximate: normals at their corners, and patches between these.

Normals come from the geometry where it has them (`hybrid.body.mesh`). At an edge of the body its two sides have
normals of their own, so every corner of every triangle has one. Where the geometry has none (a mesh without
geometry, the apex of a cone) they are those of the facets around the vertex, up to edges that bend by more than
FEATURE_ANGLE. Corners of neighbours whose normals are the same, or nearly, form one group with one normal.

The curvature c of an edge from x_i to x_j makes the quadratic x(s) = x_i + s d - s (1 - s) c, d = x_j - x_i, turn from
the tangent plane at one end into that at the other, on average (both sides, where they differ):

    (n_i + n_j)·c = (n_i - n_j)·d        c the shortest vector with this, for the normals of the one and the other side

It is zero on plane faces and on straight edges, and there the facets are the surface.
"""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from hybrid.body.patches import SMOOTH, Patches

# Feature angle, between facets: the edge of a mesh without geometry that bends more is an edge of the body. Twelve facets
# around a circle bend by as much. Sharp edges (`hybrid.body.sharp_edges`) lie between the normals that follow from it.
FEATURE_ANGLE = np.radians(30.0)
SAME = np.radians(1.0)     # between normals of the geometry on both sides of an edge that counts as smooth
STRAY = np.radians(60.0)   # between a normal of the geometry and its facet: one that is farther off is not used
ROUND_OFF = 1e-9           # normals and curvatures (relative) that differ by no more are equal
CREASE = 0.2               # |sum| or |difference| of two unit normals below which their direction is not used
LONGEST = 1.0              # curvature of an edge, relative to its length: arcs of more than 90 degrees stay chords


def unit(vectors):
    """Vectors (..., 3) scaled to length 1; zero stays zero."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0.0)


def area_vectors(corners):
    """Normals (t, 3) of triangles with `corners` (t, 3, 3) [m], as long as their areas [m²]."""
    return 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def shared_edges(triangles):
    """Triangle and edge number (e, 2) each of the two sides of every edge that two triangles share."""
    ends = np.sort(np.stack((triangles, np.roll(triangles, -1, axis=1)), axis=2).reshape(-1, 2), axis=1)
    _, number, count = np.unique(ends, axis=0, return_inverse=True, return_counts=True)
    number = number.reshape(-1)
    order = np.argsort(number, kind="stable")
    pairs = order[count[number[order]] == 2].reshape(-1, 2)
    return pairs // 3, pairs % 3


def rim_edges(triangles):
    """(triangles (r,), numbers (r,)) of the edges that only one triangle has: the rim of a cut."""
    rim = np.ones(triangles.shape, bool)
    rim[shared_edges(triangles)] = False
    return np.nonzero(rim)


def corner_normals(points, triangles, given=None, symmetry=None):
    """Outward unit normals (t, 3, 3) of the smooth surface at the corners of `triangles` (t, 3), oriented outward.

    given: (t, 3, 3) normals of the geometry, of either sign, nan where it has none; None: it has none at all.
    symmetry: (3,) normal of the plane that the body is cut by, through the rim of the triangles; None without one.
    """
    corners = points[triangles]
    facet = unit(area_vectors(corners))[:, None]
    given = np.full(corners.shape, np.nan) if given is None else given
    cosine = np.einsum("tki,tki->tk", given, np.broadcast_to(facet, corners.shape))
    given = given * np.sign(cosine)[:, :, None]
    known = np.abs(cosine) > np.cos(STRAY)          # False for nan
    plane = known & (np.linalg.norm(given - facet, axis=2) < ROUND_OFF)
    group = _groups(triangles, facet[:, 0], given, known)

    edges = unit(np.roll(corners, -1, axis=1) - corners)
    angle = np.arccos(np.clip(-np.einsum("tki,tki->tk", edges, np.roll(edges, 1, axis=1)), -1.0, 1.0))
    mean, by_geometry = np.zeros((group.max() + 1, 3)), np.zeros(group.max() + 1, int)
    facet = np.broadcast_to(facet, corners.shape)
    for rank, (members, normals) in enumerate(((np.ones_like(known), facet * angle[:, :, None]),
                                               (known, given), (plane, facet))):
        # plane faces come before other geometry, and this before facets
        total = np.zeros_like(mean)
        np.add.at(total, group[members], normals[members])
        there = np.isin(np.arange(len(mean)), group[members])
        mean[there], by_geometry[there] = unit(total[there]), rank
    if symmetry is not None:
        mean = _mirrored(mean, triangles, group, by_geometry, symmetry)
    normals = np.where(plane[:, :, None], facet, mean[group])
    return _without_apexes(normals, facet, (by_geometry[group] == 0))


def _groups(triangles, facet, given, known):
    """Number (t, 3) of the group of each corner: corners of one vertex whose triangles meet in smooth edges."""
    (t, other), (k, j) = (side.T for side in shared_edges(triangles))
    bend = np.einsum("ei,ei->e", facet[t], facet[other]) > np.cos(FEATURE_ANGLE)
    first, second = [], []
    for a, b in (((t, k), (other, (j + 1) % 3)), ((t, (k + 1) % 3), (other, j))):
        cosine = np.einsum("ei,ei->e", given[a], given[b])
        linked = np.where(known[a] & known[b], cosine > np.cos(SAME), bend)
        first.append((3 * a[0] + a[1])[linked])
        second.append((3 * b[0] + b[1])[linked])
    first, second = np.concatenate(first), np.concatenate(second)
    links = coo_matrix((np.ones(len(first)), (first, second)), shape=(triangles.size, triangles.size))
    return connected_components(links, directed=False)[1].reshape(-1, 3)


def _mirrored(mean, triangles, group, by_geometry, symmetry):
    """Normals of facets on the rim of a cut, with those of the facets' mirror images where these bend little."""
    ends = np.stack((triangles, np.roll(triangles, -1, axis=1)), axis=2)
    chosen = np.unique(group[np.isin(triangles, ends[rim_edges(triangles)])])
    across = mean[chosen] @ symmetry
    little = (by_geometry[chosen] == 0) & (np.abs(across) < np.sin(FEATURE_ANGLE / 2))
    chosen, across = chosen[little], across[little]
    mean = mean.copy()
    mean[chosen] = unit(mean[chosen] - across[:, None] * symmetry)
    return mean


def _without_apexes(normals, facet, by_facets):
    """At an apex no normal is near those of all facets: there a corner takes the mean of the other two of its facet."""
    apex = by_facets & (np.einsum("tki,tki->tk", normals, facet) < np.cos(FEATURE_ANGLE))
    rest = np.where(apex[:, :, None], 0.0, normals)
    others = unit(rest.sum(axis=1, keepdims=True) - rest)
    return np.where(apex[:, :, None], np.where(np.any(others != 0.0, axis=2, keepdims=True), others, facet), normals)


def build_patches(corners, triangles, facet, normals, given):
    """Patches over triangles (t, 3) with `corners` (t, 3, 3) [m], facets' normals `facet` (t, 3) and `normals` (t, 3, 3)
    at the corners, None: facets are the surface; and whether a closest point on a feature of a facet has to be
    projected onto them, (t, 7) bool. given: curvature (t, 3, 3) [m] of the edges, nan where it follows from the normals,
    None: everywhere."""
    count = len(triangles)
    flat = Patches(np.zeros((0, 9, 3)), np.zeros((0, 3, 2), np.int64), 0.0, 1.0), np.zeros((count, 7), bool)
    if normals is None:
        return flat
    near = np.linalg.norm(normals - facet[:, None], axis=2) < ROUND_OFF
    normals = np.where(near[:, :, None], facet[:, None], normals)
    t, k = shared_edges(triangles)
    curvature = _edge_curvature(corners, normals, t, k)
    if given is not None:
        curvature = np.where(np.isnan(given), curvature, given)
    curved = (curvature != 0.0).any(axis=(1, 2)) | ~near.all(axis=1)
    if not curved.any():
        return flat
    across = np.full((count, 3, 2), (-1, 0))
    across[t, k, 0] = (3 * t + k)[:, ::-1]
    jump = np.maximum(*(np.linalg.norm(normals[t[:, 0], (k[:, 0] + a) % 3] - normals[t[:, 1], (k[:, 1] + 1 - a) % 3],
                                       axis=1) for a in (0, 1)))
    across[t, k, 1] = np.where(jump < ROUND_OFF, SMOOTH, 0)[:, None]
    nodes = np.concatenate((corners[:, :1], corners[:, 1:] - corners[:, :1], normals[:, :1],
                            normals[:, 1:] - normals[:, :1], curvature), axis=1)
    bulge = np.linalg.norm(curvature, axis=2).max(axis=1) / 3       # Σ w_i w_j <= 1/3
    patches = Patches(nodes, across, float(bulge.max()), _steepness(nodes))
    return patches, _curved_features(triangles, across[:, :, 0], curved)


def _steepness(nodes):
    """Largest |∂g/∂y| on patches with `nodes` (t, 9, 3), at their corners and the middles of edges and patches, with a
    margin for what is between these."""
    x, d1, d2, n, n1, n2, c0, c1, c2 = np.moveaxis(nodes, 1, 0)
    largest = 1.0
    for v, w in ((0, 0), (1, 0), (0, 1), (0.5, 0), (0, 0.5), (0.5, 0.5), (1 / 3, 1 / 3)):
        u = 1 - v - w
        normal = np.cross(d1 + (v - u) * c0 - w * c1 + w * c2, d2 + v * c0 - v * c1 + (w - u) * c2)
        cosine = np.einsum("ti,ti->t", unit(normal), unit(n + v * n1 + w * n2))
        largest = max(largest, float(1.0 / np.clip(cosine, 0.5, 1.0).min()))
    return 1.0 + 2.0 * (largest - 1.0)


def _edge_curvature(corners, normals, t, k):
    """c (t, 3, 3) [m] of the edges; t, k: triangles and numbers (e, 2) of the edges that two triangles share."""
    d = np.roll(corners, -1, axis=1) - corners
    following = np.roll(normals, -1, axis=1)
    total = normals + following
    length = np.maximum(np.linalg.norm(total, axis=2, keepdims=True), CREASE)
    direction = total / length
    wanted = np.einsum("tki,tki->tk", normals - following, d)[:, :, None] / length
    c = wanted * direction
    one, two = (t[:, 0], k[:, 0]), (t[:, 1], k[:, 1])
    c[one] = c[two] = (_part(direction[one] + direction[two], wanted[one] + wanted[two])
                       + _part(direction[one] - direction[two], wanted[one] - wanted[two]))
    size, chord = np.linalg.norm(c, axis=2, keepdims=True), np.linalg.norm(d, axis=2, keepdims=True)
    return np.where((size > ROUND_OFF * chord) & (size < LONGEST * chord), c, 0.0)


def _part(direction, product):
    """Shortest vectors (e, 3) with the given product (e, 1) with `direction` (e, 3); 0 where that is nearly zero."""
    square = np.einsum("ei,ei->e", direction, direction)[:, None]
    return np.where(square > CREASE**2, product / np.maximum(square, CREASE**2), 0.0) * direction


def _curved_features(triangles, across, curved):
    """(t, 7) bool: features of curved triangles, and edges and vertices that plane triangles share with them."""
    beyond = (across >= 0) & curved[across // 3]
    at_curved = np.isin(triangles, triangles[curved])
    return np.hstack((curved[:, None], curved[:, None] | beyond, at_curved))
