"""Loads of clay that few cells make wrong, by how much, from problems set up afresh (demos/random/README.md, "By cells").

    attached to clay on all sides, deep                   Π (1 + 1.75/n)     over the sides, n cells across;
                                                                             1.5 for 1.75 of round outlines
    round, pushed in from its surface, attached or not    Π (1 + r/n)        over the sides, r = 5 z/B, 0.5 at most
    pushed into clay by a depth z, its width B            Π (1 + (0.3 e + 2 z/B)/n)    over the sides, e = 0, 1, 2 of whose
                                                                             edges are on lines of the grid; z <= B
    attached and lifted from its surface                  the same, z = 0
    the same one to two widths under it, in space         Π (1 + 0.9/n)
    the same under an inclined load                       2.7 times that excess; in space of an eccentric one too
    the same under an eccentric load, plane strain        1 + 1.3/(n (1 - 2 e/B))    edges on lines of the grid or not
    the same where s_u grows by k with the depth          1 + 0.3 (k B/s_u)^0.65 times it, plane strain, k B/s_u to 5
    wedge of 90° pressed into it, smooth, plane strain    1 + 0.7/n          n cells in its depth under the ground

Nodes at the edge of a face move with it, and the clay is sheared in the cell beyond (DESIGN, "The foot of a blade drags
on the next nodes"). Those of sand are in `sand_cells`, of soil with cohesion and friction in `footing_cells`, of trapdoors
in `trapdoors`.
"""

from collections import Counter

import numpy as np

from hybrid.monitors.limits.cell_size import EXCESS, ON_LINE, smaller_cells
from hybrid.monitors.limits.loading import driven, loadings, through_clay, to_failure
from hybrid.monitors.limits.materials import CLAY, law_at, material_at, stays_attached
from hybrid.monitors.limits.shape import faces, feet, heading, leads, narrowest, sides
from hybrid.monitors.limits.start import top_of, under_all
from hybrid.runtime.comm import minimum
from hybrid.soil.points import extent

ATTACHED, ROUND, EDGE, WEDGE = 1.75, 1.5, 0.3, 0.7
# Of a strip at 30 and 45° to the grid: 14.1, 13.2 s_u B with 8, 16 cells, where 0 and 90° have 15.1, towards 12.2
TURNED = 1.25
# Squares lifted, n = 4.5, 8.5, 12.5 across, 1.4 widths under the ground, α = 1: 15.9, 14.2, 13.5 s_u A where it has 12.4 at
# most: 0.6; on lines of the grid, 8, one width: 14.8 of 10 to 11.5: 1.3; 4, 8, 12 across, a quarter as thick, 2.5 widths
# deep: 20.6, 17.4, 16.3 of 14.1 by extrapolation
PLATE = 0.9         # of a plate in space less than LONG times as long as wide
# Blocks pressed down by 0.36 of their width, smooth, lines a quarter of a cell beside the edges: 9.5, 8.5 s_u A of a square
# with 4.5, 8.5 cells, towards 7.4; 7.6, 6.8, 6.5 of a strip with 4.5, 8.5, 16.5, towards 6.3
SUNK, MEASURED = 2.0, 3.9       # MEASURED: cells across, narrower ones are reported by `unjudged`
# Smooth discs of 4, 6, 8 cells, E = 500 s_u: 7.6, 7.0, 6.8 s_u A at z = 0.1 B, 9.3, 8.4, 8.3 at 0.3 B, towards 6.0 and 7.3;
# half of that excess with 5 and 7 cells, an outline that ends between lines of the grid; 6.6, 1.0, -0.3 % over 5.69 with 4,
# 6, 8 cells at 0.02 B
ROUND_BASE, ROUND_SUNK = 0.5, 5.0
# Round, two widths deep, α = 1: 14.6, 13.7, 13.1 s_u A with 4, 6, 8 cells pushed in, 12.7, 12.6, 12.3 lifted
SHALLOW_ROUND = 0.5
# Factor on EDGE: an inclined load at V = 4 of 5.14, one at an eighth of the width beside the centre
COMBINED = 2.7
# Over 5.14 s_u (B - 2 e) of smooth strips, E = 5 000 s_u, e/B = 0.125, 0.2, 0.3: 21, 27, 42 % with 8 cells, 11, 14, 21 %
# with 16, 5, 7, 10 % with 32; lines a quarter of a cell beside the edges, after 2 % of B: 16, 21, 32 and 13, 17, 26 %
ECCENTRIC = 1.3
# Factor on EDGE 1 + GROWTH (k B/s_u)^GROWING, s_u under the base; measured up to 20 (9, 4 % with 16, 32 cells). From WEAK on
# FROM_NONE, that of clay without strength at its top: 65, 36 % over k B²/4 with 16, 32 cells, smooth
GROWTH, GROWING, WEAK, FROM_NONE = 0.3, 0.65, 50.0, 17.0
# Settlement under 0.7, 0.8, 0.9 of 5.14 s_u B over finite elements, edges on lines of the grid: 0.84, 0.80, 0.76 with 8
# cells, 0.90, 0.89, 0.87 with 16, 0.95, 0.945 with 32; 1.05 to 1.08 with 9 and edges in the middle of a cell
SETTLES = 4.0
# Tilt over the excess: under 0.3 to 0.5 of the load, e = B/8, smooth, finite elements: +12, +9, +25 % with 9 cells, edges
# in the middle of one, -2, -23, -19 % with 8, on lines; +5 to +14 and -6 to -14 % with 17 and 16
TILTS = 1.2
SLOPES = 35.0, 55.0             # degrees from the ground of the faces of what counts as a wedge of about 90°
LEVEL = 0.5         # up or down over its travel, below which a body is pushed sideways
LONG = 3.0                      # widths: around a bar that long clay flows in its sections
DEEP = 1.0                      # widths: flow of clay around a body that goes deeper closes behind it
# Widths under the ground: a shallower plate lifts the clay above it; discs of 4, 6, 8 cells at 1.9: 20.8, 18.8, 16.8 s_u A,
# 68, 52, 35 % above 12.4, where ROUND gives 89, 56, 41 %
DEEP_PLATE = 1.7
SHALLOW = 0.05                  # of a width: a depth that is not reported
NOTHING = 0.0, "", ""           # no excess


