"""Loads of sand that few cells make wrong, by how much, measured on problems set up afresh
(demos/random/README.md, "By cells").

    wall that ends in sand and is pushed against it, plane strain        1 + 2.3/n to 1 + 6.3/n   n cells in its depth
    the same with a face that leans back                                 over 1 + 7/n at 75°, 1 + 14/n at 60°
    upright blade 4/3 as wide as deep, in space                          (1 + 1/n)^2.6
    wall that sand behind it follows, on rock or in the sand, the same   (1 - 1.65/n)²            n cells in its height
    footing pressed on sand that has weight, plane strain                N_γ (1 + 3.1/n^0.6)         n cells in its width
    the same in space, square                                            1 + 4.2/n
    pipe pressed on such sand, plane strain                              1 + 2.5/n         n cells in the chord it touches

A foot holds the next nodes back. Sand that a wall pushes takes them along, and the wedge is a cell deeper than the
wall; sand that follows a wall stays on them, and the wedge is as much lower.
"""

from typing import NamedTuple

import numpy as np

from hybrid.monitors.limits.cell_size import EXCESS, settles, smaller_cells
from hybrid.monitors.limits.loading import driven, loadings, to_failure
from hybrid.monitors.limits.materials import CLAY, SAND, law_at, material_at, strip_pressure
from hybrid.monitors.limits.shape import PLANE, bow, leading_normal, leads, narrowest, sides
from hybrid.monitors.limits.start import STEEP, covers, levelled, outline, top_of, under_all
from hybrid.runtime.comm import maximum, minimum

FOOT, ACTIVE = 2.3, 1.65
# Smooth wall, 2 m of sand, φ = 33°, after 1 and 20 mm, over Rankine's: ψ = 0: 0.88, 0.84 with 8 cells, 0.98, 0.97 with 16,
# 0.90, 0.95 with 20, 1.05, 1.37 with 32, 1.02, 1.31 with 40; ψ = 8°: 0.98, 0.98 with 32
STEADY, BANDS, DILATES = 4.0, 22.0, 0.8     # degrees of ψ; cells in the height; share of φ in ψ with which the law fits
# Degrees from the ground of a face that is judged as a wall, and below which the message has what inclined ones measured.
INCLINED, LEANING = 45.0, 85.0
WEIGHT, ORDER = 3.1, 0.6         # of the part of a footing's load that the sand's weight carries
SQUARE = 4.2                    # of a square one: 377 and 280 kPa with 4 and 8 cells, φ = 30°, ψ = 5°, B = 1.6 m, N_γ 184
# Pipes, μ = 0.4, φ = ψ = 30°, 0.1 and 0.2 D deep, 4, 8, 12, 16, 24 cells in D: 98, 75, 70, 65, 63 and 153, 118, 100, 96,
# 92 kN/m; smooth, φ = 33°, ψ = 5°: 42, 27, 24, 22, 20 and 57, 42, 37, 37, 31
PIPE = 2.5
LAID = 0.25                     # cells: a body that goes less deep lies on the ground
# Widths under the ground: what goes deeper is no footing; a wall 1.25 of its width deep, φ = 33°, 28 and 8 % with 4, 8 cells
SHALLOW, BURIED = 2.0, 0.5      # BURIED: from here on the sand beside it carries more than N_γ does
DEEP = 1.5                      # widths under a footing: of sand one wide over clay it bore 3 % too much with 10 cells
LEVEL = 0.5                     # up or down over sideways: a blade 11° downwards had 16 % less with half the cells
# Depths: sand that presses a wall from behind counts where it is so much deeper, K_p/K_a = 11 times the pressure.
PASSIVE = 3.0


class Wedge(NamedTuple):
    """Parts of the message about a wall that ends in soil and is pushed against it: the name of the soil; by how many cells
    over its depth the load is too high at least; what inclined faces measured; what is added for upright ones in plane
    strain, and in space, where None gives no message; from how many cells in its depth on it is a wall."""

    soil: str
    foot: float
    inclined: str
    upright: str = ""
    in_space: str | None = None
    least: float = LAID


IN_SAND = Wedge("sand", FOOT, "70 to 195 % over Coulomb's wedge with 10 to 20 cells, rising as the sand heaps up",
                ". One on a foot 0.4 of its depth thick measured 98 % with 10 cells, 52 % on its face alone",
                ". A blade 0.8 m wide and 0.6 m deep measured 110 and 50 % without friction with 3 and 6 cells; with 0.3 44 "
                "and 32 kN, where the wedge of McKyes and Ali has 35 to 44 kN")


