"""Samples of a body's contact surface: its vertices, and points between them on facets larger than the soil's domains.

Every triangle is cut into n² equal ones with edges no longer than a given spacing; the samples are their vertices,
each with a third of the vector area of the triangles around it,

    a_s = Σ A N / 3        Σ_s a_s·f(y_s) ≈ ∫ f·N dA

A sample on an edge belongs to several sides at once. In contact with soil of normal n it represents the area -n·a_s,
the projection of its surroundings on the soil: for a box on flat ground the bottom only, without a share of the walls.

| symbol | field            | shape  | unit |
|--------|------------------|--------|------|
| y_s    | Samples.position | (k, 3) | m    |
| a_s    | Samples.area     | (k, 3) | m²   |
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Samples:
    """Samples in the body frame; triangle (k,): one of the triangles that a sample lies on; weights (k, 3): of that
    triangle's vertices at the sample."""

    position: np.ndarray
    area: np.ndarray
    triangle: np.ndarray
    weights: np.ndarray

    def __len__(self):
        return len(self.position)


def surface_samples(surface, spacing):
    """Samples of a ContactSurface no farther apart than `spacing` [m] along the edges of its triangles."""
    corners = surface.vertices[surface.triangles]
    edges = np.roll(corners, -1, axis=1) - corners
    cuts = np.maximum(1, np.ceil(np.linalg.norm(edges, axis=2).max(axis=1) / spacing - 1e-9)).astype(int)
    area = 0.5 * np.cross(edges[:, 0], edges[:, 1])
    parts = [[] for _ in range(4)]
    for n in np.unique(cuts):
        alike, (weights, shares) = np.flatnonzero(cuts == n), _lattice(n)
        parts[0].append(np.einsum("sk,tki->tsi", weights, corners[alike]).reshape(-1, 3))
        parts[1].append(np.einsum("ti,s->tsi", area[alike], shares).reshape(-1, 3))
        parts[2].append(np.repeat(alike, len(shares)))
        parts[3].append(np.tile(weights, (len(alike), 1)))
    position, area, triangle, weights = map(np.concatenate, parts)
    return _merge(position, area, triangle, weights, surface)


def _lattice(n):
    """Barycentric weights (s, 3) of the vertices of n² equal parts of a triangle, and their shares (s,) of its area."""
    index = [(i, j) for i in range(n + 1) for j in range(n + 1 - i)]
    number = {vertex: s for s, vertex in enumerate(index)}
    shares = np.zeros(len(index))
    for i, j in index:
        for part in (((i, j), (i + 1, j), (i, j + 1)), ((i, j), (i - 1, j), (i, j - 1))):
            if all(vertex in number for vertex in part):
                shares[[number[vertex] for vertex in part]] += 1 / (3 * n * n)
    i, j = np.array(index).T
    return np.stack([n - i - j, i, j], axis=1) / n, shares


def _merge(position, area, triangle, weights, surface):
    """Samples that coincide on edges and vertices become one, with the sum of their vector areas."""
    tolerance = 1e-7 * surface.radius
    _, first, number = np.unique(np.round(position / tolerance), axis=0, return_index=True, return_inverse=True)
    vector_area = np.zeros((len(first), 3))
    np.add.at(vector_area, number.reshape(-1), area)
    return Samples(position[first], vector_area, triangle[first], weights[first])
