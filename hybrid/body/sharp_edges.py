"""Sharp edges of a body, and how far contact on soil that deforms stays away from them.

The displacement of the grid bends at nodes only. A rigid face whose edge lies inside a cell, or on a line of the grid,
therefore drives soil beyond its edge too: a footing on clay carries the load of one that is wider by a third of a cell
on each side with its edges on grid lines, and by up to 0.8 cells with its edges inside cells. With edges rounded off
(`hybrid.body.rounded`) from

    d = min(h/2, ρ/2)        h smallest cell, ρ largest distance of a point of the face from its edges

on, on soil that yields or that it is driven along, the load is, on average over all places of the edge in a cell, that of
the footing itself; other elastic soil has soft springs there (`hybrid.contact.soft_edges`). d vanishes with the cells;
with ρ narrow faces keep contact. An edge is convex and bends by more than SHARP_ANGLE at both of its ends; the rim of a
cut through the body is none. Edges of triangles that run from the apex of a cone bend there only, and are none of the
cone: rounded off, its tip would sink in by a cell before it touches.
"""

from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from hybrid.body.smooth import shared_edges

SHARE = 0.5                     # of a cell, and of ρ
SHARP_ANGLE = np.radians(20.0)  # between normals of the smooth surface on both sides of an edge: less than the 30° at the
#                                 shoulder of a cone of 60°
AROUND = 2.0                    # cells of sharp edges around a face: a shorter one is a tip
SAMPLES = 6                     # points along an edge of a triangle at which ρ is measured


class SharpEdges(NamedTuple):
    """e edges of a ContactSurface, each with two sides: triangle (e, 2) and number (e, 2) of the edge there; inset (e, 2)
    [m], d on the face that the triangle is part of; around (e, 2) [m], length of the sharp edges of that face, inf in a
    section."""

    triangle: np.ndarray
    number: np.ndarray
    inset: np.ndarray
    around: np.ndarray


def find_edges(surface, cell, along=()):
    """SharpEdges of a ContactSurface on a grid with smallest cells of `cell` [m].

    along: unit vectors (3,) of the collapsed axes in the body frame, in the directions of which the body is a prism;
    only edges parallel to them count, and distances are those in the section.
    """
    (t, other), (k, j) = (side.T for side in shared_edges(surface.triangles))
    corners, normals = surface.vertices[surface.triangles], surface.normals
    bends = np.all(_bends(surface, t, k, other, j) > SHARP_ANGLE, axis=0)
    links = coo_matrix((np.ones(np.count_nonzero(~bends)), (t[~bends], other[~bends])), shape=(len(corners),) * 2)
    face = connected_components(links, directed=False)[1]
    convex = np.einsum("ei,ei->e", normals[t], corners[other].mean(axis=1) - corners[t].mean(axis=1)) < 0.0
    segment = np.stack([corners[t, k], corners[t, (k + 1) % 3]], axis=1)
    chosen = bends & convex & _parallel(segment, along)
    sides, numbers = np.stack([t, other], axis=1)[chosen], np.stack([k, j], axis=1)[chosen]
    lengths = np.linalg.norm(np.diff(segment[chosen], axis=1)[:, 0], axis=1)
    segment = _in_section(segment[chosen], along)
    inset = np.array([min(SHARE * cell, SHARE * _inradius(_in_section(corners[face == f], along),
                                                          segment[(face[sides] == f).any(axis=1)]))
                      for f in range(face.max() + 1)])
    around = np.bincount(face[sides].ravel(), np.repeat(lengths, 2), face.max() + 1) if not len(along) else np.full(
        face.max() + 1, np.inf)
    return SharpEdges(sides, numbers, *(of_face[face[sides]].reshape(-1, 2) for of_face in (inset, around)))


def narrowest_face(edges, cell):
    """Width [m] of the narrowest face beside SharpEdges, of those at most as wide as a `cell` [m] and longer; inf without
    one. The flat of 2 mm at the tip of a spudcan is none."""
    width, long = 2 / SHARE * edges.inset, edges.around > AROUND * cell
    return float(width.min(initial=np.inf, where=long & (width < (1 - 1e-6) * cell)))


def _bends(surface, t, k, other, j):
    """(2, e) [rad] between the normals of the two sides at both ends of edges: edge k of triangle t, j of `other`."""
    normals = surface.corner_normals
    pairs = ((normals[t, (k + a) % 3], normals[other, (j + 1 - a) % 3]) for a in (0, 1))
    return np.arccos([np.clip(np.einsum("ei,ei->e", *pair), -1.0, 1.0) for pair in pairs])


def _parallel(segment, along):
    """(e,) bool, segments parallel to all of the vectors `along`."""
    direction = segment[:, 1] - segment[:, 0]
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    return np.all([np.abs(direction @ axis) > np.cos(SHARP_ANGLE) for axis in along], axis=0) | np.zeros(len(segment), bool)


def _in_section(points, along):
    """Points (..., 3) [m] projected along the vectors `along`."""
    for axis in along:
        points = points - (points @ axis)[..., None] * axis
    return points


def _inradius(corners, segment):
    """Largest distance [m] of points of triangles (t, 3, 3) from segments (e, 2, 3); inf without any."""
    if not len(segment):
        return np.inf
    a, b = np.divmod(np.arange((SAMPLES + 1) ** 2), SAMPLES + 1)
    inside = a + b <= SAMPLES
    weights = np.stack([a, b, SAMPLES - a - b], axis=1)[inside] / SAMPLES
    places = np.einsum("sk,tki->tsi", weights, corners).reshape(-1, 3)
    nearest = np.full(len(places), np.inf)
    for start, end in segment:
        d = end - start
        s = np.clip((places - start) @ d / max(d @ d, 1e-300), 0.0, 1.0)
        nearest = np.minimum(nearest, np.linalg.norm(places - start - s[:, None] * d, axis=1))
    return nearest.max()
