"""Footings on soil with cohesion and friction, and plates and pipes lifted out of sand, that few cells make too strong
(demos/random/README.md, "By cells").

Strips pushed straight down, weightless, ψ = φ, E = 10⁵ c:

    N_c (1 + (0.41 + 0.0215 φ)/n^0.75)     φ in degrees, n cells in the width of a rough strip

Excess [%] over Prandtl's N_c = (e^(π tan φ) tan²(45° + φ/2) - 1) cot φ:

| φ           | n = 8 | 16   | 32  |
|-------------|-------|------|-----|
| 0           | 8.6   | 4.5  | 2.4 |
| 10°         | 13.4  | 7.8  | 4.5 |
| 20°         | 17.9  | 10.6 | 6.2 |
| 30°         | 21.8  | 13.3 | 8.4 |
| 20°, smooth |       | 7.0  |     |
| 30°, smooth |       | 8.5  |     |

These are loads after w = 8 B c N_c/E. Where the soil dilates they go on rising (clay: from 8.5 to 9.4 %): the excess is
as (w E/(8 B c N_c))^0.3, found up to 35. At φ = 20°, n = 8 and 16: 17, 11 % after 7 B c N_c/E, 25, 16 % after 34; at 30°
35, 24 % after 33. With E = 500 c the largest loads are 18, 10 % too high at 20°, 18 % at 30° with n = 8.

Soil that dilates by less than its friction angle has N_c of tan φ* = sin φ cos ψ/(1 - sin φ sin ψ) (Davis 1968), and the
excess over that is (2 + ψ/φ)/3 of the one above, without a rise where ψ = 0. Found [%] after 7 and 34 B c N_c/E:

| φ, ψ       | n = 8      | 16         |
|------------|------------|------------|
| 20°, 10°   | 15, 22     | 10, 14     |
| 20°, 0     | 12, 12     | 7, 7       |
| 30°, 15°   | 23, 33     |            |
| 10°, 0     | 9, 9       |            |

Square ones have the same law: N_c = 27.1, 23.1, 21.9 with 4, 8, 12 cells at φ = ψ = 20°, towards 19.4, so 40, 19, 13 %.

Unlike on clay (`cells`) it does not matter whether the edges lie on lines of the grid: moved by a quarter of a cell, 12.2
and 15.7 % with 15.5 cells, φ = 20 and 30°. What the weight of sand carries is in `sand_cells`.

Plates lifted out of sand drive the next cells too: the load is that of one three cells wider, γ H (B + 3h + s H), H the
depth of its top, over γ H (B + s H), which is 1 + 3/(n (1 + s H/B)). Sand follows on slopes of ψ (White, Cheuk & Bolton
2008), s = tan ψ + (tan φ - tan ψ) ((1 + K0)/2 - (1 - K0)/2 cos 2ψ), where ψ = φ tan φ. K0 = 1 - sin φ: what began with
K0 = 1 and ψ = 0 falls as the plate rises. Found [%], B = 1 m, after 10 to 60 mm, plate of 0.25 B (0.125 B: 18 and 7 % with
H/B = 2):

| H/B, φ, ψ   | n = 4 | 8  | 16 |
|-------------|-------|----|----|
| 1, 30°, 30° |       | 28 | 15 |
| 2, 30°, 30° | 33    | 16 | 8  |
| 4, 30°, 30° |       | 11 |    |
| 2, 40°, 40° |       | 13 |    |
| 2, 30°, 15° |       | 23 |    |
| 2, 30°, 0   | 49    | 18 | 14 |
| 1, 30°, 0   |       | 21 |    |

Cohesion adds 2 c H cos φ cos ψ/(1 - sin φ sin ψ), which cells do not change: c = 20 kPa, φ = 20°, H/B = 1.2, 73.4 and
72.6 kN with 10 and 20 cells, by hand 70.9.

In space a plate of B by L seems only two cells wider, over γ (H B L + s H² (B + L) + 4/3 s² H³): squares at φ = ψ = 35°,
H/B = 2, have 30, 20 % over Murray & Geddes' bound with 6, 8 cells.

Pipes seem two cells wider likewise, H the depth of their axis: over γ (H D + s H² - π D²/8), after 4 to 30 mm, as much
smooth as with friction. φ = 36°, ψ = 6°: H/D = 1.75 with n = 8, 16: 19 to 26, 12 to 16; 1: 16 to 25; 2.5: 14 to 27; 1.25,
n = 12: 15; φ = 30°, ψ = 0, H/D = 1.75, n = 8: 10 to 20.
"""

import numpy as np

from hybrid.monitors.limits.cell_size import EXCESS, settles, smaller_cells
from hybrid.monitors.limits.loading import loadings
from hybrid.monitors.limits.materials import SAND, material_at, prandtl
from hybrid.monitors.limits.sand_cells import clay_under
from hybrid.monitors.limits.shape import leading_normal, narrowest, sides
from hybrid.monitors.limits.start import covers, top_of

