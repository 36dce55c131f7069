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
from hybrid.monitors.limits.cell_size import EXCESS
from hybrid.monitors.limits.clay_cells import LAID as SUNK
from hybrid.monitors.limits.materials import CLAY, SAND, STRIP, material_at, weight_factor
from hybrid.monitors.limits.shape import is_round
from hybrid.monitors.limits.start import initial_pose, initial_vertices, levelled, top_of
from hybrid.runtime.comm import maximum
from hybrid.scene.defaults import STANDARD_GRAVITY

# (a/h, tangential force over the weight times r/a)
FORCE = ((0.0, 0.0), (0.18, 0.065), (0.37, 0.15), (0.5, 0.26), (0.75, 0.26), (1.0, 0.17), (1.34, 0.05))
LIMIT = 0.01        # of the weight
RESOLVED = 1.34     # cells in the radius of contact, from which on the force is small
BEARING = 6.0       # pressure under a round body that has sunk into clay, over its strength
# Cylinder of 1 m towed over clay under 17.7 kN/m, s_u = 10 kPa, by its diameter: 60, 105, 115 mm deep, 9.7, 12.3, 12.9 kN/m
# with 3.4, 5.5, 6.9 cells on the width that a strip would need
CHORD, BARELY = 6.5, 0.5
# A cylinder of 0.6 m laid by 9 kN/m over a node, over the middle of a cell: 7.2, 2.4 mm deep in clay with 1.2 cells in its
# contact, 6.6, 8.0 with 2.3, towards 8.5; on elastic soil 3.5, 2.6 mm with 0.5, 3.8, 3.3 with 1, towards 3.8; on sand 7.7,
# 15.1 with 2.7, 12.6, 8.9 with 5.5, towards 11.2. {kind: (with one cell, power of their number)}
BY_PLACE = {"clay": (1.05, 2.0), "elastic soil": (0.12, 1.35), "sand": (0.95, 1.0)}


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
    for described, body in zip(scene.bodies, model.bodies):
        forces = list(forces_of(body))
        moved = travel_along(scene, described, "xy"[across[0]]) or described.velocity[across[0]] or any(
            force[:, across[0]].any() for force in forces)
        if material.law != CLAY or not material.strength or not moved or not _is_cylinder(described, body, across[0]):
            continue
        chord = _load_on(scene, soil, body) / (STRIP * material.strength)
        turning = np.append(np.zeros(3, bool), soil.grid.collapsed)
        kept = [given.held[turning].all() or np.isin(FREEDOMS, stage.held)[turning].all()
                for given, stage in zip(body.stages, scene.stages)] if body.stages else [
                    np.isin(FREEDOMS, stage.held)[turning].all() for stage in scene.stages]
        turns = body.free[turning].all() and not all(kept)
        if turns and body.free[2] and BARELY * cell < chord < CHORD * cell:
            yield (f"{body.name} is rolled along clay that carries it on about {chord:.2g} m, {chord / cell:.2g} cells of "
                   f"{cell:.3g} m, limit {CHORD:g}: it sinks too little, and too little resists it (a roller towed by its "
                   f"diameter: half and three quarters with 3.4 cells). Use cells of at most {chord / CHORD:.2g} m")


def narrow_contact(scene, model):
    """Cylinders laid on soil in plane strain on a contact so narrow that their depth depends on where in a cell they lie;
    those that sink into clay are reported by `clay_cells.laid_pipes`."""
    soil, across = model.soil, np.flatnonzero(~model.soil.grid.collapsed[:2])
    if soil.held or soil.grid.collapsed.sum() != 1 or len(across) != 1:
        return
    top, cell = top_of(soil), soil.grid.smallest_cell
    material = material_at(scene, soil, top)
    towed = [text.split(" is rolled")[0] for text in towed_roller(scene, model)]
    for described, body in zip(scene.bodies, model.bodies):
        place = levelled(soil, initial_vertices(described, body))
        driven = body.driven[2] or any(point.guide.component == 2 for stage in body.stages for point in stage.points)
        laid = body.free[2] and not driven and abs(place[:, 2].min() - top) < cell
        if not laid or body.name in {*scene.joined, *towed} or not _is_cylinder(described, body, across[0]):
            continue
        diameter = float(np.ptp(initial_vertices(described, body)[:, 2]))
        kind, chord = _chord(material, _load_on(scene, soil, body), 0.5 * diameter)
        if not 0.0 < chord < diameter or kind == "clay" and (chord / diameter) ** 2 / 4.0 > SUNK:
            continue
        share, power = BY_PLACE[kind]
        error, limit = min(share * (cell / chord) ** power, 1.0), (share / EXCESS) ** (1.0 / power)
        if error > EXCESS:
            yield (f"{body.name} is round and lies on {kind} on about {chord:.2g} m, {chord / cell:.2g} cells of "
                   f"{cell:.3g} m, limit {limit:.2g}: how deep, and what resists its rolling, depends by up to "
                   f"{error:.0%} on where in a cell it touches. Use cells of at most {chord / limit:.2g} m there")


def _is_cylinder(described, body, across):
    """Whether a body is round in the plane of x or y, `across`, and z."""
    place, middle = initial_vertices(described, body), initial_pose(described, body)[0]
    return is_round(body.outline, np.linalg.norm((place - middle)[:, [across, 2]], axis=1))


def _load_on(scene, soil, body):
    """Largest load [N/m] along the slice by which a body and what stages push it with press the soil."""
    thickness = float(np.ptp(soil.grid.extent[soil.grid.collapsed], axis=1)[0])
    pushed = min((force[:, 2].min() for force in forces_of(body)), default=0.0)
    return copies(body.mirrors) * (-body.mass.mass * scene.gravity[2] - pushed) / thickness


def _chord(material, load, radius):
    """(Kind of soil, width [m] on which it carries a `load` [N/m]): a strip's in clay and in sand, Hertz's on elastic soil;
    0 where it is not known."""
    if material.law == CLAY:
        return "clay", load / (STRIP * material.strength) if material.strength else 0.0
    if material.law == "hencky":
        compliance = (1.0 - material.poisson**2) / (np.pi * material.young)
        return "elastic soil", 4.0 * np.sqrt(max(load, 0.0) * radius * compliance)
    if material.law not in SAND or not material.friction_angle:
        return "sand", 0.0
    weight = material.density * STANDARD_GRAVITY * weight_factor(material.friction_angle)
    return "sand", np.sqrt(2.0 * max(load, 0.0) / weight)


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


LIMITS = (rolls_on_lattice, towed_roller, narrow_contact)
