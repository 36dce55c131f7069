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

from hybrid.body.mass import combined, condensed_mass, point_mass
from hybrid.body.solid import owners
from hybrid.body.surface import build_surface
from hybrid.runtime.errors import GeometryError

ORDER = 5       # Gauss points along each of v, w, s: exact for polynomials of degree 9


def mass_and_surface(mesh, density):
    """(MassProperties, ContactSurface about the centre of mass) of a TetMesh.

    density: [kg/m³], or {name of a physical volume: [kg/m³]} of all its regions. GeometryError as from `condensed_mass`
    and `build_surface`.
    """
    parts = list(_parts(mesh, density))
    mass = combined([condensed_mass(part, own) for part, _, own in parts])
    surface = build_surface(mesh.points - mass.centre, mesh.contact, mesh.normals)
    nodes = surface.tree.patches.nodes
    if not len(nodes):
        return mass, surface
    mass = _with_layers(mass, [(own, layers(nodes[triangles])) for _, triangles, own in parts])
    return mass, build_surface(mesh.points - mass.centre, mesh.contact, mesh.normals)


def _parts(mesh, density):
    """Yields (TetMesh of a part, its contact triangles, density [kg/m³]) of parts of uniform density."""
    if not isinstance(density, dict):
        yield mesh, slice(None), density
        return
    given, found = sorted(density), sorted(mesh.regions)
    if given != found:
        raise GeometryError(f"geometry '{mesh.name}': density names the volumes {', '.join(given)}, but it has "
                            f"{', '.join(found) or 'none with names'}; give the density of each, or one number for all")
    under = mesh.region[owners(mesh)]
    for number, name in enumerate(mesh.regions):
        tets = mesh.tets[mesh.region == number]
        used, tets = np.unique(tets, return_inverse=True)
        part = replace(mesh, points=mesh.points[used], tets=tets.reshape(-1, 4), region=None)
        yield part, under == number, density[name]


def _with_layers(facets, layers_by_density):
    """MassProperties of the smooth solid, given those of its facets and [(density, layers about their centre)]."""
    mass = facets.mass + sum(density * volume for density, (volume, _, _) in layers_by_density)
    offset = sum(density * first for density, (_, first, _) in layers_by_density) / mass
    second = 0.5 * np.trace(facets.inertia) * np.eye(3) - facets.inertia
    second = second + sum(density * part for density, (_, _, part) in layers_by_density)
    second -= mass * np.outer(offset, offset)
    return point_mass(mass, facets.centre + offset, np.trace(second) * np.eye(3) - second)


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
