"""Strips on soil with cohesion and friction, and plates lifted out of sand, that few cells make too strong, measured in
plane strain (demos/random/README.md, "By cells").

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

Unlike on clay (`cells`) it does not matter whether the edges lie on lines of the grid: moved by a quarter of a cell, 12.2
and 15.7 % with 15.5 cells, φ = 20 and 30°. What the weight of sand carries is in `sand_cells`.

Plates lifted out of sand drive the next cells too: the load is that of one three cells wider, γ H (B + 3h + H tan φ),
H the depth of its top, over γ H (B + H tan φ), which is 1 + 3/(n (1 + H/B tan φ)). Found [%], ψ = φ, B = 1 m, after 10
to 60 mm, plate of 0.25 B (0.125 B: 18 and 7 % with H/B = 2):

| H/B, φ  | n = 4 | 8  | 16 |
|---------|-------|----|----|
| 1, 30°  |       | 28 | 15 |
| 2, 30°  | 33    | 16 | 8  |
| 4, 30°  |       | 11 |    |
| 2, 40°  |       | 13 |    |
"""

import numpy as np

from hybrid.laws.sand import sand
from hybrid.monitors.limits.contact import covers
from hybrid.monitors.limits.ways import EXCESS, SAND, driven, loaded, material_at, sides, top_of

COHESION, FRICTION, ORDER = 0.41, 0.0215, 0.75      # FRICTION: for each degree of φ
LIFTED = 3.0            # cells that a plate lifted out of sand seems wider
DEEPEST = 4.0           # widths: deeper plates let sand flow around them
SMOOTH = 0.65           # of the excess, where the base is smooth
SHALLOW = 1.0           # widths under the ground: what goes deeper is no footing
COHESIVE = 0.025        # of γ B: from this cohesion on it carries a tenth of what the weight does (φ = 30°)


def cohesive_strips(scene, model):
    """Strips pressed on soil with cohesion and friction, so few cells wide that what cohesion carries is too much by
    EXCESS."""
    soil = model.soil
    if soil.held or soil.grid.collapsed.sum() != 1:
        return
    cell = soil.grid.smallest_cell
    for body, way, place, plane in [*driven(scene, model), *(found[:4] for found in loaded(scene, model))]:
        bottom, width = place[:, 2].min(), min((width for _, width, _ in sides(soil.grid, place, way)), default=0.0)
        material = material_at(scene, soil, bottom - 0.5 * cell)
        lid = covers(place, soil.constants, soil.grid)
        if not plane or lid or way[2] >= 0.0 or bottom < top_of(soil) - SHALLOW * width:
            continue
        if not _cohesive(scene, material, width):
            continue
        excess = strip_excess(material.friction_angle, width / cell) * (1.0 if body.friction else SMOOTH)
        if excess > EXCESS:
            enough = cell * (EXCESS / excess) ** (1 / ORDER)
            yield (f"{body.name} is pressed on soil with cohesion and friction with a base {width / cell:.2g} cells of "
                   f"{cell:.3g} m wide: what cohesion lets it carry (N_c) is about {excess:.0%} too high, limit "
                   f"{EXCESS:.0%}, as it drives the next cell too. Use cells of at most {enough:.2g} m under it, or "
                   "extrapolate to none: load with cells half as large less 1.5 times the difference of both")


def lifted_plates(scene, model):
    """Plates driven up, or that forces of a stage lift, out of sand in plane strain, so few cells wide that their load is
    too high by EXCESS."""
    soil = model.soil
    if soil.held or soil.grid.collapsed.sum() != 1 or scene.gravity[2] >= 0.0:
        return
    cell = soil.grid.smallest_cell
    for body, way, place, plane in [*driven(scene, model), *(found[:4] for found in loaded(scene, model))]:
        top, width = place[:, 2].max(), min((width for _, width, _ in sides(soil.grid, place, way)), default=0.0)
        depth, material = top_of(soil) - top, material_at(scene, soil, top + 0.5 * cell)
        if not plane or way[2] <= 0.0 or not width or not cell < depth <= DEEPEST * width * (1 + 1e-6):
            continue
        if material.law not in SAND:
            continue
        wedge = 1.0 + depth / width * np.tan(np.radians(_friction_angle(material)))
        excess = LIFTED * cell / width / wedge
        if excess > EXCESS:
            yield (f"{body.name} is lifted out of sand and is {width / cell:.2g} cells of {cell:.3g} m wide, {depth:.3g} m "
                   f"under the ground: its load is about {excess:.0%} too high, limit {EXCESS:.0%}, that of a plate "
                   f"{LIFTED:g} cells wider. Use cells of at most {EXCESS / LIFTED * width * wedge:.2g} m at it, or "
                   "extrapolate two sizes of cells to none")


def _friction_angle(material):
    """Friction angle [deg] of a Material, its own or that of its relative density."""
    if material.friction_angle is not None or material.relative_density is None:
        return material.friction_angle or 0.0
    return sand(material.relative_density, material.buoyant)["friction_angle"]


def strip_excess(friction_angle, cells):
    """Excess [-] of the load of a rough strip that is so many `cells` wide; friction_angle: [deg]."""
    return (COHESION + FRICTION * friction_angle) / cells**ORDER


def _cohesive(scene, material, width):
    """Whether a Material has a friction angle, and so much cohesion that it carries a good part of a load."""
    if material.law not in SAND or not material.friction_angle or not material.cohesion or not width:
        return False
    return material.cohesion > COHESIVE * material.density * -min(scene.gravity[2], 0.0) * width


LIMITS = (cohesive_strips, lifted_plates)
