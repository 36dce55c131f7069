"""Parts of a body's surface: the named physical surfaces of its geometry, whose contact forces are reported apart.

A contact point belongs to the part that the closest triangle is in, so that the forces of the parts add up to that of the
body. Triangles between two faces whose common edge is rounded off (`hybrid.body.rounded`) belong to the nearer face.

| symbol | meaning                                                         | in the code         | shape  | unit |
|--------|-----------------------------------------------------------------|---------------------|--------|------|
| F_k    | force of the soil on part k, Σ of the contact points on it      | `forces`            | (p, 3) | N    |
| A_k    | area of the part                                                | SurfaceParts.area   | (p,)   | m²   |
| A_kd   | area of the part as seen against the direction d, ∫ max(0, n·d) | SurfaceParts.across | -      | m²   |
"""

from dataclasses import dataclass

import numpy as np

from hybrid.body.closest import closest
from hybrid.runtime.comm import total

GAUSS = np.array([[4.0, 1.0, 1.0], [1.0, 4.0, 1.0], [1.0, 1.0, 4.0]]) / 6.0    # barycentric; exact for quadratic functions


@dataclass(frozen=True)
class SurfaceParts:
    """names of p parts; part (t,): number of that of each triangle of the surface in contact; elements: of each part vector
    areas n dA (k, 3) [m²], body frame, of what is modelled."""

    names: tuple[str, ...]
    part: np.ndarray
    elements: tuple[np.ndarray, ...]

    @property
    def area(self):
        """(p,) [m²]."""
        return np.array([np.linalg.norm(own, axis=1).sum() for own in self.elements])

    def across(self, direction):
        """Area (p,) [m²] of each part seen against a `direction` (3,), a unit vector of the body frame."""
        return np.array([np.maximum(0.0, own @ direction).sum() for own in self.elements])

    def forces(self, contact):
        """{name: force (3,) [N]} of the soil on each part, in a PointContact."""
        part = self.part[contact.triangle]
        return {name: total(contact.force[part == k]) for k, name in enumerate(self.names)}


def surface_parts(mesh, outline, surface, along=(), share=1.0):
    """SurfaceParts of a TetMesh, None if it names none.

    outline: ContactSurface of all of its contact triangles; surface: the one in contact with soil; along: unit vectors (3,)
    of collapsed axes in the body frame; share: of a prism along these that lies in the slice.
    """
    if not mesh.parts:
        return None
    elements = share * vector_areas(outline)
    ends = np.any([np.abs(outline.normals @ axis) > 0.5 for axis in along], axis=0) & np.ones(len(mesh.part), bool)
    of_parts = tuple(elements[(mesh.part == k) & ~ends].reshape(-1, 3) for k in range(len(mesh.parts)))
    if surface is outline:
        return SurfaceParts(mesh.parts, mesh.part, of_parts)
    middle = surface.vertices[surface.triangles].mean(axis=1)
    nearest = [closest(tuple(point), np.inf, outline.tree)[0] for point in middle]
    return SurfaceParts(mesh.parts, mesh.part[nearest], of_parts)


def vector_areas(surface):
    """n dA (t, 3, 3) [m²] at three places of each triangle of a surface, on its curved patches where it has any."""
    corners = surface.vertices[surface.triangles]
    d1, d2 = (np.repeat(corners[:, None, i] - corners[:, None, 0], 3, axis=1) for i in (1, 2))
    if len(surface.tree.patches.nodes):
        c0, c1, c2 = (surface.tree.patches.nodes[:, None, i] for i in (6, 7, 8))
        u, v, w = (GAUSS[None, :, i, None] for i in range(3))
        d1 = d1 - ((u - v) * c0 + w * c1 - w * c2)
        d2 = d2 - (-v * c0 + v * c1 + (u - w) * c2)
    return np.cross(d1, d2) / 6.0
