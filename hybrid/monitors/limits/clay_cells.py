"""Pressure of clay on walls that few cells make too low (active) or too high (passive), measured on smooth walls that are
drawn back and pushed (demos/random/README.md, "By cells"), clay that stays attached to a body which slides over it, and clay
that flows around a round body deep in it, in plane strain: with n cells across the load is too large by 3/n² of it where
the body is smooth, by half of that where it is rough, and by (9 - 5 α)/n² where the clay stays attached to it; by 2.5/n² on
a pipe that is pushed into it from the ground; in space
around a ball by 1.6/n, where clay stays attached to it, and where a round shaft follows the tip, by 0.55 (4 - n).

    P(H) = γ H²/2 - 2 s_u H         clay that cannot stand by itself, γ H > 4 s_u, slides after the wall on a plane of 45°
    P(H - 1.4 h) instead of P(H)    found with cells of h
    P(H) = γ H²/2 + 2 s_u H         clay that a wall pushes: 1 + 1.5/n to 1 + 2.2/n of it with n cells in its depth

A wedge that moves with the wall bounds the force from below whether clay hangs on the wall or parts from it where
Rankine's stress γ z - 2 s_u is tension. No other mechanism gives more than 2 % of γ H²/2 above it (linear programme of
limit analysis at γ H / s_u = 5, 6.4 and 10). As in sand (`sand_cells`) nodes at the foot stay behind, and the wedge is
as much lower.

A plate lifted out of clay that parts from its lower side lifts the prism over it, s_u on its sides of a height H:
1 + 1.6 h/H with edges on lines of the grid, whatever its width. Weightless, smooth, E = 500 s_u, over s_u times those sides:

| h/H                      | 1/3  | 1/6  | 1/12 | 1/24 |
|--------------------------|------|------|------|------|
| strips, H/B = 3/8        | 1.65 | 1.26 | 1.11 |      |
| strips, H/B = 3/4        |      | 1.30 | 1.11 | 1.04 |
| squares, H/B = 3/8, 3/4  | 1.64 | 1.28 |      |      |
| 1/4 cell beside the lines| 1.41 | 1.20 |      |      |
"""

import numpy as np

from hybrid.body.guides import forces_of
from hybrid.body.symmetry import copies
from hybrid.monitors.limits.cell_size import EXCESS, ON_LINE, smaller_cells
from hybrid.monitors.limits.loading import driven, loaded, through_clay
from hybrid.monitors.limits.materials import CLAY, law_at, material_at, stays_attached
from hybrid.monitors.limits.sand_cells import PASSIVE, Wedge, beside, depths, free_walls, pushed
from hybrid.monitors.limits.shape import leading_normal, narrowest, sides
from hybrid.monitors.limits.start import STEEP, covers, outline, top_of
from hybrid.runtime.comm import anywhere, total

LOWER = 1.4         # cells that the wedge is lower than the wall
IN_CLAY = Wedge("clay", 1.5, "30 to 72 % over the wedge's load with 10 cells, 15 to 43 % with 20")
IN_SPACE = Wedge("clay", 1.0, IN_CLAY.inclined, in_space=". A blade 0.8 m wide and 0.2 m deep, α = 0.5, took 4.7 and 3.7 kN "
                 "with 2 and 4 cells, by hand 3.0 kN", least=1.0)
AROUND, ROUGH = 3.0, 1.5    # 18, 8.5, 5.1, 2.9 % with 4, 6, 8, 12 cells; 9.4, 4.9, 3.3 % (demos/random/README.md)
# Smooth, 15, 10, 7, 4 % with 4, 5, 6, 8 cells over 16, from a depth of 0.1 widths on; laid by a load it is 0.63 and 0.92 of
# the depth on 16 cells deep with 4 and 8
PIPE, PUSHED = 2.5, 0.1
BORNE, SINKS, LAID = 5.3, 2.6, 0.02
STUCK, BY_ADHESION = 9.0, 5.0   # smooth 50, 34, 15 % with 4, 5, 8 cells; α = 1: 25, 14, 6 %; 0.5: 23, 5 % with 5, 10
# On a long way by half as much more with every width, α = 1: 8, 14, 22 % after 0.3, 1, 1.7 widths with 6 cells, 10, 16, 17 %
# after 0.8, 1.8, 2.8 with 8, -3 % with 12
ON_ITS_WAY, FARTHEST = 0.5, 3.0
# α = 1: 54, 46, 25, 16 % with 3, 4, 6, 8 cells over 13.4 s_u A where clay stays attached; where it parts from the ball,
# without weight, 25, 17, 12 % with 3, 4, 6 over what these tend to
BALL, PARTED = 1.6, 0.75
PENETRATED, RESOLVED = 0.55, 4.0    # 1.05, 0.95, 0.55, 0.2, 0.05 with 2, 2.5, 3, 3.5, 4 cells (demos/random/README.md)
SHAFT, DEEP = 1.5, 1.0      # widths: length of a body, and depth of its tip in the end, from which on a shaft follows it
BEARING = 10.0      # of s_u, what stops a body that falls into clay
PRISM, OFF_LINES = 1.6, 1.2     # of h/H, by whether an edge is on a line of the grid
# Of that, by which the prism that is lifted weighs too much: 10.5 % with h/H = 1/12, where its sides bear 15.8 % too much
HEAVIER = 2 / 3
SHARED = 1.05       # cells: soil on both sides of a thinner plate shares nodes
FLOWS = 3.0         # widths: around a plate so far under the ground clay flows
COVERED = 1.0       # widths of clay above a body that all of the clay flows around