class Sides(NamedTuple):
    """Depths [m] of the foot of a wall in sand ahead of it and behind it, 0 where there is none."""

    ahead: float
    behind: float


def pushed_walls(scene, model):
    """Walls, upright or inclined, that are driven against sand, and in plane strain upright ones that move away from it."""
    yield from pushed(scene, model, SAND, IN_SAND)
    for body, travel, place, plane, *_ in driven(scene, model):
        depth = depths(scene, model.soil, place, travel, SAND, away=True) if plane else None
        if depth is not None and depth.behind > PASSIVE * depth.ahead:
            yield from _retained(scene, model.soil, body, place, depth.behind, "moves away from", "its load")


def pushed(scene, model, laws, wedge):
    """Texts of a Wedge about walls that end in soil of one of the `laws` and are driven against it."""
    spaces, gone = (1,) if wedge.in_space is None else (0, 1), []
    for body, travel, place, *_ in to_failure(scene, model, driven(scene, model)):
        back = any(body.name == name and _goes_back(travel, way) for name, way in gone)
        gone.append((body.name, travel))
        depth = depths(scene, model.soil, place, travel, laws, spaces)
        if depth is not None and back and np.linalg.norm(travel) > depth.ahead:     # through the furrow that it left
            continue
        angle = None if depth is None else _angle(body, place, travel)
        if angle is not None and angle >= INCLINED and depth.behind <= PASSIVE * depth.ahead:
            yield from _wedge(wedge, body, depth.ahead, model.soil.grid, angle)


def _goes_back(travel, way):
    """Whether a travel is a part of another `way`, the other way round."""
    length, before = np.linalg.norm(travel), np.linalg.norm(way)
    return travel @ way < -PLANE * length * before and length <= before


def _angle(body, place, travel):
    """Degrees between the ground and the face, or the bow, with which a body leads, 90 of an upright one and over 90 of one
    that leans forward; None of a round one."""
    normal = bow(body, place, travel)
    return None if normal is None else float(np.degrees(np.arctan2(normal @ travel / np.linalg.norm(travel), normal[2])))


def retaining_walls(scene, model):
    """Bodies that no guide holds, with sand on one side of them and hardly any on the other."""
    for body, place, _, depth in free_walls(scene, model, SAND):
        yield from _retained(scene, model.soil, body, place, depth.behind, "retains",
                             "where it gives way, the pressure of the sand")


def free_walls(scene, model, laws):
    """(RigidBody, places (V, 3) [m] of its vertices, travel (3,) away from the soil, Sides) of each body that no guide
    holds, with soil of one of the `laws` on one side of it and hardly any on the other."""
    soil = model.soil
    if soil.held or not soil.law.plastic or scene.gravity[2] >= 0.0 or soil.grid.collapsed.sum() != 1:
        return
    axis = int(np.flatnonzero(~soil.grid.collapsed)[0])
    for described, body in zip(scene.bodies, model.bodies):
        if axis > 1 or not body.free[axis] or body.driven.any() or any(control.points for control in body.stages):
            continue        # what drives it, or a point of it, guides it, whichever way it turns
        whole, place = outline(described, body, soil)
        for travel in np.eye(3)[axis], -np.eye(3)[axis]:
            depth = depths(scene, soil, place, travel, laws, away=True)
            if depth is not None and depth.behind > PASSIVE * depth.ahead and leads(whole, place, -travel):
                yield body, place, travel, depth