COHESION, FRICTION, ORDER = 0.41, 0.0215, 0.75      # FRICTION: for each degree of φ
REACHED, RISING, FARTHEST = 8.0, 0.3, 35.0          # w E/(B c N_c) of those, power of the rise, largest that was measured
LIFTED, PIPE, IN_SPACE = 3.0, 2.0, 2.0  # cells that a plate, a pipe, a plate in space lifted out of sand seem wider
# Widths: deeper plates let sand flow around them; at 5 with 4 cells 46 % over the same law, which has 22 %
DEEPEST = 6.0
UPRIGHT = 0.9           # up over the whole travel: plates pulled obliquely have the excess (28 % at 45°), not the load
SMALL_BOND = 0.05       # widths of a plate: what cohesion adds less is not said
# Of an inclined load, φ = ψ = 20°, c = 10 kPa, V = 0.8 of its limit: H 29 to 40, 18 % over that of slip lines with 16, 32
# cells; 11 % at V = 0.5
COMBINED = 3.0
SMOOTH = 0.65           # of the excess, where the base is smooth
SHALLOW = 1.0           # widths under the ground: what goes deeper is no footing
COHESIVE = 0.025        # of γ B: from this cohesion on it carries a tenth of what the weight does (φ = 30°)


def cohesive_strips(scene, model):
    """Footings pressed on soil with cohesion and friction, so few cells wide that what cohesion carries is too much by
    EXCESS."""
    soil = model.soil
    if soil.held or soil.grid.collapsed.sum() > 1 or soil.grid.collapsed[2]:
        return
    cell = soil.grid.resolution
    for body, travel, place, plane, by_force, inclined, arm in loadings(scene, model):
        bottom, width = place[:, 2].min(), narrowest(soil.grid, place, travel)
        material = material_at(scene, soil, bottom - 0.5 * cell)
        lid = covers(place, soil)
        if not plane or lid or travel[2] >= 0.0 or bottom < top_of(soil) - SHALLOW * width:
            continue
        if _cohesive(scene, material, width) and not clay_under(scene, soil, bottom, width, material):
            # a load beside the middle stands on less
            left = max(width - 2.0 * arm, cell)
            below = settles(by_force and not inclined and soil.grid.collapsed.any(), width / cell, arm)
            yield from _strip(body, left, cell, material, 0.0 if by_force else -travel[2], below, inclined)


def _strip(body, width, cell, material, travel, below, inclined):
    """Text, if any, about a strip of a `width` [m] that is driven by a `travel` [m] into soil of a Material; below: what is
    said of lower loads; inclined: whether its load is."""
    angle, dilation = material.friction_angle, material.dilation_angle or 0.0
    reduced = _reduced(angle, dilation)
    stiffness = material.young or 0.0       # with `reference_young` it is not one number: no rise is reported
    reached = travel / width * stiffness / (material.cohesion * prandtl(reduced))
    straight = strip_excess(angle, width / cell, dilation / angle, reached) * (1.0 if body.friction else SMOOTH)
    excess = straight * (COMBINED if inclined else 1.0)
    if excess > EXCESS:
        over = f"N_c of {reduced:.3g} degrees, as its dilation is below its friction" if dilation < angle else "N_c"
        when = " at the end of its path, with which that rises" if dilation and reached > REACHED else ""
        enough = cell * (EXCESS / excess) ** (1 / ORDER)
        load = (f"what cohesion lets it carry ({over}) is about {straight:.0%} too high{when}" if not inclined else
                f"under the vertical load the horizontal one that it carries is up to {excess:.0%} too high, as N_c is by "
                f"{straight:.0%}")
        yield (f"{body.name} is pressed on soil with cohesion and friction with a base {width / cell:.2g} cells of "
               f"{cell:.3g} m wide: {load}, limit "
               f"{EXCESS:.0%}, as it drives the next cell too{below}. Use cells of at most {enough:.2g} m under it, or "
               "extrapolate to none: load with cells half as large less 1.5 times the difference of both")


def lifted(scene, model):
    """Plates and, in plane strain, pipes driven up, or that forces of a stage lift, out of sand, so few cells wide that
    their load is too high by EXCESS."""
    soil = model.soil
    if soil.held or soil.grid.collapsed.sum() > 1 or scene.gravity[2] >= 0.0:
        return
    cell = soil.grid.resolution
    for body, travel, place, plane, *_ in loadings(scene, model):
        top, width = place[:, 2].max(), narrowest(soil.grid, place, travel)
        inclined = not plane and leading_normal(body, place, travel) is not None
        if travel[2] <= 0.0 or not width or top_of(soil) - top <= cell or inclined or covers(place, soil):
            continue
        material, depth = material_at(scene, soil, top + 0.5 * cell), top_of(soil) - top + (not plane) * 0.5 * width
        if material.law in SAND and depth <= DEEPEST * width * (1 + 1e-6):
            across = np.array([side.width for side in sides(soil.grid, place, travel)])
            bond = _bond(material, -scene.gravity[2])
            if len(across) == 1:        # over all of the grid along the other axis
                upright = travel[2] > UPRIGHT * np.linalg.norm(travel)
                yield from _lifted(body, width, depth, cell, material, plane, upright, bond)
            elif plane:
                yield from _lifted_in_space(body, across, depth, cell, material, bond)