def drawn_walls(scene, model):
    """Upright walls that are driven away from clay in plane strain."""
    if scene.gravity[2] >= 0.0:
        return
    for body, travel, place, plane, *_ in driven(scene, model):
        depth = depths(scene, model.soil, place, travel, {CLAY}, away=True) if plane else None
        if depth is not None and depth.behind > PASSIVE * depth.ahead:
            yield from _active(scene, model.soil, body, place, travel, depth.behind, "moves away from", "its load is")


def pushed_walls(scene, model):
    """Walls, upright or inclined, that are driven against clay."""
    yield from pushed(scene, model, {CLAY}, IN_CLAY if model.soil.grid.collapsed.any() else IN_SPACE)


def clay_walls(scene, model):
    """Bodies that no guide holds, with clay on one side of them and hardly any on the other."""
    for body, place, travel, depth in free_walls(scene, model, {CLAY}):
        yield from _active(scene, model.soil, body, place, travel, depth.behind, "retains",
                           "where it gives way, the pressure of the clay is")


def flow_around(scene, model):
    """Round bodies driven, or pushed by forces, through clay that covers them, in plane strain, so few cells wide that their
    load is more than EXCESS too high."""
    soil = model.soil
    if soil.held or soil.grid.collapsed.sum() != 1:
        return
    for body, travel, place, plane, *_ in through_clay(scene, model):
        width = narrowest(soil.grid, place, travel)
        above = np.inf if soil.grid.collapsed[2] else top_of(soil) - place[:, 2].max()
        if plane or not width or above < COVERED * width or leading_normal(body, place, travel) is not None or law_at(
                scene, soil, place[:, 2].mean()) != CLAY:
            continue
        factor, cells = _around(body, soil), width / soil.grid.resolution
        if stays_attached(body, soil):
            factor *= 1.0 + ON_ITS_WAY * min(np.linalg.norm(travel) / width, FARTHEST)
        if factor / cells**2 > EXCESS:
            yield (f"{body.name} is round and {cells:.2g} cells of {soil.grid.resolution:.3g} m wide, deep in the clay "
                   f"that it moves through: its load is about {factor / cells**2:.0%} too high, limit {EXCESS:.0%}. Use "
                   f"cells of at most {width * np.sqrt(EXCESS / factor):.2g} m")


def pushed_pipes(scene, model):
    """Round bodies driven down into clay in plane strain that does not cover them, so few cells wide that their load is more
    than EXCESS too high."""
    for body, travel, place, plane, *_ in driven(scene, model):
        width = _width_on_clay(scene, model.soil, body, place)
        depth = top_of(model.soil) - place[:, 2].min() - travel[2]
        if not plane and width and travel[2] < 0.0 and depth > PUSHED * width:
            excess = PIPE * (model.soil.grid.resolution / width) ** 2
            if excess > EXCESS:
                yield (f"{_few_cells(body, width, model.soil)} pushed into clay: its load is about {excess:.0%} too high, "
                       f"limit {EXCESS:.0%}. Use cells of at most {width * np.sqrt(EXCESS / PIPE):.2g} m")