def footings(scene, model):
    """Footings with a plane base that are pressed on sand with weight: the part N_γ of their load."""
    soil = model.soil
    if soil.held or scene.gravity[2] >= 0.0 or soil.grid.collapsed.sum() > 1 or soil.grid.collapsed[2]:
        return
    cell = soil.grid.resolution
    for body, travel, place, plane, by_force, inclined, arm in loadings(scene, model):
        bottom, width = place[:, 2].min(), narrowest(soil.grid, place, travel)
        material = material_at(scene, soil, bottom - 0.5 * cell)
        shallow = bottom >= top_of(soil) - SHALLOW * width and not under_all(soil, place)
        if not (plane and travel[2] < 0.0 and width and shallow and material.law in SAND):
            continue
        if clay_under(scene, soil, bottom, width, material):
            continue        # the base is punched through the sand into it
        strip = len(list(sides(soil.grid, place, travel))) == 1       # over all of the grid along the other axis
        left = max(width - 2.0 * arm, cell)         # what a load beside the middle stands on
        excess = WEIGHT * (cell / left)**ORDER if strip else SQUARE * cell / left
        part = ", a part of its load at this depth," if bottom < top_of(soil) - BURIED * width else ""
        if excess > EXCESS and not covers(place, soil):
            beside = f", less twice the {arm:.3g} m by which the load is beside its middle" if arm else ""
            less, below = "the difference", settles(by_force and strip and not inclined, width / cell, arm)
            if strip:
                less = f"1.9 times {less}, as the excess falls with the power 0.6 of the cells"
            yield (f"{body.name} is pressed on sand with a base {left / cell:.2g} cells of {cell:.3g} m wide{beside}: what "
                   f"the sand's own weight lets it carry (N_γ){part} is about {excess:.0%} too high, more if the base is "
                   f"smooth{_rising(material)}, limit {EXCESS:.0%}{below}. Extrapolate two sizes of cells to "
                   f"none: load of cells half as large less {less}")


def pipes(scene, model):
    """Round bodies driven into sand with weight in plane strain: their load, which its own weight lets it carry."""
    soil = model.soil
    if soil.held or scene.gravity[2] >= 0.0 or soil.grid.collapsed.sum() != 1 or soil.grid.collapsed[2]:
        return
    cell, top = soil.grid.resolution, top_of(soil)
    for body, travel, place, plane, *_ in driven(scene, model):
        bottom = place[:, 2].min()
        round_one = not plane and travel[2] < 0.0 and leading_normal(body, place, travel) is None
        if not round_one or bottom < top - LAID * cell or law_at(scene, soil, bottom - 0.5 * cell) not in SAND:
            continue
        chord = narrowest(soil.grid, place[place[:, 2] + travel[2] < top], travel) if bottom + travel[2] < top else 0.0
        if chord and PIPE * cell > EXCESS * chord:
            yield (f"{body.name} is round and pressed on sand, which it touches on {chord / cell:.2g} cells of {cell:.3g} m "
                   f"in the end: its load is about {PIPE * cell / chord:.0%} too high then, more before, limit "
                   f"{EXCESS:.0%}. Extrapolate two sizes of cells to none: load of cells half as large less the difference")


def clay_under(scene, soil, bottom, width, sand):
    """Whether there is clay within DEEP of a `width` [m] under a footing with its base at `bottom` [m] that carries less
    than the Material of the `sand`."""
    lowest = max(bottom - DEEP * width, soil.grid.extent[2, 0])
    below = [material_at(scene, soil, height) for height in np.arange(bottom, lowest, -0.5 * soil.grid.resolution)]
    carried = strip_pressure(sand, width, abs(scene.gravity[2]))
    return any(each.law == CLAY and strip_pressure(each, width, 0.0) < carried for each in below)


def _rising(material):
    """What is reported of sand that dilates: φ = ψ = 30°, 8 cells in 2 m, E = 500 MPa: 28, 38, 46 of 14.75 after 6, 30, 60
    mm."""
    return " and rising with the distance moved as the sand dilates" if material.dilation_angle else ""


def _wedge(wedge, body, depth, grid, angle):
    """Text, if any, about a wall at an `angle` [deg] to the ground that pushes soil as deep as `depth` [m]. In space the
    law is known without friction only."""
    cell, in_plane_strain = grid.resolution, grid.collapsed.any()
    excess = wedge.foot * cell / max(depth, cell)
    if depth < wedge.least * cell or excess <= EXCESS:
        return
    verb = "is" if in_plane_strain or not body.friction or wedge.soil == "clay" else "without friction would be"
    if angle < LEANING:
        remedy = (f"Its face is at {angle:.0f} degrees to the ground, limit {LEANING:.0f}, and drags more: smooth "
                  f"faces at 75 and 60 degrees measured {wedge.inclined}. Extrapolate two sizes of cells to none")
    else:
        remedy = smaller_cells(EXCESS / wedge.foot * depth) + (wedge.upright if in_plane_strain else wedge.in_space)
    yield (f"{body.name} ends {depth:.3g} m deep in {wedge.soil}, {depth / cell:.2g} cells of {cell:.3g} m, and drags the "
           f"next cell along: the resistance of the soil ahead of it {verb} at least {excess:.0%} too high, limit "
           f"{EXCESS:.0%}. {remedy}")


