"""Mass of the smooth solid: the mass of its mesh, and of the layers between its facets and the smooth surface.

A patch lies over its facet at x(w) = x_f(w) - q(w), q = Σ w_i w_j c_ij (`hybrid.body.patches`). The points between them
are x_f - s q, 0 <= s <= 1, so that a layer adds

    ∫ (·) (x_v × x_w)·(-q) ds dv dw        (·) = 1, x, x x^T

to volume, first and second moments, negative where the surface is hollow. Neighbours share the curve of their edge, so
layers leave no gaps. With facets of size a the mass of a sphere is of order a² in error without, a⁴ with them.

Equations: FORMULATION (30).
"""

from dataclasses import replace

import numpy as np

from hybrid.body.mass import condensed_mass
from hybrid.body.surface import build_surface

ORDER = 5       # Gauss points along each of v, w, s: exact for polynomials of degree 9


def mass_and_surface(mesh, density):
    """(MassProperties, ContactSurface about the centre of mass) of a TetMesh of uniform `density` [kg/m³].

    GeometryError as from `condensed_mass` and `build_surface`.
    """
    mass = condensed_mass(mesh, density)
    surface = build_surface(mesh.points - mass.centre, mesh.contact, mesh.normals)
    if not len(surface.tree.patches.nodes):
        return mass, surface
    mass = with_layers(mass, surface.tree.patches.nodes, density)
    return mass, build_surface(mesh.points - mass.centre, mesh.contact, mesh.normals)


def with_layers(facets, nodes, density):
    """MassProperties of the smooth solid, given those of its facets and the `nodes` (t, 9, 3) of patches about their
    centre."""
    volume, first, second = layers(nodes)
    mass = facets.mass + density * volume
    offset = density * first / mass
    second = 0.5 * np.trace(facets.inertia) * np.eye(3) - facets.inertia + density * second
    second -= mass * np.outer(offset, offset)
    inertia = np.trace(second) * np.eye(3) - second
    matrix = np.zeros((6, 6))
    matrix[:3, :3], matrix[3:, 3:] = mass * np.eye(3), inertia
    return replace(facets, mass=float(mass), centre=facets.centre + offset, inertia=inertia, matrix=matrix,
                   gravity_load=mass * np.eye(6, 3))


def layers(nodes):
    """Volume [m³], first (3,) [m⁴] and second (3, 3) [m⁵] moments of what lies between facets and patches."""
    x0, d1, d2, c0, c1, c2 = np.moveaxis(nodes[:, [0, 1, 2, 6, 7, 8]], 1, 0)
    at, weights = np.polynomial.legendre.leggauss(ORDER)
    at, weights = 0.5 * (at + 1.0), 0.5 * weights
    volume, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    for v, a in zip(at, weights):
        for share, b in zip(at, weights):
            w, inside = (1.0 - v) * share, a * b * (1.0 - v)    # a square, folded to the triangle
            u = 1.0 - v - w
            q = u * v * c0 + v * w * c1 + w * u * c2
            q_v, q_w = (u - v) * c0 + w * c1 - w * c2, -v * c0 + v * c1 + (u - w) * c2
            for s, c in zip(at, weights):
                x = x0 + v * d1 + w * d2 - s * q
                element = -inside * c * np.einsum("ti,ti->t", np.cross(d1 - s * q_v, d2 - s * q_w), q)
                volume += element.sum()
                first += element @ x
                second += (x * element[:, None]).T @ x
    return volume, first, second
