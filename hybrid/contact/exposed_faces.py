"""Faces of the points' domains at which the soil ends, near one body, and the samples of the body assigned to them.

The four corners x_a of a face are material points carried by the grid (contact/corners.py), and the face is the plane
that fits them,

    o = Σ x_a / 4     e_α = Σ s_αa x_a / 4,  s_αa = ±1     n = e_1 × e_2 / |e_1 × e_2|
    x = o + ξ^α e_α + g n                                  |ξ^α| <= 1 on the face

A face is exposed if the point half a domain beyond it lies in no other domain, nor beyond a face of the grid that holds
the soil. A sample is assigned to one face for the whole step: of the faces that point against the body's surface there,
the nearest one whose extent |ξ^α| <= 1 contains the sample at the end of the predicted motion. Where the soil's surface
bends, the extents of neighbouring faces leave a wedge between them; there an extent grows with the distance from its
face. As in contact/first_contact.py, a contact that closes in this step has its anchor where the predicted path crosses
the face.

Equations: FORMULATION (44).
"""

from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.spatial import cKDTree

from hybrid.body.attitude import log_so3
from hybrid.contact.corners import SIGNS

COVER = 1.2          # half-widths: size of a domain where it covers a face; strained domains do not tile any more
FACING = 0.1         # smallest cosine between the normal of the soil and the one into the body
WEDGE = 0.5          # rad between neighbouring faces, up to which a sample in their wedge is assigned to one of them
RIM = 0.01           # rad by which a face at the rim of the soil may tilt before a sample above the rim is unassigned
NEIGHBOURS = 6       # faces or domains checked for each sample
HALVINGS = 12        # bisections of the path, as for corners
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
        """Coordinates (m, 2) ξ^α and gap (m,) [m] of points x (m, 3) [m], one for each face."""
        d = x - self.origin
        return np.einsum("mai,mi->ma", self.dual, d), np.einsum("mi,mi->m", self.normal, d)

    def select(self, index):
        """Frame of some of the faces, or of faces repeated."""
        return Frame(self.origin[index], self.edges[index], self.dual[index], self.normal[index])


