"""A body with its sharp edges rounded off: the surface that soil which deforms is in contact with.

Every vertex on a sharp edge is split into one for each of the faces that meet there. These move into their faces until they
are the inset d away from the edge, and the other vertices of a face follow as in a stretched skin:

    min Σ w_ij |u_i - u_j|²      w_ij cotangent weights
    u·N = 0                      on the face
    u·m = d, 0                   beside a sharp edge, on the rim of a cut; m in the face, away from the edge

Between the faces the body is closed by parabolas (`hybrid.body.skin`).
"""

import numpy as np
from scipy.sparse import coo_matrix, diags, identity, kron
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import spsolve

from hybrid.body.closest import closest
from hybrid.body.skin import Skin, away_from, ends_of
from hybrid.body.smooth import area_vectors, rim_edges, shared_edges, unit

CONDITION, FREE = 1e9, 1e-9     # weights of conditions, and of no displacement where nothing else determines it, beside 1
OBTUSE = 0.05                   # smallest cotangent: an obtuse triangle would have negative weights
FOLDED = 1e-4                   # (twice area)/(longest edge)² at which a triangle counts as folded over
SMALLER, TRIES = 0.7, 12        # factor on all insets as long as a triangle folds


def round_off(surface, edges):
    """ContactSurface of a body with the SharpEdges `edges` of its `surface` rounded off; the surface as it is, if its
    triangles fold however small the insets are."""
    split, origin = _split(surface.triangles, edges)
    for _ in range(TRIES if len(edges.triangle) else 0):
        moved = _onto(surface, surface.vertices[origin] + _displacements(surface, split, edges), split)
        if not _folded(moved[split], surface.normals).any():
            return Skin(surface, split, moved, edges).close()
        edges = edges._replace(inset=SMALLER * edges.inset)
    return surface


def _split(triangles, edges):
    """Vertex (t, 3) after the split at every corner of the triangles, and the vertex (n,) that each was before."""
    (t, other), (k, j) = (side.T for side in shared_edges(triangles))
    sharp = np.zeros(triangles.shape, bool)
    sharp[edges.triangle, edges.number] = True
    t, k, other, j = (values[~sharp[t, k]] for values in (t, k, other, j))
    first = np.concatenate([3 * t + k, 3 * t + (k + 1) % 3])
    second = np.concatenate([3 * other + (j + 1) % 3, 3 * other + j])
    links = coo_matrix((np.ones(len(first)), (first, second)), shape=(triangles.size,) * 2)
    split = connected_components(links, directed=False)[1].reshape(-1, 3)
    origin = np.zeros(split.max() + 1, int)
    origin[split] = triangles
    return split, origin


def _displacements(surface, split, edges):
    """(n, 3) [m] of the vertices after the split."""
    count, away = split.max() + 1, away_from(surface)
    rim = rim_edges(surface.triangles)
    t, k = (np.concatenate([sharp.ravel(), cut]) for sharp, cut in zip((edges.triangle, edges.number), rim))
    inset = np.concatenate([edges.inset.ravel(), np.zeros(len(rim[0]))])
    vertex = np.concatenate([split.ravel(), split[t, k], split[t, (k + 1) % 3]])
    direction = np.concatenate([surface.corner_normals.reshape(-1, 3), away[t, k], away[t, k]])
    value = np.concatenate([np.zeros(split.size), inset, inset])
    start_end = ends_of(split, edges)
    still = np.unique(start_end[start_end[..., 0] == start_end[..., 1]])
    stays = np.isin(vertex, still, invert=True)
    vertex = np.concatenate([vertex[stays], np.repeat(still, 3)])
    direction = np.concatenate([direction[stays], np.tile(np.eye(3), (len(still), 1))])
    value = np.concatenate([value[stays], np.zeros(3 * len(still))])
    row, column = np.repeat(np.arange(len(vertex)), 3), (3 * vertex[:, None] + np.arange(3)).ravel()
    conditions = coo_matrix((direction.ravel(), (row, column)), shape=(len(vertex), 3 * count)).tocsr()
    skin = kron(_laplacian(surface, split, count) + FREE * identity(count), identity(3))
    found = spsolve((skin + CONDITION * conditions.T @ conditions).tocsc(), CONDITION * conditions.T @ value)
    return found.reshape(-1, 3)


def _onto(surface, points, split):
    """Vertices after the split at `points` (n, 3) [m], on the tangent planes of the surface, moved onto it."""
    if not len(surface.tree.patches.nodes):
        return points
    normals = np.zeros_like(points)
    np.add.at(normals, split, surface.corner_normals)
    return np.array([closest(point, np.inf, surface.tree, tuple(side))[2] for point, side in zip(points, unit(normals))])


def _laplacian(surface, split, count):
    """Σ w_ij |u_i - u_j|² as a matrix (count, count)."""
    corners = surface.vertices[surface.triangles]
    edge = np.roll(corners, -1, axis=1) - corners
    before = -np.roll(edge, 1, axis=1)                      # from each corner, its two edges
    sine = np.linalg.norm(np.cross(edge, before), axis=2)
    cotangent = np.maximum(np.einsum("tki,tki->tk", edge, before) / sine, OBTUSE)
    weight = np.roll(cotangent, -2, axis=1).ravel()         # of the corner opposite to each edge
    i, j = split.ravel(), np.roll(split, -1, axis=1).ravel()
    couplings = coo_matrix((weight, (i, j)), shape=(count, count))
    couplings = couplings + couplings.T
    return diags(np.asarray(couplings.sum(axis=1)).ravel()) - couplings


def _folded(corners, normals):
    """Which triangles (t,) with `corners` (t, 3, 3) have turned over, or nearly, from their `normals` (t, 3)."""
    twice = 2.0 * np.einsum("ti,ti->t", area_vectors(corners), normals)
    return twice < FOLDED * np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max(axis=1) ** 2
