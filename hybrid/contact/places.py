"""Places on the domain of a point at which contact is evaluated, and the area of the soil's surface that each represents.

faces    k x k places on each face of the domain, the midpoints of equal rectangles. Their stiffness is that of the
         pressure p_f E g on the part of the soil's surface that looks at the body,

             ε_N = p_f E a max(0, -n·N)          a = area of the face / k²

         with n the outward normal of the face and N that of the body there: a n·N is the area projected along N, so a
         surface made of steps has the area of the surface that it approximates. Of two faces that coincide between
         domains one looks at the body; as deep as the body overlaps the soil they add a part of the order of
         overlap/width, so no test is needed of which faces are exposed.
corners  the eight corners of the domain, ε_N = p_f E V0^(2/3) / 4: the published method. Under a flat face four domains
         meet at each site of the lattice of points, so each corner has a quarter of the stiffness of a point.

A contact patch of a body with radius of curvature r that overlaps by δ is sqrt(2 r δ) wide. Corners half a cell apart do
not resolve it: a sphere rolls on them as on a bed of nails (demos/random).

Equations: FORMULATION (39).
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

BLOCK = 4           # places along a block of a face
TURN = 0.5          # by which the normal of a body may turn within half a block: sine
CORNER_SHARE = 0.25  # of a point's contact stiffness, per corner
# Cells around a body in which places are followed. A quarter of one: the strain of the soil there hardly moves its
# surface, and the places followed are a quarter of those within a cell. Held soil is not strained.
FACE_REACH, HELD_REACH = 0.25, 0.0625


@dataclass(frozen=True)
class Places:
    """Places on a domain, in groups: blocks of its faces, or all corners as one group.

    offset: (g, s, 3) of s places in g groups, in half-widths of the domain; normal: (g, 3) outward, 0 for corners;
    axis: (g,) normal to the face, -1 for corners; share: of the area of a face that belongs to each place [-]
    reach: distance from the body, in cells, from which a place is followed as a material point
    """

    offset: np.ndarray
    normal: np.ndarray
    axis: np.ndarray
    share: float
    reach: float

    def __len__(self):
        return self.offset.shape[0] * self.offset.shape[1]

    @property
    def at_corners(self):
        """Whether these are the corners of the published method."""
        return bool(self.axis[0] < 0)

    @property
    def per_edge(self):
        """Number of places along the edge of a face, 1 for corners."""
        return 1 if self.at_corners else round(self.share ** (-1 / max(1, len(set(self.axis)) - 1)))

    @property
    def centre(self):
        """(g, 3) middle of each group, in half-widths."""
        return self.offset.mean(axis=1)

    @property
    def extent(self):
        """(g, 3) largest distance of a place from the middle of its group, in half-widths."""
        return np.abs(self.offset - self.centre[:, None]).max(axis=1)

    def group_of(self, number):
        """(m,) group of each place `number` (m,)."""
        return number // self.offset.shape[1]

    def group_may_face(self, group, normal):
        """(m,) bool, whether a place of `group` (m,) may look at a body whose normal at its middle is (m, 3)."""
        return -np.einsum("mi,mi->m", self.normal[group], normal) > -TURN

    @property
    def flat(self):
        """(g s, 3) offsets by number of the place."""
        return self.offset.reshape(-1, 3)

    def area(self, number, half, volume):
        """Area (m,) [m²] of places `number` (m,) on domains of half-widths (m, 3) [m] and initial volume (m,) [m³]."""
        group = self.group_of(number)
        if self.at_corners:
            return self.share * volume ** (2 / 3)
        across = np.where(np.arange(3) == self.axis[group, None], 1.0, 2 * half)
        return self.share * across.prod(axis=1)

    def up(self, number):
        """(m,) bool, whether places `number` (m,) are on the upper face."""
        return self.normal[self.group_of(number), 2] > 0.0

    def projected_share(self, number, normal):
        """max(0, -n·N) (m,) [-] of places `number` (m,) and the outward normals N (m, 3) of the body there; 1 for
        corners."""
        if self.at_corners:
            return np.ones(len(number))
        own = self.normal[self.group_of(number)]
        return np.maximum(0.0, -np.einsum("mi,mi->m", own, normal))


def corners():
    """Places at the eight corners; bits 4, 2, 1 of their numbers are set at the upper end along x, y, z."""
    signs = np.array([[[1.0 if corner & bit else -1.0 for bit in (4, 2, 1)] for corner in range(8)]])
    return Places(signs, np.zeros((1, 3)), np.array([-1]), CORNER_SHARE, 1.0)


def faces(k, collapsed=(False, False, False), reach=FACE_REACH):
    """k x k places on every face that is not normal to a `collapsed` axis, in blocks of BLOCK x BLOCK; along such an
    axis there is one. k: a multiple of BLOCK."""
    offset, normal, axes = [], [], []
    for axis in np.flatnonzero(~np.asarray(collapsed)):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side in (-1.0, 1.0):
            for along_u, along_v in product(*(_blocks(1 if collapsed[i] else k) for i in (u, v))):
                place = np.zeros((len(along_u), len(along_v), 3))
                place[..., axis], place[..., u], place[..., v] = side, along_u[:, None], along_v
                offset.append(place.reshape(-1, 3))
                normal.append(side * np.eye(3)[axis])
                axes.append(axis)
    share = k ** (np.count_nonzero(collapsed) - 2.0)    # along a face of one free axis, none, there is one place
    return Places(np.array(offset), np.array(normal), np.array(axes), share, reach)


def _blocks(k):
    """Offsets in half-widths of k places along an axis, in blocks."""
    return ((2 * np.arange(k) + 1) / k - 1).reshape(-1, min(k, BLOCK))
