"""How many times contact points cover the surface of a body with their areas: 1 where soil lies on it, more where layers do.

    C(x) = Σ_c a_c K(x - x_c) / Σ_s A_s K(x - x_s)         K(d) = 1 - d²/R²  up to d = R, else 0

| symbol   | meaning                                                                              | unit |
|----------|--------------------------------------------------------------------------------------|------|
| x_c, a_c | closest point of the surface to a contact point, and the area that it stands for     | m, m² |
| x_s, A_s | middle and area of a patch of the surface, where that is inside of the grid          | m, m² |
| R        | radius over which areas are added up: `AROUND` widths of a domain                    | m    |

Patches belong to the body: they and their K do not change. In plane strain they lie in the plane of the section and have
the area of the slice.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix
from scipy.spatial import cKDTree

from hybrid.contact.samples import everywhere

PATCH = 0.5     # widths of a domain across a patch
AROUND = 2.0    # widths of a domain in R
# Share of the surface around a patch that counts at least: a quarter is in the grid where two planes of symmetry meet
LEAST = 0.2
MOST = 5e4      # patches of a large body, each of which has about fifty others around it


@dataclass(frozen=True)
class Cover:
    """s patches of a body's surface. place, normal: (s, 3) in the body frame [m], [-]; area: (s,) [m²]; near: (s, s) K of
    each pair on the same side of the body; tree: of places and normals, those times the width; width: [m] of a domain;
    flat: (k, 3) unit vectors along collapsed axes, body frame."""

    place: np.ndarray
    normal: np.ndarray
    area: np.ndarray
    near: csr_matrix
    tree: cKDTree
    width: float
    flat: np.ndarray

    @classmethod
    def of(cls, surface, width, flat=(), share=1.0):
        """Cover of a ContactSurface for domains of a `width` [m]; flat: as above; share: part of it that lies in the
        slice."""
        flat = np.reshape(flat, (-1, 3))
        width = max(width, np.sqrt(surface.areas.sum() / MOST) / PATCH)
        place, normal, area = everywhere(surface, PATCH * width)
        place, normal, area = _patches(_flattened(place, flat), normal, share * area, PATCH * width)
        return cls(place, normal, area, _kernel(place, normal, AROUND * width), cKDTree(np.hstack([place, width * normal])),
                   width, flat)

    def layers(self, closest_point, normal, area, pose, extent):
        """(m,) C at contact points with closest points and normals (m, 3) [m], in space, and areas (m,) [m²].

        pose: of the body; extent: (3, 2) [m] of the grid along its axes, without limits along those that are collapsed."""
        position, rotation = pose
        closest_point = _flattened((closest_point - position) @ rotation, self.flat)
        _, patch = self.tree.query(np.hstack([closest_point, self.width * normal @ rotation]))
        place = position + self.place @ rotation.T
        inside = ((place >= extent[:, 0]) & (place <= extent[:, 1])).all(axis=1)
        covered = self.near @ np.bincount(patch, area, len(place))
        whole = np.maximum(self.near @ (self.area * inside), LEAST * (self.near @ self.area))
        return (covered / whole)[patch]


def _flattened(y, flat):
    """Places y (m, 3) [m] without their components along unit vectors `flat` (k, 3)."""
    return y - (y @ flat.T) @ flat


def _patches(place, normal, area, size):
    """Places and normals (s, 3) and areas (s,) of patches of a `size` [m], from those (n,) of smaller parts of a surface."""
    key = np.hstack([np.floor(place / size), np.round(normal)]).astype(np.int64)
    _, patch = np.unique(key, axis=0, return_inverse=True)
    patch = patch.ravel()
    sums = np.bincount(patch, area)
    place, normal = (np.stack([np.bincount(patch, area * values) for values in vectors.T], axis=1) / sums[:, None]
                     for vectors in (place, normal))
    return place, normal / np.linalg.norm(normal, axis=1)[:, None], sums


def _kernel(place, normal, radius):
    """Sparse matrix (s, s) of K between places with normals (s, 3) less than a right angle apart."""
    i, j = cKDTree(place).query_pairs(radius, output_type="ndarray").T
    same = np.einsum("ki,ki->k", normal[i], normal[j]) > 0.0
    i, j = i[same], j[same]
    K = 1.0 - ((place[i] - place[j]) ** 2).sum(axis=1) / radius**2
    n = np.arange(len(place))
    row, column = np.concatenate([i, j, n]), np.concatenate([j, i, n])
    return coo_matrix((np.concatenate([K, K, np.ones(len(n))]), (row, column))).tocsr()
