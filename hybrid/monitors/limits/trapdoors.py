"""Loads of bodies lowered under clay or sand, as trapdoors are, that few cells make too low; plane strain.

    under clay, as deep as wide         1 - 2.3/n                               n cells across
    under sand, twice as deep as wide   1 - (0.75 + 1.1 (sin ψ/0.5)³)/n
"""

import numpy as np

from hybrid.monitors.limits.cell_size import EXCESS, smaller_cells
from hybrid.monitors.limits.loading import driven
from hybrid.monitors.limits.materials import CLAY, SAND, material_at
from hybrid.monitors.limits.shape import narrowest
from hybrid.monitors.limits.start import under_all

# Door of 2 m under 2 m of clay, s_u = 10 kPa, that weighs 31.4 kPa: 8.1, 10.0, 11.0 kPa with 8, 16, 32 cells, exact 11.7
TRAPDOOR = 2.3
# Under sand, H = 2 B: 45, 23, 8 % of γ B²/(4 tan φ) missing with 4, 8, 16 cells, φ = ψ = 30°; 9 % with 8, ψ = 0, φ = ψ = 20°
UNDER_SAND = 0.75, 1.1


def trapdoors(scene, model):
    """Bodies lowered under clay or sand in plane strain, so few cells wide that too little of it rests on them."""
    soil = model.soil
    if soil.held or soil.grid.collapsed.sum() != 1:
        return
    cell = soil.grid.resolution
    for body, travel, place, plane, *_ in driven(scene, model):
        width, top = narrowest(soil.grid, place, travel), place[:, 2].max()
        door = plane and travel[2] < 0.0 and width and under_all(soil, place)
        if not door:
            continue
        material = material_at(scene, soil, top + 0.5 * cell)
        number = TRAPDOOR if material.law == CLAY else _lacks_under_sand(material) if material.law in SAND else 0.0
        excess = number * cell / width
        if excess > EXCESS:
            name = "clay" if material.law == CLAY else "sand"
            yield (f"{body.name} is {width / cell:.2g} cells wide and is lowered under {name}, which is sheared in the "
                   f"cells beside its edges: its load is about {excess:.0%} too low under a cover of its own width, limit "
                   f"{EXCESS:.0%}. {smaller_cells(EXCESS / number * width, ' at its edges')}")


def _lacks_under_sand(material):
    """Share of its load that a trapdoor under a sand lacks, times the cells in its width."""
    return UNDER_SAND[0] + UNDER_SAND[1] * (np.sin(np.radians(material.dilation_angle or 0.0)) / 0.5) ** 3


LIMITS = (trapdoors,)