def few_cells(scene, model):
    """Bodies driven through clay with a plane face, or loaded until they go through it, so few cells wide that their load
    is more than EXCESS too high, or what they settle by under one that is near it more than EXCESS too little."""
    cell = model.soil.grid.resolution
    pushed = [found for found in to_failure(scene, model, loadings(scene, model))
              if not (found.by_force and found.body.below_capacity)]
    several = Counter(found.body.name for found in pushed)
    for body, travel, place, plane, by_force, inclined, arm in pushed:
        if not plane:
            continue
        depth = -np.inf if by_force else -travel[2]
        travel = cell * travel / np.linalg.norm(travel) if by_force else travel
        combined = inclined or arm > 0.0
        settles = by_force and not combined and not any(control.points for control in body.stages)
        eccentric, attached = (of(scene, model, body, travel, place, arm) for of in (_eccentric, _attached))
        other = attached[0] or eccentric[0] and not inclined
        lines = NOTHING if other else _on_lines(scene, model, body, travel, place, depth)
        for how, factor, found in (("about", 1.0, attached), ("about", 1.0, eccentric),
                                   ("up to", COMBINED if combined else 1.0, lines)):
            excess, what, cure = found
            excess *= factor
            less = 1.0 - 1.0 / (1.0 + SETTLES * excess) if settles and found is lines else 0.0
            if max(excess, less) > EXCESS:
                load = "its load" if factor == 1.0 else "the inclined or eccentric load that it carries"
                which = f", moved {heading(travel)}," if several[body.name] > 1 else ""
                near = (f", and under 0.7 to 0.9 of it the body settles by up to {less:.0%} too little" if less else
                        f", and under 0.3 to 0.5 of it the body tilts by up to {TILTS * excess:.0%} too much or too little"
                        if by_force and found is eccentric else "")
                yield (f"{body.name}{which} {what}: {load} is {how} {excess:.0%} too high{near}, limit {EXCESS:.0%}. "
                       f"{cure}")


def _eccentric(scene, model, body, travel, place, arm):
    """(Excess, text, remedy) of a strip pressed on clay in plane strain by a load that acts on an `arm` [m]."""
    soil = model.soil
    cell, under = soil.grid.resolution, place[:, 2].min() - 0.5 * soil.grid.resolution
    width = narrowest(soil.grid, place, travel)
    attached = body.interface is not None and body.interface.tension
    if not arm or law_at(scene, soil, under) != CLAY or travel[2] >= 0.0 or attached or soil.grid.collapsed.sum() != 1:
        return NOTHING
    left = max(width - 2.0 * arm, cell)
    return (ECCENTRIC * cell / left,
            f"is pressed on clay by a load {arm / width:.2g} of its width beside its middle, and stands on a width of "
            f"{left / cell:.2g} cells",
            smaller_cells(EXCESS / ECCENTRIC * left, " under it"))


