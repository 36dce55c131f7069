"""The soil of a scene: points, layers, initial stress and the law of all points.

    σ_zz = -(weight above) / area      σ_xx = σ_yy = K0 σ_zz      (FORMULATION (21))

Layers are resolved in `find_strata`; the law of each is made in `hybrid.setup.law`.
"""

from dataclasses import dataclass, replace

import numpy as np

from hybrid.laws.cone import merge
from hybrid.laws.sand import material_values
from hybrid.laws.user import made, refuse_unlike
from hybrid.runtime import ranks
from hybrid.runtime.comm import anywhere, largest, maximum
from hybrid.runtime.errors import SceneError
from hybrid.scene.ground import heights
from hybrid.scene.soil import of_layer, within
from hybrid.setup.ground import cut_to_ground
from hybrid.setup.lattice import Lattice
from hybrid.setup.law import build_law, coefficient_at_rest
from hybrid.soil.model import Soil
from hybrid.soil.points import at_rest, overburden, overburden_of_columns
from hybrid.state import PointConstants
from hybrid.step import processes

OF_POINTS = "position", "half_width", "volume", "mass"
TINY = 1e-9     # [Pa]
MOST_K0 = 35.0  # more than the passive coefficient of 70 degrees


@dataclass(frozen=True)
class Stratum:
    """A layer, or the soil outside all layers: law's name, parameters by name, K0, top [m], ids (m,) of its points."""

    name: str
    law: str
    values: dict
    k0: float
    top: float
    points: np.ndarray


def build_soil(scene, grid, loads, law):
    """(Soil model, its points at rest), in geostatic equilibrium if the scene wants that. law: of a user. Several
    processes each make their block of the grid and the points in its cells."""
    described, cells = scene.soil, None
    if ranks.started() > 1:
        grid, cells = processes.first_block(grid, count_points(described, grid))
    constants, stress, law = lay_out(described, grid, loads.gravity, law, cells)
    points = at_rest(constants, stress, law.strain(stress))
    if scene.time.inertia and not anywhere(stress):
        points.acceleration[:] = loads.on_points(0.0, constants.position)  # no stress carries the weight yet
    soil = Soil(grid, constants, law, basis=described.basis, domain=described.domain, held=described.held,
                fbar=described.fbar, ghost_factor=described.ghost, stray=described.stray,
                allow_detached=scene.time.inertia, opens=scene.time.inertia,
                transfer=described.transfer if scene.time.inertia else "increments",
                heights=_given_heights(described, grid))
    return soil, points


def _given_heights(described, grid):
    """(Heights of the ground, top [m]) that contact follows, None where the scene gives no heights."""
    if described.ground is None or described.basis != "gimp":
        return None
    return heights(described.ground), soil_box(described, grid)[1][2]


def count_points(described, grid):
    """Number of points (a, b, c) in each cell of a whole Grid, none of which are made. Raises SceneError."""
    return Lattice.of(described, grid, *soil_box(described, grid)).counts(grid.cell_counts)