def _lifted(body, width, depth, cell, material, plane, upright, bond):
    """Text, if any, about a plate, or a pipe, of a `width` [m] whose top, or axis, is at a `depth` [m] in a Material, drawn
    upright or not; bond [m]: what cohesion adds to the width."""
    slope = _slope(material.friction_angle, material.dilation_angle or 0.0)
    wider, hollow = (LIFTED, 0.0) if plane else (PIPE, np.pi * width**2 / 8)
    resting = depth * (width + slope * depth + bond) - hollow
    excess = wider * cell * depth / resting
    if excess > EXCESS:
        what, over = ("plate", f"γ H (B + {slope:.2g} H") if plane else ("pipe", f"γ (H (D + {slope:.2g} H) - π D²/8")
        over += f") + {bond:.2g} γ H" if bond > SMALL_BOND * width else ")"
        over = f"over {over}, " if upright else ""
        yield (f"{body.name} is lifted out of sand and is {width / cell:.2g} cells of {cell:.3g} m wide, {depth:.3g} m "
               f"under the ground: its load is about {excess:.0%} too high, limit {EXCESS:.0%}, {over}that of a "
               f"{what} {wider:g} cells wider. {smaller_cells(EXCESS / excess * cell, ' at it')}")


def _lifted_in_space(body, across, depth, cell, material, bond):
    """Text, if any, about a plate with widths `across` (2,) [m] whose top is at a `depth` [m] in a Material; bond [m]: what
    cohesion adds to each of them."""
    slope, around = _slope(material.friction_angle, material.dilation_angle or 0.0), across.sum()
    resting = across.prod() + (slope * depth + bond) * around + 4 / 3 * (slope * depth) ** 2
    excess = IN_SPACE * cell * (around + 2.0 * slope * depth) / resting
    if excess > EXCESS:
        yield (f"{body.name} is lifted out of sand and is {across.min() / cell:.2g} cells of {cell:.3g} m wide, {depth:.3g} "
               f"m under the ground: its load is about {excess:.0%} too high, limit {EXCESS:.0%}, that of a plate "
               f"{IN_SPACE:g} cells wider. {smaller_cells(EXCESS / excess * cell, ' at it')}")


def _bond(material, gravity):
    """[m], what the cohesion of the sand beside a lifted plate resists, on both sides and over γ H (Davis 1968)."""
    friction, dilation = np.radians([material.friction_angle, material.dilation_angle or 0.0])
    reduced = np.cos(friction) * np.cos(dilation) / (1.0 - np.sin(friction) * np.sin(dilation))
    return 2.0 * material.cohesion * reduced / (material.density * gravity)


def _slope(friction, dilation):
    """s [-] in γ H (B + s H), what the sand over a lifted plate and beside it weighs and resists; angles: [deg]."""
    friction, dilation = np.radians([friction, dilation])
    rest = 1.0 - np.sin(friction)
    normal = 0.5 * (1.0 + rest) - 0.5 * (1.0 - rest) * np.cos(2.0 * dilation)
    return float(np.tan(dilation) + (np.tan(friction) - np.tan(dilation)) * normal)


def strip_excess(friction_angle, cells, dilation=1.0, reached=REACHED):
    """Excess [-] of the load of a rough strip that is so many `cells` wide over N_c of the angle that `_reduced` gives.

    friction_angle: [deg]; dilation: ψ/φ; reached: travel over B c N_c/E.
    """
    rise = (np.clip(reached, REACHED, FARTHEST) / REACHED) ** RISING if dilation else 1.0
    return (2.0 + dilation) / 3.0 * rise * (COHESION + FRICTION * friction_angle) / cells**ORDER


def _reduced(angle, dilation):
    """Friction angle [deg] of soil with the dilation angle of its friction that carries as much (Davis 1968); [deg]."""
    friction, dilation = np.radians([angle, dilation])
    return float(np.degrees(np.arctan2(np.sin(friction) * np.cos(dilation), 1.0 - np.sin(friction) * np.sin(dilation))))


def _cohesive(scene, material, width):
    """Whether a Material has a friction angle, and so much cohesion that it carries a good part of a load."""
    if material.law not in SAND or not material.friction_angle or not material.cohesion or not width:
        return False
    return material.cohesion > COHESIVE * material.density * -min(scene.gravity[2], 0.0) * width


LIMITS = (cohesive_strips, lifted)