def _retained(scene, soil, body, place, depth, does, load):
    """The same of a wall with its vertices at `place` that sand of a height h = `depth` [m] behind it follows: its pressure
    K_a γ h²/2 - 2 c √K_a h is that of a height which is ACTIVE cells less."""
    cell = soil.grid.resolution
    material = material_at(scene, soil, place[:, 2].min() + 0.5 * cell)
    root = np.tan(np.pi / 4 - np.radians(material.friction_angle) / 2)      # √K_a
    weight, suction = 0.5 * root**2 * material.density * -scene.gravity[2], 2.0 * (material.cohesion or 0.0) * root
    whole, low = (max(weight * h - suction, 0.0) * h for h in (depth, max(depth - ACTIVE * cell, 0.0)))
    if depth < STEEP * cell or whole <= 0.0:
        return
    bands, missing = (material.dilation_angle or 0.0) < STEADY, 1.0 - low / whole
    start = f"{body.name} {does} {depth:.3g} m of sand, {depth / cell:.2g} cells of {cell:.3g} m"
    if bands and depth > BANDS * cell:
        yield (f"{start}, which dilates by less than {STEADY:g} degrees and localises in bands a cell wide: {load} rises "
               "with the way, to 1.4 times Rankine's after a hundredth of the height, and more with smaller cells. Give it "
               "a larger dilation_angle: with 8 degrees it is steady")
    elif missing > EXCESS:
        least = (suction + np.sqrt(suction**2 + 4.0 * weight * (1.0 - EXCESS) * whole)) / (2.0 * weight)
        size = (depth - least) / ACTIVE
        cure = smaller_cells(size)
        if bands and depth > BANDS * size:
            cure = (f"Use {BANDS:g} cells in that height at most: in smaller ones sand that dilates by less than {STEADY:g} "
                    "degrees localises, and the load rises with the way")
        how = "about" if (material.dilation_angle or 0.0) > DILATES * material.friction_angle else "up to"
        yield (f"{start}, whose lowest cells stay behind at its foot: {load} is {how} "
               f"{missing:.0%} too low, limit {EXCESS:.0%}, which is unsafe for a retaining wall. {cure}")


def depths(scene, soil, place, travel, laws, spaces=(1,), away=False):
    """Sides of an upright wall with its vertices at `place`, moved along a `travel`, whose foot is in soil of one of the
    `laws`, in a grid with one of the numbers `spaces` of axes collapsed: in plane strain unless these have 0; None of
    what is none, goes up or down by more than LEVEL, or ends on the base; `away` from the soil behind it on a smooth base
    alone, as the lowest cells stay behind on one that is held."""
    axis, bottom, cell = int(np.argmax(np.abs(travel))), place[:, 2].min(), soil.grid.resolution
    if soil.grid.collapsed.sum() not in spaces or soil.grid.collapsed[2] or abs(travel[2]) > LEVEL * abs(travel[axis]):
        return None
    height, half = levelled(soil, soil.constants.position)[:, 2], soil.constants.half_width[:, 2]
    near = beside(soil, place[:, axis], axis)
    base = min(minimum((height - half)[inside], np.inf) for inside in near)
    on_base = bottom < base + cell and not (away and scene.grid.faces.z_min == "fixed")
    if on_base or law_at(scene, soil, bottom + 0.5 * cell) not in laws:
        return None
    before = [maximum((height + half)[inside], -np.inf) - bottom for inside in near]
    if place[:, 2].max() < bottom + max(before):    # under the ground
        return None
    return Sides(*(max(depth, 0.0) for depth in (before[::-1] if travel[axis] > 0 else before)))


def beside(soil, reach, axis):
    """Points (n,) bool in two cells below, and in two above, what a body covers along an `axis`."""
    low, high, cell = reach.min(), reach.max(), soil.grid.resolution
    x = soil.constants.position[:, axis]
    return (x > low - 2 * cell) & (x < low), (x > high) & (x < high + 2 * cell)


LIMITS = (footings, pipes, pushed_walls, retaining_walls)
