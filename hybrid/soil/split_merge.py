"""Selection, concatenation, splitting and merging of points, with all their arrays.

A point can be split along an axis j of its initial domain, and two halves can be merged again:

    x = x_p ± ½ l_j F e_j     v = v_p + C_v (x - x_p)     V0 = V0_p / 2      all else unchanged
    m = Σ m_i      x, v, a, C = Σ m_i (·)_i / m      τ, F, α = Σ V0_i (·)_i / V0      det F V0 = Σ det F_i V0_i

Mass, centre of mass, momentum, volume and the integrals of stress and plastic strain are conserved by construction.
The Kirchhoff stresses of two halves differ by the geostatic gradient, τ = τ_p ± ½ l_j F_zj dτ_rest/dz, so that soil at
rest stays in equilibrium where a cell is split. The elastic strain is computed from the stress. Two points with the
same law and admissible stresses are merged to a point with an admissible stress: the elastic domain is convex.

Merging loses the energy of the relative motion and of the strain difference of the two points.

Equations: FORMULATION (49), (50).
"""

import dataclasses

import numpy as np

from hybrid.runtime.comm import largest
from hybrid.soil.principal import from_principal
from hybrid.state import PointConstants, Points, Population

FLAT = 1e-2      # [-] det of the mean F over the mean det F of two halves, below which the mean F is not used
NEITHER = 1e-12  # [-] change of stress within a point, relative to the largest stress, that is treated as zero


def select(population, ids):
    """Population of the points `ids`, an index array or a mask (n,) bool."""
    def of(item):
        return None if item is None else item[ids]

    return Population(_mapped(of, population.points), _mapped(of, population.constants), population.rows[ids])


def concatenate(*populations, places=None):
    """All populations in one, one after the other unless `places`, an index array for each, say where their points go. An
    array that only some have is zero for the others, and so is the gradient of an algorithmic acceleration that only some
    carry, as after a stage of another scheme."""
    ends = np.cumsum([0, *map(len, populations)])
    places = places or [slice(*pair) for pair in zip(ends, ends[1:])]

    def joined(*arrays):
        shape = max((array.shape[1:] for array in arrays if array is not None), default=None)
        if shape is None:
            return None
        out = np.zeros((ends[-1], *shape), next(array.dtype for array in arrays if array is not None))
        for array, place in zip(arrays, places):
            if array is not None and array.shape[1:] == shape:
                out[place] = array
            elif array is not None:
                out[place, :array.shape[1]] = array
        return out

    return Population(_mapped(joined, *(one.points for one in populations)),
                      _mapped(joined, *(one.constants for one in populations)), joined(*(one.rows for one in populations)))


def _mapped(function, *items):
    names = [field.name for field in dataclasses.fields(items[0])]
    return type(items[0])(**{name: function(*(getattr(item, name) for item in items)) for name in names})


def split(population, axis, law):
    """Population of the two halves of every point along `axis` of its initial domain: n lower, then n upper halves."""
    points, constants = population.points, population.constants
    out = concatenate(population, population)
    sign = np.repeat([-0.5, 0.5], len(population))[:, None]
    step = points.deformation[:, :, axis] * constants.half_width[:, axis, None]
    step = sign * np.concatenate([step, step])
    along = np.zeros(3)
    along[axis] = 1.0
    rates = {"velocity": out.points.velocity, "acceleration": out.points.acceleration,
             "algorithmic": out.points.algorithmic}
    carried = [name for name, rate in rates.items() if rate is not None]
    if out.points.affine is not None:
        for i, name in enumerate(carried):
            rates[name] = rates[name] + np.einsum("nij,nj->ni", out.points.affine[:, i], step)
    at = out.constants
    narrow = 1 - 0.5 * along
    constants = PointConstants(at.position + sign * at.half_width[:, axis, None] * along, at.half_width * narrow,
                               0.5 * at.volume, 0.5 * at.mass, at.geostatic_gradient)
    points = dataclasses.replace(
        out.points, position=out.points.position + step, half_width=out.points.half_width * narrow, **rates)
    out = Population(points, constants, out.rows)
    return out if at.geostatic_gradient is None else _risen(out, step[:, 2], law)


