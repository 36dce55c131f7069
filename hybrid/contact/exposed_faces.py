"""Faces of the points' domains at which the soil ends, near one body, and the samples of the body that may meet them.

The four corners x_a of a face are material points carried by the grid (contact/corners.py), and the face is the plane
that fits them,

    o = Σ x_a / 4     e_α = Σ s_αa x_a / 4,  s_αa = ±1     n = e_1 × e_2 / |e_1 × e_2|
    x = o + ξ^α e_α + g n                                  |ξ^α| <= 1 on the face

A face is exposed when a point half a domain beyond it lies in no other domain, nor behind a face of the grid that holds
the soil. A sample is given to one face for the whole step: the nearest one whose span holds it where the motion that
the step expects ends, and that faces the body's surface there. Where the soil's surface bends, the spans of neighbours
leave a wedge between them; there a span widens with the distance from its face. As in contact/first_contact.py, the
friction of a newborn contact is anchored where the expected path goes through the face.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.spatial import cKDTree

from hybrid.body.attitude import log_so3
from hybrid.contact.corners import SIGNS

COVER = 1.2          # a domain covers what is within this many half-widths: neighbours do not tile once strained
FACING = 0.1         # cosine between the normal of the soil and that into the body
WEDGE = 0.5          # rad between neighbouring faces, in whose wedge a sample is given to one of them
RIM = 0.01           # rad by which a face may tilt before it loses a sample on the rim of the soil
NEIGHBOURS = 6       # faces or domains looked at for each place
HALVINGS = 12        # of the path, as for corners
U = np.array([-1.0, 1.0, 1.0, -1.0]) / 4   # s_1a/4 and s_2a/4 of the corners, counter-clockwise seen from outside
V = np.array([-1.0, -1.0, 1.0, 1.0]) / 4


def _layout():
    """Corner numbers (6, 4) of the faces x_min, x_max, y_min, ... in the order of U and V, and normals (6, 3)."""
    corners, normals = np.empty((6, 4), int), np.zeros((6, 3))
    for axis in range(3):
        for upper in (0, 1):
            side, u, v = 2 * upper - 1, (axis + 1) % 3, (axis + 2) % 3
            u, v = (u, v) if upper else (v, u)
            for a in range(4):
                sign = np.zeros(3)
                sign[axis], sign[u], sign[v] = side, np.sign(U[a]), np.sign(V[a])
                corners[2 * axis + upper, a] = np.flatnonzero((SIGNS == sign).all(axis=1))[0]
            normals[2 * axis + upper, axis] = side
    return corners, normals


LAYOUT, NORMALS = _layout()


@dataclass(frozen=True)
class Frame:
    """Planes of m faces: origin (m, 3), edges (m, 2, 3) e_α, dual edges e^α (m, 2, 3), normal (m, 3)."""

    origin: np.ndarray
    edges: np.ndarray
    dual: np.ndarray
    normal: np.ndarray

    @classmethod
    def from_corners(cls, corners):
        """Frame of faces with `corners` (m, 4, 3) [m]."""
        edges = np.einsum("ca,mai->mci", np.stack([U, V]), corners)
        normal = np.cross(edges[:, 0], edges[:, 1])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        a, b, c = (np.einsum("mi,mi->m", edges[:, i], edges[:, j])[:, None] for i, j in ((0, 0), (0, 1), (1, 1)))
        dual = np.stack([c * edges[:, 0] - b * edges[:, 1], a * edges[:, 1] - b * edges[:, 0]], axis=1)
        return cls(corners.mean(axis=1), edges, dual / (a * c - b * b)[:, None], normal)

    def local_coordinates(self, x):
        """Coordinates (m, 2) ξ^α and gap (m,) [m] of places x (m, 3)."""
        d = x - self.origin
        return np.einsum("mai,mi->ma", self.dual, d), np.einsum("mi,mi->m", self.normal, d)


def exposed_faces(position, half, grid, corners):
    """Corners (f, 4), as indices into `corners`, and points (f,) of the exposed faces whose corners are all there."""
    point = np.unique(corners.id // 8)
    face = np.tile(np.arange(6), len(point))
    point = np.repeat(point, 6)
    wanted = 8 * point[:, None] + LAYOUT[face]
    at = np.minimum(np.searchsorted(corners.id, wanted), max(len(corners) - 1, 0))
    whole = (corners.id[at] == wanted).all(axis=1) if len(corners) else np.zeros(0, bool)
    point, face, at = point[whole], face[whole], at[whole]
    outside = position[point] + 1.5 * half[point] * NORMALS[face]
    bare = ~_covered(outside, position, half, grid, point)
    return at[bare], point[bare]


def _covered(x, position, half, grid, point):
    """(m,) bool, whether places (m, 3) beyond faces of `point` (m,) lie in a domain or behind a face that holds it."""
    lower, upper = grid.extent.T
    covered = ((x < lower) & grid.closed[:, 0]).any(axis=1) | ((x > upper) & grid.closed[:, 1]).any(axis=1)
    if not len(x):
        return covered
    margin = 4 * half[point].max()
    around = np.flatnonzero(_in_box(position, x.min(axis=0) - margin, x.max(axis=0) + margin))
    count = min(NEIGHBOURS, len(around))
    near = around[cKDTree(position[around]).query(x, count)[1].reshape(len(x), count)]
    inside = (np.abs(x[:, None] - position[near]) <= COVER * half[near]).all(axis=2) & (near != point[:, None])
    return covered | inside.any(axis=1)


@njit(cache=True)
def _in_box(position, lower, upper):
    """(n,) bool, in one pass over all points."""
    within = np.empty(len(position), np.bool_)
    for p in range(len(position)):
        within[p] = (lower[0] < position[p, 0] < upper[0] and lower[1] < position[p, 1] < upper[1]
                     and lower[2] < position[p, 2] < upper[2])
    return within


def assign(x, area, end, depth, reach, touching):
    """Face of each place x (k, 3) [m] of the body at the expected end of the step, and the area (k,) [m²] that it shows
    to that face, 0 for a place without a face.

    area: (k, 3) [m²] vector area of the body there; end: (f, 4, 3) corners of the faces; depth: (f,) [m] below which a
    place no longer belongs to a face, unless it is `touching` (k,) since before; reach: distance [m] above it.
    """
    chosen, seen = np.zeros(len(x), int), np.zeros(len(x))
    close = np.zeros(len(x), bool)
    if len(end):
        close = ((x > end.min(axis=(0, 1)) - reach) & (x < end.max(axis=(0, 1)) + reach)).all(axis=1)
    if not close.any():
        return chosen, seen
    frame, count = Frame.from_corners(end), min(NEIGHBOURS, len(end))
    size = np.linalg.norm(end - frame.origin[:, None], axis=2).max()
    near = cKDTree(frame.origin).query(x[close], count, distance_upper_bound=size + reach)[1].reshape(-1, count)
    place, face = np.repeat(np.flatnonzero(close), count), np.minimum(near, len(end) - 1).ravel()
    part = Frame(frame.origin[face], frame.edges[face], frame.dual[face], frame.normal[face])
    at, gap = part.local_coordinates(x[place])
    beside = np.einsum("ma,mai->mi", np.sign(at) * np.maximum(np.abs(at) - 1 - 1e-9, 0.0), part.edges)
    away, shown = np.linalg.norm(beside, axis=1), -np.einsum("mi,mi->m", part.normal, area[place])
    fits = (near.ravel() < len(end)) & (away <= WEDGE * np.abs(gap)) & (gap < reach)
    fits &= ((gap > -depth[face]) | touching[place]) & (shown > FACING * np.linalg.norm(area[place], axis=1))
    fits &= (away <= RIM * np.abs(gap)) | _between(beside.reshape(-1, count, 3), fits.reshape(-1, count)).ravel()
    distance = np.where(fits, np.hypot(gap, away), np.inf).reshape(-1, count)
    best = np.arange(len(distance)) * count + np.argmin(distance, axis=1)
    best = best[fits[best]]
    chosen[place[best]], seen[place[best]] = face[best], shown[best]
    return chosen, seen


def _between(beside, fits):
    """(m, count) bool, whether the way `beside` (m, count, 3) from a face to a place is opposed by that from another
    face: so between two faces, but not past the rim of the soil."""
    product = np.einsum("mai,mbi->mab", beside, beside)
    return ((product < 0) & fits[:, None, :]).any(axis=2)


def crossing(y, body, pose, start, end):
    """Coordinates (m, 2) on their faces where samples y (m, 3) of the body frame go through them, and at the start.

    The body goes from `body` (a BodyState) to `pose`, the corners of the faces from `start` to `end` (m, 4, 3) [m].
    Samples that stay outside anchor where their path ends, samples that start inside where it starts.
    """
    turn = log_so3(pose[1] @ body.rotation.T)
    angle = np.linalg.norm(turn)
    axis = turn / angle if angle > 0 else turn
    arms = y @ body.rotation.T
    across, inwards = np.cross(axis, arms), np.cross(axis, np.cross(axis, arms))

    def seen(fraction):
        partial = fraction[:, None] * angle
        arm = arms + np.sin(partial) * across + (1 - np.cos(partial)) * inwards
        centre = body.position + fraction[:, None] * (pose[0] - body.position)
        return Frame.from_corners(start + fraction[:, None, None] * (end - start)).local_coordinates(centre + arm)

    zero, one = np.zeros(len(y)), np.ones(len(y))
    (origin, before), (_, after) = seen(zero), seen(one)
    outside, inside = np.where(before < 0, 0.0, np.where(after < 0, 0.0, 1.0)), np.where(before < 0, 0.0, 1.0)
    for _ in range(HALVINGS):
        middle = 0.5 * (outside + inside)
        out = seen(middle)[1] >= 0
        outside, inside = np.where(out, middle, outside), np.where(out, inside, middle)
    return seen(inside)[0], origin
