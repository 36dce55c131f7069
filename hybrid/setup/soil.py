"""The soil of a scene: points, layers, initial stress and the law of all points.

    σ_zz = -(weight above) / area      σ_xx = σ_yy = K0 σ_zz      (FORMULATION (21))

Layers are resolved in `find_strata`; the law of each is made in `hybrid.setup.law`.
"""

from dataclasses import dataclass, replace

import numpy as np

from hybrid.laws.cone import merge
from hybrid.laws.user import made
from hybrid.runtime.comm import anywhere, largest
from hybrid.runtime.errors import SceneError
from hybrid.scene.soil import of_layer
from hybrid.setup.ground import cut_to_ground
from hybrid.setup.law import build_law, coefficient_at_rest, material_values
from hybrid.soil.model import BLEND, Soil
from hybrid.soil.points import at_rest, overburden, overburden_of_columns, tile


@dataclass(frozen=True)
class Stratum:
    """A layer, or the soil outside all layers: law's name, parameters by name, K0, top [m], ids (m,) of its points."""

    name: str
    law: str
    values: dict
    k0: float
    top: float
    points: np.ndarray


def build_soil(scene, grid, loads, law=None):
    """(Soil model, its points at rest), in geostatic equilibrium if the scene wants that. law: of a user."""
    described = scene.soil
    constants, stress, law = lay_out(described, grid, loads.gravity, law)
    points = at_rest(constants, stress, law.strain(stress))
    if scene.time.inertia and not anywhere(stress):
        points.acceleration[:] = loads.on_points(0.0, constants.position)  # no stress carries the weight yet
    soil = Soil(grid, constants, law, basis=described.basis, domain=described.domain, held=described.held,
                fbar=described.fbar, ghost_factor=described.ghost, stray=described.stray,
                allow_detached=scene.time.inertia,
                transfer=described.transfer if scene.time.inertia else "increments",
                blend=BLEND if described.blend is None else described.blend)
    return soil, points


def lay_out(described, grid, gravity, own_law=None):
    """(PointConstants, principal stress at rest (n, 3) [Pa], law) of a scene's soil, as far as the grid reaches.

    gravity (3,) [m/s²]; own_law: function that makes the law of a user. Raises SceneError.
    """
    if (described.material.law == "user") != (own_law is not None):
        raise SceneError("soil.material.law = 'user' and build(scene, law=...) or run(scene, law=...) belong together; "
                         f"but law = {described.material.law!r} and {own_law and 'one' or 'none'} is given")
    lower, upper = soil_box(described, grid)
    constants, top = tile(grid, lower, upper, np.broadcast_to(described.points_per_axis, 3), 1.0), upper[2]
    level = top
    if described.ground is not None:
        constants, level = cut_to_ground(constants, described.ground)
    strata = find_strata(described, constants.position[:, 2], top)
    density, k0 = np.empty(len(constants)), np.empty(len(constants))
    for s in strata:
        density[s.points], k0[s.points] = s.values["density"], s.k0
    constants = replace(constants, mass=density * constants.volume)
    weight_above = overburden if described.ground is None else overburden_of_columns
    vertical = weight_above(constants, np.linalg.norm(gravity))
    constants, stress = initial_stress(described, constants, density, k0, vertical, gravity)
    if own_law is not None:
        law = made(own_law, constants, stress)
    else:
        tops = [np.broadcast_to(level, len(constants))[s.points] if s.top == top else s.top for s in strata]
        laws = [build_law(s, k0[s.points] * vertical[s.points], upper - constants.position[s.points, 2])
                for s, upper in zip(strata, tops)]
        law = laws[0] if len(laws) == 1 else merge(laws, [s.points for s in strata])
    if anywhere(stress):
        _refuse_yielding(law, stress, level - constants.position[:, 2])
    return constants, stress, law


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
            _require_grid_line(key, x, axis, grid.axes[axis])
    return lower, upper


def _require_grid_line(key, x, axis, nodes):
    if len(nodes) == 1:     # a collapsed axis has no lines
        return
    nearest = nodes[np.argmin(np.abs(nodes - x))]
    if abs(nearest - x) > 1e-6 * np.diff(nodes).min():
        name = "xyz"[axis]
        raise SceneError(f"{key} = {x:g}: must be on a grid line, because points fill whole cells, and the nearest "
                         f"line along {name} is at {nearest:.6g} m; set {key} to that, or choose grid.{name}.start and "
                         f"grid.{name}.size so that a line lies at {x:g} m")


def find_strata(described, height, top):
    """Strata of points at `height` (n,) [m]; points in no layer have soil.material. SceneError for an empty layer."""
    strata, free = [], np.ones(len(height), bool)
    for i, layer in enumerate(described.layers):
        upper, lower = top if layer.top is None else layer.top, -np.inf if layer.bottom is None else layer.bottom
        inside = (height < upper) & (height >= lower)
        if not inside.any():
            raise SceneError(f"soil.layer.{i} ({layer.name}) holds no point: z = {lower:g} to {upper:g} m is outside "
                             "the soil, or thinner than a point; move its ends or refine grid.z")
        free &= ~inside
        k0 = described.k0 if layer.k0 is None else layer.k0
        strata.append(_stratum(layer.name, of_layer(described.material, layer), k0, upper, inside))
    if free.any():
        strata.append(_stratum("soil", described.material, described.k0, top, free))
    return strata


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
        raise SceneError(f"soil.geostatic needs gravity along -z, but gravity = {gravity.tolist()}; set "
                         "soil.geostatic = false and turn gravity on by stage.gravity = [0.0, 1.0], or turn the "
                         "scene")
    ratios = np.stack([k0, k0, np.ones_like(k0)], axis=1)
    gradient = (density * np.linalg.norm(gravity))[:, None] * ratios
    return replace(constants, geostatic_gradient=gradient), -vertical[:, None] * ratios


def _refuse_yielding(law, stress, depth):
    """SceneError where the law cannot carry the stress at rest."""
    response = law.respond(law.strain(stress), np.zeros(len(stress)))
    excess = np.abs(response.stress - stress).max(axis=1) - 1e-9 * largest(np.abs(stress))
    p = int(np.argmax(excess))
    if excess[p] > 0:
        shown = ", ".join(f"{value / 1e3:.4g}" for value in stress[p])
        raise SceneError(f"soil.geostatic: the stress at rest at a depth of {depth[p]:.3g} m, ({shown}) kPa along x, y "
                         "and z, is more than the law can carry; set k0 closer to 1 or raise the strength")
