"""Round bodies that rest on deforming soil and feel the lattice of its cells.

Soil gives way most under a node and least in the middle of a cell, so a sphere lies lower over a node and is drawn there.
The force is the slope of an energy: a sphere that is put down at rest on level ground rolls to and fro within a cell,
without gaining energy, as a marble in a tray of dents. A sphere held on level elastic ground without friction, at six
random places, each of a/h and a/r, a the radius of contact, h the cell and r the radius of the sphere, has a tangential
force of at most

| a/h                 | 0.18  | 0.27 | 0.37       | 0.50 | 0.67 | 0.73 | 1.0  | 1.34 | clay: 0.82 | 1.64 |
|---------------------|-------|------|------------|------|------|------|------|------|------------|------|
| a/r                 | 0.065 | 0.13 | 0.065 0.13 | 0.13 | 0.065 | 0.13 | 0.13 | 0.13 | 0.29      | 0.29 |
| of the weight [%]   | 0.4   | 1.6  | 1.0   1.6  | 3.4  | 1.6  | 3.1  | 2.2  | 0.5  | 9.0        | 1.5  |

which is FORCE(a/h) a/r. Cells that resolve the contact, and soil so stiff that there is hardly any, feel nothing of it.
"""

import numpy as np

from hybrid.body.guides import forces_of
from hybrid.body.paths import travel_along
from hybrid.body.rigid import FREEDOMS
from hybrid.body.symmetry import copies
from hybrid.monitors.limits.materials import CLAY, material_at
from hybrid.monitors.limits.shape import is_round
from hybrid.monitors.limits.start import initial_pose, initial_vertices, top_of
from hybrid.runtime.comm import maximum

# (a/h, tangential force over the weight times r/a)
FORCE = ((0.0, 0.0), (0.18, 0.065), (0.37, 0.15), (0.5, 0.26), (0.75, 0.26), (1.0, 0.17), (1.34, 0.05))
LIMIT = 0.01        # of the weight
RESOLVED = 1.34     # cells in the radius of contact, from which on the force is small
BEARING = 6.0       # pressure under a round body that has sunk into clay, over its strength
# Cylinder of 1 m towed over clay under 17.7 kN/m, s_u = 10 kPa, by its diameter: 60, 105, 115 mm deep, 9.7, 12.3, 12.9 kN/m
# with 3.4, 5.5, 6.9 cells on the width that a strip would need
STRIP, CHORD, BARELY = 5.14, 6.5, 0.5


def rolls_on_lattice(scene, model):
    """Round bodies at rest that are free to roll on level ground whose cells do not resolve their contact."""
    soil, gravity = model.soil, np.asarray(scene.gravity)
    if soil.held or scene.soil.ground is not None or not gravity[2] or np.any(gravity[:2]):
        return
    material = material_at(scene, soil, top_of(soil))
    if material.law not in ("hencky", CLAY):
        return
    for described, body in zip(scene.bodies, model.bodies):
        distance = np.linalg.norm(body.surface.vertices, axis=1)
        rolls = is_round(body.outline, distance) and _rests(described, body) and _rolls(body)
        if body.name in scene.joined or not rolls:
            continue
        radius, cell = distance.mean(), soil.grid.smallest_cell
        weight = copies(body.mirrors) * body.mass.mass * abs(gravity[2])
        contact = min(contact_radius(weight, radius, material, soil), radius)
        force = contact / radius * np.interp(contact / cell, *np.transpose(FORCE))
        if contact < RESOLVED * cell and force > LIMIT:
            yield (f"{body.name} can roll, and its contact with level ground has a radius of {contact:.2g} m, "
                   f"{contact / cell:.2g} cells of {cell:.3g} m, limit {RESOLVED:g}: it feels the lattice of the cells "
                   f"as a force of up to {force:.1%} of its weight towards their nodes, so that it rolls to and fro "
                   f"within a cell, without gaining energy. Use cells of at most {contact / RESOLVED:.2g} m, or, if the "
                   "ground hardly gives way, soil.held = true")


def towed_roller(scene, model):
    """Cylinders that are rolled along clay in plane strain on a contact of so few cells that they sink too little."""
    soil, across = model.soil, np.flatnonzero(~model.soil.grid.collapsed[:2])
    if soil.held or soil.grid.collapsed.sum() != 1 or len(across) != 1:
        return
    material, cell = material_at(scene, soil, top_of(soil)), soil.grid.smallest_cell
    thickness = float(np.ptp(soil.grid.extent[soil.grid.collapsed], axis=1)[0])
    for described, body in zip(scene.bodies, model.bodies):
        distance = np.linalg.norm(initial_vertices(described, body)[:, [across[0], 2]]
                                  - initial_pose(described, body)[0][[across[0], 2]], axis=1)
        moved = travel_along(scene, described, "xy"[across[0]]) or described.velocity[across[0]]
        if material.law != CLAY or not material.strength or not moved or not is_round(body.outline, distance):
            continue
        weight = -body.mass.mass * scene.gravity[2] - min((force[:, 2].min() for force in forces_of(body)), default=0.0)
        chord = weight / (STRIP * material.strength * thickness)
        turning = np.append(np.zeros(3, bool), soil.grid.collapsed)
        kept = [stage.held[turning].all() for stage in body.stages or ()]
        kept += [np.isin(FREEDOMS, stage.held)[turning].all() for stage in scene.stages]
        turns = body.free[turning].all() and not any(kept)
        if turns and body.free[2] and BARELY * cell < chord < CHORD * cell:
            yield (f"{body.name} is rolled along clay that carries it on about {chord:.2g} m, {chord / cell:.2g} cells of "
                   f"{cell:.3g} m, limit {CHORD:g}: it sinks too little, and too little resists it (a roller towed by its "
                   f"diameter: half and three quarters with 3.4 cells). Use cells of at most {chord / CHORD:.2g} m")


def contact_radius(weight, radius, material, soil):
    """Radius [m] of the contact of a sphere with a weight [N]: that of Hertz on soil as at the top, in clay at least that
    which carries the weight."""
    points = soil.constants.position[:, 2] > top_of(soil) - soil.grid.smallest_cell
    young = maximum(soil.law.young[points])
    bulk, shear = (maximum(soil.law.parameters[points, k]) for k in (0, 1))
    poisson = (3 * bulk - 2 * shear) / (6 * bulk + 2 * shear)
    hertz = (0.75 * weight * radius * (1 - poisson**2) / young) ** (1 / 3)
    if material.law != CLAY:
        return hertz
    return max(hertz, np.sqrt(weight / (BEARING * np.pi * material.strength)) if material.strength else radius)


def _rests(described, body):
    """Whether a body begins without motion, and nothing but its weight moves it."""
    loaded = any(stage.loads for stage in body.stages or ())
    return not (any(described.velocity) or any(described.spin) or body.driven.any() or described.pull or loaded)


def _rolls(body):
    """Whether a body can turn about y and move along x, or about x along y, and lies on the soil."""
    return body.free[2] and (body.free[[0, 4]].all() or body.free[[1, 3]].all())


LIMITS = (rolls_on_lattice, towed_roller)