def weak_cone_match(scene, model):
    """Deep flow of clay in space around a body without a plane face, with a match of the cone that is too weak there."""
    soil = model.soil
    material = scene.soil.material
    if soil.held or material.law != CLAY or soil.grid.collapsed.any() or material.cone != "plane strain":
        return
    top = top_of(soil)
    for body, travel, place, plane, *_ in through_clay(scene, model):
        depth = top - place[:, 2].min() - min(travel[2], 0.0)
        # of the whole, where half of it is modelled
        width = narrowest(soil.grid, place, np.array([0.0, 0.0, 1.0]))
        # clay flows around a pile in horizontal planes
        pile = abs(travel[2]) < LEVEL * np.linalg.norm(travel) and place[:, 2].max() > top
        bar = np.ptp(place[:, :2], axis=0).max() > LONG * width
        if width and not (plane or pile or bar) and depth > (1.0 + DEEP) * width:
            yield (f"{body.name} is moved {depth / width:.2g} of its widths deep, limit {1 + DEEP:g}, through clay as "
                   'strong as s_u where it is sheared in a plane (soil.material.cone = "plane strain"): flow around a '
                   "body in space is partly that of triaxial compression and extension, where this clay has 0.87 s_u, "
                   "and a ball carries 12 % less than in Tresca's at least. Set soil.material.cone = "
                   '"compression" if s_u is that of triaxial compression; footings are right without')


def wedges(scene, model):
    """Wedges driven into clay in plane strain, so few cells deep that their load is more than EXCESS too high."""
    soil = model.soil
    if soil.held or soil.grid.collapsed.sum() != 1:
        return
    cell, top = soil.grid.resolution, top_of(soil)
    for body, travel, place, plane, *_ in driven(scene, model):
        depth = top - place[:, 2].min() - travel[2]
        known = not plane and travel[2] < 0.0 < depth and law_at(scene, soil, top - 0.5 * cell) == CLAY
        excess = WEDGE * cell / depth if known and _is_wedge(body, place, travel) else 0.0
        if excess > EXCESS:
            yield (f"{body.name} is a wedge that is pressed {depth:.3g} m into clay, {depth / cell:.2g} cells of {cell:.3g} "
                   f"m: its load is about {excess:.0%} too high at the end of its path, more before, limit {EXCESS:.0%}. "
                   f"Use cells of at most {EXCESS / WEDGE * depth:.2g} m")


def _is_wedge(body, place, travel):
    """Whether two plane faces, at 35 to 55 degrees to the ground, are all that a body covers on its way down."""
    normal, area = faces(body, place)
    ahead = normal @ travel > 0.1 * area * np.linalg.norm(travel)
    units = normal[ahead] / area[ahead][:, None]
    slope = np.degrees(np.arccos(np.clip(-units[:, 2], -1.0, 1.0)))
    inclined = len(units) > 0 and ((slope > SLOPES[0]) & (slope < SLOPES[1])).all()
    return bool(inclined and len(np.unique(units.round(1), axis=0)) == 2)


def _attached(scene, model, body, travel, place, _):
    """(Excess, text, remedy) of a body in clay that stays on it, deep in it or round."""
    soil, cell = model.soil, model.soil.grid.resolution
    across = [(side.width, leads(body, place, side.direction), side.axis is None)
              for side in sides(soil.grid, place, travel)]
    width = min((width for width, *_ in across), default=np.inf)
    if not across or not stays_attached(body, soil):
        return NOTHING
    above = np.inf if soil.grid.collapsed[2] else top_of(soil) - place[:, 2].max()
    if above >= DEEP_PLATE * width or _covered(scene, soil):
        longest = max(width for width, *_ in across)
        flat = ATTACHED if soil.grid.collapsed.any() or longest > LONG * width else PLATE
        across = [(width, TURNED if turned else flat if straight else ROUND) for width, straight, turned in across]
    elif above >= DEEP * width and not soil.grid.collapsed.any():
        across = [(width, PLATE) for width, *_ in across]
    else:       # straight ones are reported by `_on_lines`
        across = [(width, 0.0 if straight or travel[2] >= 0.0 else SHALLOW_ROUND) for width, straight, _ in across]
    excess = np.prod([1.0 + number * cell / width for width, number in across]) - 1.0
    if not excess:
        return NOTHING
    return (excess, f"stays attached to clay and is {width / cell:.2g} cells of {cell:.3g} m wide",
            f"Use cells of at most {EXCESS / sum(number / width for width, number in across):.2g} m at the body")


def _covered(scene, soil):
    """Whether the top of the soil is held, a block cut out of deep ground, so that nothing can be lifted off."""
    return scene.grid.faces.z_max != "free" and top_of(soil) > soil.grid.extent[2, 1] - 1e-6 * soil.grid.resolution