def _risen(population, height, law):
    """Population with the geostatic stress change over heights (n,) [m]; all other stresses are bitwise unchanged."""
    points = population.points
    change = population.constants.geostatic_gradient * height[:, None]
    some = np.flatnonzero(np.abs(change).max(axis=1) > NEITHER * largest(np.abs(points.stress)))
    if len(some) == 0:
        return population
    few = select(population, some)
    stress = _kirchhoff(few.points) + change[some, :, None] * np.eye(3)
    few = _stressed(few, stress, law)
    points = dataclasses.replace(points, stress=points.stress.copy(), b_elastic=points.b_elastic.copy())
    points.stress[some], points.b_elastic[some] = few.points.stress, few.points.b_elastic
    return dataclasses.replace(population, points=points)


def merge(first, second, axis, law, collapsed):
    """Population of merged points, one for each pair of halves along `axis` of the initial domains; collapsed: (3,) bool,
    axes along which nothing deforms."""
    a, b = first.constants, second.constants
    mass, volume = a.mass + b.mass, a.volume + b.volume

    def mean(x, y, weight, total):
        shape = (-1, *[1] * (x.ndim - 1))
        return (weight[0].reshape(shape) * x + weight[1].reshape(shape) * y) / total.reshape(shape)

    def by_mass(x, y):
        return None if x is None else mean(x, y, (a.mass, b.mass), mass)

    def by_volume(x, y):
        return None if x is None else mean(x, y, (a.volume, b.volume), volume)

    p, q = first.points, second.points
    double = np.ones(3)
    double[axis] = 2.0
    constants = PointConstants(
        0.5 * (a.position + b.position), a.half_width * double, volume, mass,
        by_volume(a.geostatic_gradient, b.geostatic_gradient))
    deformation = by_volume(p.deformation, q.deformation)
    deformation = _with_volume(deformation, by_volume(np.linalg.det(p.deformation), np.linalg.det(q.deformation)), collapsed)
    points = Points(
        position=by_mass(p.position, q.position), velocity=by_mass(p.velocity, q.velocity),
        acceleration=by_mass(p.acceleration, q.acceleration), half_width=p.half_width * double, deformation=deformation,
        b_elastic=p.b_elastic, stress=p.stress, plastic_strain=by_volume(p.plastic_strain, q.plastic_strain),
        algorithmic=by_mass(p.algorithmic, q.algorithmic), affine=by_mass(p.affine, q.affine), inactive=p.inactive,
        opened=by_volume(p.opened, q.opened))
    stress = by_volume(_kirchhoff(p), _kirchhoff(q))
    return _stressed(Population(points, constants, by_volume(first.rows, second.rows)), stress, law)


def _with_volume(deformation, ratio, collapsed):
    """F (n, 3, 3) scaled to det F = `ratio` (n,) along the axes that are not `collapsed`. Where det F < FLAT `ratio`,
    as for the mean of two opposite rotations, the result is an isotropic stretch along these axes."""
    volume = np.linalg.det(deformation)
    flat = volume < FLAT * ratio
    deformation, volume = np.where(flat[:, None, None], np.eye(3), deformation), np.where(flat, 1.0, volume)
    scale = (ratio / volume) ** (1 / np.count_nonzero(~collapsed))
    return deformation * np.where(collapsed, 1.0, scale[:, None])[:, :, None]


def _kirchhoff(points):
    return points.stress * np.linalg.det(points.deformation)[:, None, None]


def _stressed(population, stress, law):
    """The population with Kirchhoff stresses (n, 3, 3) [Pa] and the elastic strains that belong to them."""
    points = population.points
    principal, directions = np.linalg.eigh(stress)
    elastic = law.with_rows(population.rows).strain(principal)
    points = dataclasses.replace(
        points, stress=stress / np.linalg.det(points.deformation)[:, None, None],
        b_elastic=from_principal(np.exp(2 * elastic), np.ascontiguousarray(directions)))
    return dataclasses.replace(population, points=points)