def laid_pipes(scene, model):
    """The same of those that sink by their weight and a load, V = BORNE (w/D)^¼ D s_u, whose depth is too small."""
    soil, guided = model.soil, {body.name for body, *_ in driven(scene, model)} | scene.joined
    for body, place in (outline(described, part, soil) for described, part in zip(scene.bodies, model.bodies)):
        width = _width_on_clay(scene, soil, body, place) if body.free[2] and body.name not in guided else 0.0
        if not width:
            continue
        load = max([0.0, *(-force[:, 2].min() for force in forces_of(body))]) - body.mass.mass * scene.gravity[2]
        area = width * float(np.ptp(soil.grid.extent[soil.grid.collapsed]))
        depth = min(copies(body.mirrors) * load / (BORNE * area * material_at(scene, soil, top_of(soil)).strength), 1.0) ** 4
        lack = 1.0 - (1.0 + PIPE * (soil.grid.resolution / width) ** 2) ** -SINKS
        if depth > LAID and lack > EXCESS:
            finest = (1.0 - EXCESS) ** (-1.0 / SINKS) - 1.0
            yield (f"{_few_cells(body, width, soil)} laid on clay: its depth is about {lack:.0%} too small, limit "
                   f"{EXCESS:.0%}. Use cells of at most {width * np.sqrt(finest / PIPE):.2g} m")


def _width_on_clay(scene, soil, body, place):
    """Width [m] of a round body at `place` (V, 3) [m] on clay in plane strain that does not cover it, else 0."""
    down = np.array([0.0, 0.0, -1.0])
    if soil.held or soil.grid.collapsed.sum() != 1 or soil.grid.collapsed[2] or law_at(scene, soil, top_of(soil)) != CLAY:
        return 0.0
    width = narrowest(soil.grid, place, down)
    covered = top_of(soil) - place[:, 2].max() >= COVERED * width
    return 0.0 if covered or leading_normal(body, place, down) is not None else width


def _few_cells(body, width, soil):
    cell = soil.grid.resolution
    return f"{body.name} is round and {width / cell:.2g} cells of {cell:.3g} m wide, and is"


def _around(body, soil):
    """Excess of the load on a round body times the square of the number of cells across it."""
    if body.interface is None:
        return AROUND
    return STUCK - BY_ADHESION * min(body.interface.adhesion or 0.0, 1.0) if stays_attached(body, soil) else ROUGH


def lifted_plates(scene, model):
    """Plates lifted out of clay that parts from their lower side, on so few cells above them that their load is more than
    EXCESS too high."""
    soil, up = model.soil, np.array([0.0, 0.0, 1.0])
    if soil.held or soil.grid.collapsed.sum() > 1 or soil.grid.collapsed[2]:
        return
    cell, started = soil.grid.resolution, {}
    raised = [found for found in loaded(scene, model) if found.travel[2] > -scene.gravity[2] * found.body.mass.mass]
    for body, travel, place, plane, *_ in [*driven(scene, model), *raised]:
        across, depth = list(sides(soil.grid, place, up)), top_of(soil) - place[:, 2].max()
        if started.setdefault(body.name, depth) <= 0.0:     # what it has been pressed into before is an open hole
            continue
        material = material_at(scene, soil, top_of(soil) - 0.5 * depth)
        parts = plane and travel[2] > 0.0 and not stays_attached(body, soil) and material.law == CLAY
        parts &= np.ptp(place[:, 2]) > SHARED * cell        # what does not is reported by `contact.thin_wall`
        parts &= not covers(place, soil)                    # no soil beside it is sheared
        if not parts or not across or not cell < depth < FLOWS * min(side.width for side in across):
            continue
        # s_u H on the sides over γ H on the area, both for a height of one
        strength = material.strength + 0.5 * depth * (material.strength_gradient or 0.0)
        sheared = max(strength, 1e-9) * sum(2.0 / side.width for side in across)
        on_line = any(np.abs(soil.grid.lines[side.axis] - end).min() < ON_LINE * cell
                      for side in across if side.axis is not None for end in side.ends)
        share = sheared / (sheared - material.density * min(scene.gravity[2], 0.0))
        excess = (PRISM if on_line else OFF_LINES) * cell / depth * (share + HEAVIER * (1.0 - share))
        if excess > EXCESS:
            yield (f"{body.name} is lifted out of clay with {depth:.3g} m of it, {depth / cell:.2g} cells of {cell:.3g} m, "
                   f"above it: its load is about {excess:.0%} too high, limit {EXCESS:.0%}, as the clay is sheared in the "
                   f"cells beside the plate and over it. {smaller_cells(EXCESS / excess * cell, ' there')}")


def balls(scene, model):
    """Balls and other short round bodies driven, or pushed by forces, in clay that covers them in the end, in space, so few
    cells wide that their load is more than EXCESS too high."""
    soil = model.soil
    if soil.held or soil.grid.collapsed.any():
        return
    for body, travel, place, plane, *_ in through_clay(scene, model):
        width = narrowest(soil.grid, place, travel)
        short = np.ptp(place[:, 2]) <= SHAFT * width
        above = top_of(soil) - place[:, 2].max() - min(travel[2], 0.0)
        known = body.interface is not None and not plane and short and width > 0.0    # a smooth ball was not measured
        if not known or above < COVERED * width or leading_normal(body, place, travel) is not None or law_at(
                scene, soil, place[:, 2].mean() + min(travel[2], 0.0)) != CLAY:
            continue
        factor, cells = BALL if stays_attached(body, soil) else PARTED, width / soil.grid.resolution
        if factor / cells > EXCESS:
            yield (f"{body.name} is round and {cells:.2g} cells of {soil.grid.resolution:.3g} m wide, deep in the clay "
                   f"that it moves through: its load is about {factor / cells:.0%} too high, limit {EXCESS:.0%}. "
                   f"{smaller_cells(width * EXCESS / factor)}")


