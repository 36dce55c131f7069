"""Places on the surface of a body at which its contact with another body is evaluated.

Each triangle is cut into 4^n equal ones, whose centroids, on the curved patch where there is one, are the places, but for
a thousandth of their size: the midpoint rule of ∫ k g dA. Only triangles near the other body are cut, and of them only
what is near it, so that the number of places does not grow with the size of a body. A place keeps its number, which names
triangle and part.

A sharp edge or corner that meets a face of the other body lies between places of that face. So edges carry places as
well, and count with an area of their length times a width; corners count with an area of their own
(`hybrid.setup.body_contact`). They begin to press a `depth` later than faces: a face that lies flat carries alone, or the
edges around it would carry a part of the load too far from its middle, and friction would resist turning by too much (a beam
of 2 x 0.05 m by 36 %).
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hybrid.body.closest import closest
from hybrid.body.parts import vector_areas
from hybrid.body.patches import point, unit_normal
from hybrid.contact.edge_places import places_on_edges
from hybrid.contact.search import distances
from hybrid.runtime.jit import njit

FINEST = 12     # times that a triangle may be cut into four
SPREAD = 1.5    # spacings in the longest edge of a part of a triangle
# Shares of a part's sides by which its place lies beside the centroid, to one side in parts the one way round, to the other
# in those the other way. Bodies have round sizes, so that the edge of one would lie exactly over a row of centroids of the
# other one, all of which come and go as it moves by 1e-6 of its size: without inertia stacks had no solution.
ASIDE = 1.3e-3, 0.7e-3
FACES = 5.0     # surface of a body over the area of the face that it lies on


class Pieces(NamedTuple):
    """Triangles of a surface: corners (t, 3, 3) [m], normal (t, 3), nodes (t, 9, 3) of their patches (empty if none is
    curved), curved (t,) bool, bulge [m] of patches, cuts (t,) times that each is cut into four, first (t,) number of its
    places."""

    corners: np.ndarray
    normal: np.ndarray
    nodes: np.ndarray
    curved: np.ndarray
    bulge: float
    cuts: np.ndarray
    first: np.ndarray


class BodyPlaces(NamedTuple):
    """m places on a body: number (m,) of each; point (m, 3) [m] and outward normal (m, 3) in its frame; area (m,) [m²];
    clearance (m,) [m]: they cannot touch the other body before they move by it; depth (m,) [m]: overlap from which on they
    press."""

    number: np.ndarray
    point: np.ndarray
    normal: np.ndarray
    area: np.ndarray
    clearance: np.ndarray
    depth: np.ndarray


@dataclass(frozen=True)
class Samples:
    """All places of a body, against one other body.

    pieces: the triangles that are cut where it is necessary; edges: BodyPlaces on its sharp edges and corners, whose
    clearance is not set; share: part of the body that lies in the slice of plane strain, else 1; flat: (k, 3) unit
    vectors of the body frame along collapsed axes, along which places lie at the centre of mass; first_edge: number of
    the first place on an edge; beside: (e, 2, 3) normals there of the curved faces that meet at `edges`, 0 of plane ones and
    at corners
    """

    pieces: Pieces
    edges: BodyPlaces
    share: float = 1.0
    flat: np.ndarray | None = None
    first_edge: int = 0
    beside: np.ndarray | None = None

    def near(self, turn, way, surface, reach):
        """Places within `reach` [m] of the `surface` of another body, in whose frame a point X of this one is at turn X +
        way."""
        count = 256
        while True:
            found = (np.empty(count, np.int64), np.empty((count, 3)), np.empty((count, 3)), np.empty(count), np.empty(count))
            flat = np.zeros((0, 3)) if self.flat is None else self.flat
            needed = _near(self.pieces, flat, turn, way, surface.tree, reach, found)
            if needed <= count:
                break
            count = needed
        places = BodyPlaces(*(values[:needed] for values in found), np.zeros(needed))
        edges = self.edges
        distance = distances(edges.point @ turn.T + way, surface, reach)[0]
        close = distance <= reach
        joined = BodyPlaces(*(np.concatenate([a, b[close]]) for a, b in zip(places, edges._replace(clearance=distance))))
        return joined._replace(area=self.share * joined.area)


def sample(surface, spacing, width, corner, depth=0.0, flat=None, share=1.0, sagitta=np.inf):
    """Samples of a ContactSurface with a `spacing` [m] of places, a `width` [m] that edges count with, an area `corner`
    [m²] of corners, and a `depth` [m] of both; flat, share: as in Samples; sagitta: [m] that a curved edge rises by between
    places at most, so that a body rolls on it, and then counts with RIM times the width, as a short arc of it touches
    (`hybrid.contact.edge_places`)."""
    corners = surface.vertices[surface.triangles]
    longest = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max(axis=1)
    cuts = np.clip(np.ceil(np.log2(longest / (SPREAD * spacing))), 0, FINEST).astype(np.int64)
    total = np.cumsum(np.concatenate([[0], 4**cuts]))
    patches = surface.tree.patches
    pieces = Pieces(corners, surface.normals, patches.nodes, surface.curved, patches.bulge, cuts, total[:-1])
    point, normal, area, beside = places_on_edges(surface, spacing, width, corner, sagitta)
    for axis in () if flat is None else flat:
        point = point - (point @ axis)[:, None] * axis
    zero = np.zeros(len(point))
    edges = BodyPlaces(total[-1] + np.arange(len(point)), point, normal, area, zero, zero + depth)
    return Samples(pieces, edges, share, flat, int(total[-1]), beside)


def flat_overlap(surface, force, stiffness):
    """[m] by which a face overlaps another body under a `force` [N] at a `stiffness` [N/m³]; as a rule it has about a fifth
    of the area of the surface."""
    return FACES * force / (stiffness * np.linalg.norm(vector_areas(surface), axis=2).sum())


def everywhere(surface, spacing):
    """Points (n, 3) [m] all over a ContactSurface, no farther apart than about a `spacing` [m], outward normals (n, 3)
    there and areas (n,) [m²]."""
    pieces = sample(surface, spacing, 0.0, 0.0).pieces
    count = int((4**pieces.cuts).sum())
    found = np.empty((count, 3)), np.empty((count, 3)), np.empty(count)
    _everywhere(pieces, np.zeros((0, 3)), *found)
    return found


def on_curves(samples, chosen, angles, turn):
    """Points (n, 3) [m] and normals (n, 3) on the `chosen` (c,) triangles of Samples, whose normals turn by `angles` (c,)
    [rad], so many that those of neighbours differ by about `turn` [rad]."""
    pieces = samples.pieces
    cuts = np.clip(np.ceil(np.log2(np.maximum(angles, turn) / turn)), 0, FINEST).astype(np.int64)
    pieces = pieces._replace(**{name: getattr(pieces, name)[chosen] for name in ("corners", "normal", "nodes", "curved")},
                             cuts=cuts)
    count = int((4**cuts).sum())
    point, normal = np.empty((count, 3)), np.empty((count, 3))
    _everywhere(pieces, np.zeros((0, 3)) if samples.flat is None else samples.flat, point, normal, np.empty(count))
    return point, normal


@njit(cache=True)
def _size(corners):
    """Largest distance of the corners of a triangle from its centroid."""
    size = 0.0
    for k in range(3):
        square = 0.0
        for i in range(3):
            middle = (corners[0, i] + corners[1, i] + corners[2, i]) / 3.0
            square += (corners[k, i] - middle) ** 2
        size = max(size, np.sqrt(square))
    return size


@njit(cache=True)
def _moved(x, turn, way):
    return (turn[0, 0] * x[0] + turn[0, 1] * x[1] + turn[0, 2] * x[2] + way[0],
            turn[1, 0] * x[0] + turn[1, 1] * x[1] + turn[1, 2] * x[2] + way[1],
            turn[2, 0] * x[0] + turn[2, 1] * x[1] + turn[2, 2] * x[2] + way[2])


@njit(cache=True)
def _in_box(x, box, margin):
    """Whether a point lies in a box, its lower corner and then its upper one, or at most `margin` outside."""
    inside = True
    for i in range(3):
        inside = inside and box[i] - margin <= x[i] <= box[3 + i] + margin
    return inside


@njit(cache=True)
def _near(pieces, flat, turn, way, tree, reach, found):
    """Fill `found`, the arrays of BodyPlaces, and return the number of places, which may be more than fit.

    A part of a triangle is followed where a ball around it is within reach. It is known by the weights (v, w) of its first
    corner and the length h of its sides in them, negative for the part in the middle, which lies the other way round.
    """
    number, point, normal, area, clearance = found
    count = 0
    stack_v, stack_w, stack_h = np.empty(64), np.empty(64), np.empty(64)
    stack_n, stack_path = np.empty(64, np.int64), np.empty(64, np.int64)
    for t in range(len(pieces.cuts)):
        size = _size(pieces.corners[t])
        stack_v[0], stack_w[0], stack_h[0], stack_n[0], stack_path[0], top = 0.0, 0.0, 1.0, 0, 0, 1
        while top > 0:
            top -= 1
            v, w, h, n, path = stack_v[top], stack_w[top], stack_h[top], stack_n[top], stack_path[top]
            last = n == pieces.cuts[t]
            aside = last * ASIDE[0], last * ASIDE[1]
            x, N, jacobian = _at(pieces, t, v + h * (1.0 / 3.0 + aside[0]), w + h * (1.0 / 3.0 + aside[1]), flat)
            y = _moved(x, turn, way)
            around = 0.0 if last else abs(h) * size + 2.0 * pieces.bulge
            if not _in_box(y, tree.boxes[1], tree.patches.bulge + reach + around):
                continue
            triangle, _, _, _, gap = closest(y, tree.patches.steepness * (reach + around), tree)
            if triangle < 0:
                continue
            if not last:
                half = 0.5 * h
                for child in range(4):
                    stack_v[top + child] = v + half * (child == 1 or child == 3)
                    stack_w[top + child] = w + half * (child == 2 or child == 3)
                    stack_h[top + child] = half if child < 3 else -half
                    stack_n[top + child], stack_path[top + child] = n + 1, 4 * path + child
                top += 4
                continue
            if gap > reach * tree.patches.steepness:
                continue
            if count < len(number):
                number[count] = pieces.first[t] + path
                area[count] = 0.5 * jacobian * h * h
                clearance[count] = gap / tree.patches.steepness if gap > 0.0 else gap
                for i in range(3):
                    point[count, i], normal[count, i] = x[i], N[i]
            count += 1
    return count


@njit(cache=True)
def _everywhere(pieces, flat, point, normal, area):
    """Fill the points and normals (n, 3) and areas (n,) of all parts of triangles: rows of them, those in between upside
    down."""
    count = 0
    for t in range(len(pieces.cuts)):
        rows = 2 ** pieces.cuts[t]
        for i in range(rows):
            for j in range(rows - i):
                for third in range(1, 3 if i + j < rows - 1 else 2):
                    x, N, jacobian = _at(pieces, t, (i + third / 3.0) / rows, (j + third / 3.0) / rows, flat)
                    area[count] = 0.5 * jacobian / rows**2
                    for k in range(3):
                        point[count, k], normal[count, k] = x[k], N[k]
                    count += 1


@njit(cache=True)
def _at(pieces, t, v, w, flat):
    """Point at weights (v, w) of triangle t, its normal, and twice the area over that in the weights."""
    if len(pieces.nodes) and pieces.curved[t]:
        x, x_v, x_w = point(t, v, w, pieces.nodes)
        N, _, _ = unit_normal(t, v, w, pieces.nodes)
    else:
        c = pieces.corners
        x_v = c[t, 1, 0] - c[t, 0, 0], c[t, 1, 1] - c[t, 0, 1], c[t, 1, 2] - c[t, 0, 2]
        x_w = c[t, 2, 0] - c[t, 0, 0], c[t, 2, 1] - c[t, 0, 1], c[t, 2, 2] - c[t, 0, 2]
        x = (c[t, 0, 0] + v * x_v[0] + w * x_w[0], c[t, 0, 1] + v * x_v[1] + w * x_w[1],
             c[t, 0, 2] + v * x_v[2] + w * x_w[2])
        N = pieces.normal[t, 0], pieces.normal[t, 1], pieces.normal[t, 2]
    a = x_v[1] * x_w[2] - x_v[2] * x_w[1]
    b = x_v[2] * x_w[0] - x_v[0] * x_w[2]
    c2 = x_v[0] * x_w[1] - x_v[1] * x_w[0]
    for k in range(len(flat)):
        along = flat[k, 0] * x[0] + flat[k, 1] * x[1] + flat[k, 2] * x[2]
        x = x[0] - along * flat[k, 0], x[1] - along * flat[k, 1], x[2] - along * flat[k, 2]
    return x, N, np.sqrt(a * a + b * b + c2 * c2)