def lay_out(described, grid, gravity, own_law=None, cells=None):
    """(PointConstants, principal stress at rest (n, 3) [Pa], law) of a scene's soil, as far as the grid reaches.

    gravity (3,) [m/s²]; own_law: function that makes the law of a user; cells: (a, b, c) bool, cells of the whole grid whose
    points this process of several makes, None: one makes all. Raises SceneError.
    """
    if (described.material.law == "user") != (own_law is not None):
        raise SceneError("soil.material.law = 'user' and build(scene, law=...) or run(scene, law=...) belong together; "
                         f"but law = {described.material.law!r} and {own_law and 'one' or 'none'} is given")
    lower, upper = soil_box(described, grid)
    lattice, top = Lattice.of(described, grid, lower, upper), upper[2]
    level, present = top, occupied_layers(described, lattice.heights(), top)
    place, constants, vertical = _points_of(described, lattice, cells, top, present, np.linalg.norm(gravity))
    if cells is not None:
        assert len(place) < lattice.kept.sum(), "one process holds all points"
        constants = replace(constants, number=lattice.numbers(place))
    if described.ground is not None:
        level = lattice.levels[place // lattice.height]
    strata = find_strata(described, constants.position[:, 2], top, present)
    constants, stress = initial_stress(described, constants, *_density_and_k0(strata, len(constants)), vertical, gravity)

    def law_of_points():
        if own_law is not None:
            law = made(own_law, constants, stress)
            if cells is not None:
                refuse_unlike(law)
            return law
        tops = [np.broadcast_to(level, len(constants))[s.points] if s.top == top else s.top for s in strata]
        laws = [build_law(s, s.k0 * vertical[s.points], upper - constants.position[s.points, 2])
                for s, upper in zip(strata, tops)]
        return laws[0] if len(laws) == 1 else merge(laws, [s.points for s in strata])

    law = ranks.together(law_of_points)
    law.hardens = anywhere(law.hardens)     # points come from other processes
    if anywhere(stress):
        _refuse_yielding(law, stress, level - constants.position[:, 2], strata)
    return constants, stress, law


def _points_of(described, lattice, cells, top, present, gravity):
    """(Places (n,) in the lattice, PointConstants, vertical stress (n,) [Pa] compression positive) of the points in `cells`.

    They are made by whole columns, for the weight above: as many points at a time as there are in these cells, and a column.
    """
    weight_above = overburden if described.ground is None else overburden_of_columns
    chosen, found = lattice.chosen(cells), []
    for place in lattice.pieces(chosen):
        constants = lattice.points(place)
        if described.ground is not None:
            constants = cut_to_ground(constants, lattice.levels[place // lattice.height])
        strata = find_strata(described, constants.position[:, 2], top, present)
        density, _ = _density_and_k0(strata, len(constants))
        constants = replace(constants, mass=density * constants.volume)
        vertical = weight_above(constants, gravity)
        mine = slice(None) if cells is None else np.isin(place, chosen, assume_unique=True)
        found.append((place[mine], *(getattr(constants, name)[mine] for name in OF_POINTS), vertical[mine]))
    place, *of_points, vertical = (np.concatenate(each) for each in zip(*found))
    return place, PointConstants(*of_points), vertical


def _density_and_k0(strata, n):
    """Density (n,) [kg/m³] and K0 (n,) of the points of strata."""
    density, k0 = np.empty(n), np.empty(n)
    for s in strata:
        density[s.points], k0[s.points] = s.values["density"], s.k0
    return density, k0


def soil_box(described, grid):
    """Lower and upper corner (3,) [m] of the soil: that of the scene, cut by the grid. Raises SceneError.

    An end that lies inside the grid has to be on a grid line, because points fill whole cells.
    """
    lower, upper = grid.extent[:, 0].copy(), grid.extent[:, 1].copy()
    given = [(0, i, f"soil.lower[{i}]", x) for i, x in enumerate(described.lower or ())]
    given += [(1, i, f"soil.upper[{i}]", x) for i, x in enumerate(described.upper or ())]
    if described.top is not None:
        given = [end for end in given if end[:2] != (1, 2)] + [(1, 2, "soil.top", described.top)]
    for side, axis, key, x in given:
        if side == 0:
            lower[axis] = max(lower[axis], x)
        else:
            upper[axis] = min(upper[axis], x) if key != "soil.top" else x
        if grid.extent[axis, 0] < x < grid.extent[axis, 1]:
            _require_grid_line(key, x, axis, grid.lines[axis])
    for axis in np.flatnonzero(lower >= upper):
        name, (start, end) = "xyz"[axis], grid.extent[axis]
        raise SceneError(f"grid.{name}.window: no soil lies between the ends of the window, {start:g} and {end:g} m; let "
                         "the body start and stay in the soil, or widen the window")
    return lower, upper


def _require_grid_line(key, x, axis, nodes):
    if len(nodes) == 1:     # a collapsed axis has no lines
        return
    nearest, sizes = nodes[np.argmin(np.abs(nodes - x))], np.diff(nodes)
    if abs(nearest - x) > 1e-6 * sizes.min():
        name = "xyz"[axis]
        graded = "" if sizes.max() < 1.01 * sizes.min() else f", with whole cells between the ends of grid.{name}.fine"
        raise SceneError(f"{key} = {x:g}: must be on a grid line, because points fill whole cells, and the nearest "
                         f"line along {name} is at {nearest:.6g} m; set {key} to that, or choose grid.{name}.start and "
                         f"grid.{name}.size so that a line lies at {x:g} m{graded}")


def occupied_layers(described, heights, top):
    """[whether each layer has points, and whether soil outside all layers has] of all points, at `heights`, arrays [m]."""
    found = np.zeros(len(described.layers) + 1, bool)
    for height in heights:
        inside = [_inside(layer, height, top) for layer in described.layers]
        found |= [one.any() for one in (*inside, ~np.any(inside, axis=0) if inside else np.ones_like(height, bool))]
    return found.tolist()


def find_strata(described, height, top, present=None):
    """Strata of points at `height` (n,) [m]; points in no layer have soil.material. SceneError for an empty layer.

    present: of all points (`occupied_layers`), None where these are all; all processes have the same strata.
    """
    strata, free = [], np.ones(len(height), bool)
    present = occupied_layers(described, [height], top) if present is None else present
    for i, layer in enumerate(described.layers):
        inside = _inside(layer, height, top)
        if not present[i]:
            lower, upper = within(layer, -np.inf, top)
            raise SceneError(f"soil.layer.{i} ({layer.name}) holds no point: z = {lower:g} to {upper:g} m is outside "
                             "the soil, or thinner than a point; move its ends or refine grid.z")
        free &= ~inside
        k0 = described.k0 if layer.k0 is None else layer.k0
        strata.append(_stratum(layer.name, of_layer(described.material, layer), k0,
                               within(layer, -np.inf, top)[1], inside))
    if present[-1]:
        strata.append(_stratum("soil", described.material, described.k0, top, free))
    return strata


def _inside(layer, height, top):
    lower, upper = within(layer, -np.inf, top)
    return (height < upper) & (height >= lower)


def _stratum(name, material, k0, top, inside):
    values = material_values(material)
    k0 = coefficient_at_rest(material.law, values) if k0 is None else k0
    return Stratum(name, material.law, values, k0, top, np.flatnonzero(inside))


def initial_stress(described, constants, density, k0, vertical, gravity):
    """(PointConstants with their geostatic gradient, principal stress (n, 3) [Pa]); zero stress without `geostatic`.

    density, k0, vertical: (n,) of the points; vertical [Pa] is compression positive. Raises SceneError.
    """
    if described.held or not described.geostatic:
        return constants, np.zeros((len(constants), 3))
    if np.any(gravity[:2] != 0.0) or gravity[2] > 0.0:
        raise SceneError(f"soil.geostatic needs gravity along -z, but gravity = {gravity.tolist()}; z points up: write "
                         f"gravity = [0.0, 0.0, -{np.linalg.norm(gravity):.4g}], or, if gravity is to act like that, "
                         "turn the scene, or set soil.geostatic = false and turn gravity on by stage.gravity = [0.0, "
                         "1.0]")
    ratios = np.stack([k0, k0, np.ones_like(k0)], axis=1)
    gradient = (density * np.linalg.norm(gravity))[:, None] * ratios
    return replace(constants, geostatic_gradient=gradient), -vertical[:, None] * ratios


def _refuse_yielding(law, stress, depth, strata):
    """SceneError where the law cannot carry the stress at rest, about the point where it misses most, or has none there."""
    response = law.respond(law.strain(stress), np.zeros(len(stress)))
    excess = np.abs(response.stress - stress).max(axis=1) - 1e-9 * largest(np.abs(stress))
    excess[~np.isfinite(excess) | (False if response.failed is None else response.failed)] = np.inf
    worst = maximum(excess)

    def refuse():
        p = int(np.argmax(excess)) if len(excess) else 0
        if len(excess) and excess[p] == worst:
            shown = ", ".join(f"{value / 1e3:.4g}" for value in stress[p])
            at = f"soil.geostatic: the stress at rest at a depth of {depth[p]:.3g} m, ({shown}) kPa along x, y and z, "
            if np.isinf(worst):
                raise SceneError(f"{at}has no finite response of the law there; correct the law, or set "
                                 "soil.geostatic = false for soil that begins without stress")
            raise SceneError(f"{at}is more than the law can carry; {_remedy(law, stress, strata)}")

    if worst > 0:
        ranks.together(refuse)


def _remedy(law, stress, strata):
    """What makes a law carry a stress (n, 3) [Pa] at rest: the K0 nearest to the one given that does, to two digits, a law
    that carries the one given, or another strength."""
    given = stress[:, :2] / np.minimum(stress[:, 2:], -TINY)
    largest_k0 = given.max(initial=0.0)     # of this process's own points: it alone refuses
    passive = largest_k0 > 1.0
    highest = np.floor(100 * min(largest_k0, MOST_K0)) / 100
    for k0 in np.arange(highest, 0.995, -0.01) if passive else np.arange(0.01, 1.005, 0.01):
        trial = (np.maximum if passive else np.minimum)(stress, np.array([k0, k0, 1.0]) * stress[:, 2:])
        carried = law.respond(law.strain(trial), np.zeros(len(trial))).stress
        if np.abs(carried - trial).max(initial=0.0) <= 1e-9 * np.abs(trial).max(initial=0.0):
            return (f"set soil.k0 to {'at most' if passive else 'at least'} {k0:.2f}, "
                    f"{_law_that_carries(given, strata)}or raise the strength")
    return "raise the strength"


def _law_that_carries(k0, strata):
    """The law of all its sections instead of a circular cone, where that bears each of K0, which the cone does not."""
    cones = [s.values["friction_angle"] for s in strata if s.law == "drucker-prager"]
    active = np.tan(np.radians(45.0 - 0.5 * min(cones, default=0.0))) ** 2
    carried = cones and k0.min(initial=1.0) >= active and k0.max(initial=1.0) <= 1.0 / active
    return 'or law = "mohr-coulomb", which carries the one given, ' if carried else ""