def _on_lines(scene, model, body, travel, place, depth):
    """(Excess, text, remedy) of a body pushed into clay by a `depth` [m], -inf where that is not known, or lifted from clay
    that stays on it, by how deep it is then and whether its edges are on lines of the grid: the mean over its feet."""
    attached = body.interface is not None and body.interface.tension
    if travel[2] == 0.0 or travel[2] > 0.0 and not attached or under_all(model.soil, place):
        return NOTHING
    parts = [(area, *_foot_on_lines(scene, model, body, travel, place, foot, depth))
             for area, _, foot in feet(body, place, np.where(travel[2] > 0.0, -travel, travel), top_of(model.soil))]
    excess = sum(area * each for area, each, *_ in parts) / sum(area for area, *_ in parts) if parts else 0.0
    if not excess:
        return NOTHING
    _, _, narrow, on, growing, sunk = max(parts, key=lambda part: part[0] * part[1])
    wide = f"{narrow:.2g} cells wide"
    has = f"is {wide}" if len(parts) == 1 else f"has {len(parts)} parts ahead, {wide}"
    go = " goes" if len(parts) == 1 else " go"
    also = " and" if len(parts) == 1 else ", which"
    deep = f"{go} {sunk:.2g} {'of this' if sunk < 1.0 else 'times this'} deep" if sunk > SHALLOW else ""
    lines = f" {'has' if len(parts) == 1 else 'have'} edges on lines of the grid along {', '.join(on)}" if on else ""
    return (excess,
            f"{has}{also if deep or lines else ''}{deep}{' and' if deep and lines else ''}{lines}, "
            "where it drives the clay of the next cell too"
            + (", more so as its strength grows with the depth" if growing else ""),
            ("Move the lines of the grid by a quarter of a cell against it, or use" if on else "Use") + " smaller cells")


def _foot_on_lines(scene, model, body, travel, place, foot, depth):
    """(Excess, cells across, axes along which edges are on lines, whether the strength grows, depth in the end over the
    width) of a foot with its vertices at (V, 3) [m] of a body pushed into clay."""
    grid, excess, on, narrow = model.soil.grid, 1.0, [], np.inf
    if law_at(scene, model.soil, foot[:, 2].min() - 0.5 * grid.resolution) != CLAY:
        return 0.0, narrow, on, False, 0.0
    width, sunk = narrowest(grid, foot, travel), 0.0
    if travel[2] < 0.0 and width > MEASURED * grid.resolution and scene.soil.ground is None:
        sunk = max((top_of(model.soil) - foot[:, 2].min() + depth) / width, 0.0)
    growing = _growing(scene, model.soil, foot, travel)
    for width, ends, direction, axis in sides(grid, foot, travel):
        if axis is None:
            continue
        if not leads(body, place, direction):   # a round outline crosses lines of the grid everywhere
            by_depth = ROUND_SUNK * sunk if np.isfinite(depth) else np.inf      # loaded, it goes as deep as it can
            excess *= 1.0 + (min(ROUND_BASE, by_depth) * grid.resolution / width if travel[2] < 0.0 else 0.0)
            narrow = min(narrow, width / grid.resolution)
            continue
        nodes, cell = grid.lines[axis], np.diff(grid.lines[axis]).min()
        lying = sum(np.abs(nodes - end).min() < ON_LINE * cell and _soil_beside(model.soil, foot, axis, end)
                    for end in ends)
        excess *= 1.0 + (EDGE * growing * lying + SUNK * min(sunk, DEEP)) * cell / width
        narrow = min(narrow, width / cell)
        if lying:
            on.append("xyz"[axis])
    return excess - 1.0, narrow, on, growing > 1.0, sunk


def _soil_beside(soil, place, axis, end):
    """Whether soil goes on beyond the `end` [m] of a body with its vertices at `place`, not that of a lid on a specimen."""
    (low, high), beyond = extent(soil.constants, axis), ON_LINE * soil.grid.resolution
    upper = end > 0.5 * (place[:, axis].min() + place[:, axis].max())
    return high > end + beyond if upper else low < end - beyond


def _growing(scene, soil, place, travel):
    """Factor [-] on the excess of a body with its vertices at `place`, 1 where the strength does not grow with depth."""
    cell, bottom = soil.grid.resolution, place[:, 2].min()
    rate = material_at(scene, soil, bottom - 0.5 * cell).strength_gradient or 0.0
    width = narrowest(soil.grid, place, travel)
    if rate <= 0.0 or not width or soil.grid.collapsed.sum() != 1:
        return 1.0
    height = soil.constants.position[:, 2]
    strength = minimum(soil.law.shear_strength(0.0)[(height < bottom) & (height > bottom - cell)], np.inf)
    ratio = rate * width / max(strength, 1e-9 * rate * width)
    return FROM_NONE if ratio > WEAK else 1.0 + GROWTH * ratio ** GROWING


LIMITS = (few_cells, weak_cone_match, wedges)