def exposed_faces(position, half, grid, corners):
    """Corners (f, 4), as indices into `corners`, and points (f,) of the exposed faces all of whose corners are among
    them. position, half: (n, 3) [m] of the domains."""
    point = np.unique(corners.id // 8)
    face = np.tile(np.arange(6), len(point))
    point = np.repeat(point, 6)
    wanted = 8 * point[:, None] + LAYOUT[face]
    found = np.minimum(np.searchsorted(corners.id, wanted), max(len(corners) - 1, 0))
    complete = (corners.id[found] == wanted).all(axis=1) if len(corners) else np.zeros(0, bool)
    point, face, found = point[complete], face[complete], found[complete]
    beyond = position[point] + 1.5 * half[point] * NORMALS[face]
    exposed = ~_covered(beyond, position, half, grid, point)
    return found[exposed], point[exposed]


def _covered(x, position, half, grid, point):
    """(m,) bool, whether x (m, 3), beyond faces of `point` (m,), lies in another domain or outside a face of the grid
    that holds the soil."""
    lower, upper = grid.extent.T
    covered = ((x < lower) & grid.closed[:, 0]).any(axis=1) | ((x > upper) & grid.closed[:, 1]).any(axis=1)
    if not len(x):
        return covered
    margin = 4 * half[point].max()
    candidates = np.flatnonzero(_in_box(position, x.min(axis=0) - margin, x.max(axis=0) + margin))
    count = min(NEIGHBOURS, len(candidates))
    neighbour = candidates[cKDTree(position[candidates]).query(x, count)[1].reshape(len(x), count)]
    inside = (np.abs(x[:, None] - position[neighbour]) <= COVER * half[neighbour]).all(axis=2)
    return covered | (inside & (neighbour != point[:, None])).any(axis=1)


@njit(cache=True)
def _in_box(position, lower, upper):
    """(n,) bool, in one pass over all points."""
    within = np.empty(len(position), np.bool_)
    for p in range(len(position)):
        within[p] = (lower[0] < position[p, 0] < upper[0] and lower[1] < position[p, 1] < upper[1]
                     and lower[2] < position[p, 2] < upper[2])
    return within


def assign(x, area, end, depth, reach, touching):
    """Face (k,) of each sample at x (k, 3) [m], the predicted end of the step, and the area (k,) [m²] of the sample
    that faces the soil there, 0 for a sample without a face.

    area: (k, 3) [m²] vector area of the samples; end: (f, 4, 3) [m] corners of the faces; depth: (f,) [m] below a face
    beyond which a sample is no longer assigned to it, unless `touching` (k,) already; reach: the limit [m] above it.
    """
    assigned, facing_area = np.zeros(len(x), int), np.zeros(len(x))
    close = np.zeros(len(x), bool)
    if len(end):
        close = ((x > end.min(axis=(0, 1)) - reach) & (x < end.max(axis=(0, 1)) + reach)).all(axis=1)
    if not close.any():
        return assigned, facing_area
    frame, count = Frame.from_corners(end), min(NEIGHBOURS, len(end))
    size = np.linalg.norm(end - frame.origin[:, None], axis=2).max()
    neighbour = cKDTree(frame.origin).query(x[close], count, distance_upper_bound=size + reach)[1].ravel()
    sample, face = np.repeat(np.flatnonzero(close), count), np.minimum(neighbour, len(end) - 1)
    part = frame.select(face)
    xi, gap = part.local_coordinates(x[sample])
    # vector from the rim of the face to the foot of the sample on its plane, 0 within the face
    beside = np.einsum("ma,mai->mi", np.sign(xi) * np.maximum(np.abs(xi) - 1 - 1e-9, 0.0), part.edges)
    away, facing = np.linalg.norm(beside, axis=1), -np.einsum("mi,mi->m", part.normal, area[sample])
    fits = (neighbour < len(end)) & (away <= WEDGE * np.abs(gap)) & (gap < reach)
    fits &= ((gap > -depth[face]) | touching[sample]) & (facing > FACING * np.linalg.norm(area[sample], axis=1))
    fits &= (away <= RIM * np.abs(gap)) | _in_wedge(beside.reshape(-1, count, 3), fits.reshape(-1, count)).ravel()
    distance = np.where(fits, np.hypot(gap, away), np.inf).reshape(-1, count)
    best = np.arange(len(distance)) * count + np.argmin(distance, axis=1)
    best = best[fits[best]]
    assigned[sample[best]], facing_area[sample[best]] = face[best], facing[best]
    return assigned, facing_area


def _in_wedge(beside, fits):
    """(m, count) bool, whether the vector `beside` (m, count, 3) from a face to a sample is opposed by that from
    another face that fits: the sample is then between two faces, not past the rim of the soil."""
    product = np.einsum("mai,mbi->mab", beside, beside)
    return ((product < 0) & fits[:, None, :]).any(axis=2)


def crossing(y, body, pose, start, end):
    """Coordinates (m, 2) on their faces where samples y (m, 3) of the body frame cross them, and at the start.

    The body moves from `body` (a BodyState) to `pose`, the corners of the faces from `start` to `end` (m, 4, 3) [m].
    The first result is taken at the end of the path for samples that stay outside, and at its start for samples that
    start inside.
    """
    turn = log_so3(pose[1] @ body.rotation.T)
    angle = np.linalg.norm(turn)
    axis = turn / angle if angle > 0 else turn
    arms = y @ body.rotation.T
    across, inwards = np.cross(axis, arms), np.cross(axis, np.cross(axis, arms))

    def coordinates(fraction):
        partial = fraction[:, None] * angle
        arm = arms + np.sin(partial) * across + (1 - np.cos(partial)) * inwards
        centre = body.position + fraction[:, None] * (pose[0] - body.position)
        frame = Frame.from_corners(start + fraction[:, None, None] * (end - start))
        return frame.local_coordinates(centre + arm)

    (origin, gap_start), (_, gap_end) = coordinates(np.zeros(len(y))), coordinates(np.ones(len(y)))
    outside = np.where(gap_start < 0, 0.0, np.where(gap_end < 0, 0.0, 1.0))
    inside = np.where(gap_start < 0, 0.0, 1.0)
    for _ in range(HALVINGS):
        middle = 0.5 * (outside + inside)
        is_outside = coordinates(middle)[1] >= 0
        outside, inside = np.where(is_outside, middle, outside), np.where(is_outside, inside, middle)
    return coordinates(inside)[0], origin