def penetrators(scene, model):
    """Round bodies with a shaft that go down into clay in space, so few cells wide that their load is more than EXCESS too
    high."""
    soil = model.soil
    if soil.held or soil.grid.collapsed.any():
        return
    for body, travel, place, *_ in [*driven(scene, model), *_falling(scene, model)]:
        width = narrowest(soil.grid, place, travel)
        depth = top_of(soil) - place[:, 2].min() - travel[2]
        down = travel[2] < 0.0 and -travel[2] > np.abs(travel[:2]).max() and np.ptp(place[:, 2]) > SHAFT * width > 0.0
        if not down or depth < DEEP * width or leading_normal(body, place, travel) is not None or law_at(
                scene, soil, top_of(soil) - 0.5 * depth) != CLAY:
            continue
        cells = width / soil.grid.resolution
        excess = PENETRATED * (RESOLVED - cells)
        if excess > EXCESS:
            yield (f"{body.name} is round and {cells:.2g} cells of {soil.grid.resolution:.3g} m wide, and goes "
                   f"{depth / width:.2g} of its widths deep into clay: its load is about {excess:.0%} too high, limit "
                   f"{EXCESS:.0%}. Use cells of at most {width / RESOLVED:.2g} m")


def _falling(scene, model):
    """(RigidBody, travel (3,) [m] in which clay stops it, places (V, 3) [m] of its vertices) of each body that starts with a
    speed downwards."""
    for described, body in zip(scene.bodies, model.bodies):
        speed = described.velocity[2]
        if speed >= 0.0 or not body.free[2]:
            continue
        whole, place = outline(described, body, model.soil)
        strength = material_at(scene, model.soil, top_of(model.soil)).strength
        energy, area = 0.5 * copies(body.mirrors) * body.mass.mass * speed**2, np.ptp(place[:, :2], axis=0).min()**2
        if strength:
            yield whole, np.array([0.0, 0.0, -energy / (BEARING * strength * area)]), place


def _active(scene, soil, body, place, travel, height, does, load):
    """Text, if any, about a wall that clay of a `height` [m] behind it follows."""
    cell = soil.grid.resolution
    critical = _critical_height(scene, soil, place, travel)
    attached = body.interface is not None and body.interface.tension
    if critical is None or height <= max(critical, STEEP * cell) or attached:
        return
    missing = 1.0 - _pressure(max(height - LOWER * cell, critical), critical) / _pressure(height, critical)
    if missing > EXCESS:
        remaining = 0.5 * critical + np.sqrt(0.25 * critical**2 + (1.0 - EXCESS) * _pressure(height, critical))
        yield (f"{body.name} {does} {height:.3g} m of clay that stands by itself up to {critical:.3g} m only, "
               f"{height / cell:.2g} cells of {cell:.3g} m, whose lowest cells stay behind at its foot: {load} about "
               f"{missing:.0%} too low, limit {EXCESS:.0%}, which is unsafe for a retaining wall. "
               f"{smaller_cells((height - remaining) / LOWER)}")


def _pressure(height, critical):
    """P(H) over γ/2 [m²] of clay that a wedge lets stand up to a height 4 s_u / γ."""
    return height * (height - critical)


def _critical_height(scene, soil, place, travel):
    """4 s_u / γ [m] by the means of all clay above the foot of a wall in two cells behind it; None where soil other
    than clay is there."""
    axis = int(np.argmax(np.abs(travel)))
    low, high = beside(soil, place[:, axis], axis)
    points, law = soil.constants, soil.law
    behind = (low if travel[axis] > 0.0 else high) & (points.position[:, 2] > place[:, 2].min())
    if anywhere(law.opens[behind]):
        return None
    fields = points.volume, points.mass, points.volume * law.shear_strength(0.0)
    volume, mass, strength = (float(total(values[behind])) for values in fields)
    return 4.0 * strength / (mass * -scene.gravity[2]) if volume else None


LIMITS = (drawn_walls, pushed_walls, clay_walls, flow_around, pushed_pipes, laid_pipes, lifted_plates,
          balls, penetrators)
