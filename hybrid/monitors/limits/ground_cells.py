"""Ground without bodies that few cells let stand under too much of its weight, in plane strain (demos/random/README.md,
"By cells").

    upright cut under its own weight, plane strain        1 + 1.05/n         n cells in its height;
                                                                             1 + (1.05 + ψ/10°)/n where soil dilates
    slope of 45 to 60° in soil with cohesion and friction 1 + (ψ/13°)²/n     the same, at least 1 + 1/n
"""

import numpy as np

from hybrid.monitors.limits.cell_size import EXCESS
from hybrid.monitors.limits.materials import CLAY, SAND, material_at
from hybrid.monitors.limits.start import STEEP, step_of_ground, top_of
from hybrid.scene.ground import heights, heights_at

CUT = 1.05
# Cuts in soil with cohesion and friction over 3.83 c/γ tan(45° + φ/2): φ = ψ = 20°, 12 and 24 cells high, 16 to 20, 12 to
# 14 %; 30°, 36 to 40 and 18 to 22 %; φ = 20°, ψ = 0, 12 cells, 8 to 14 %
DILATING = 0.1      # for each degree of ψ
# Slopes of 45 and 60° in such soil, share of the gravity at which they fail (Chen 1975) where ψ = φ = 10, 20, 30°: 8 cells
# high 1.06 and 1.08, 1.32 and 1.30, 1.6 and more; 16 cells 1.02, 1.14, 1.36 at 60°; 32 cells 1.04 at 20°. ψ = 0: 0.96 to
# 1.16, 1.3 at 30°, with 8 cells, 0.94 to 1.02 with 16
SLOPE, SLOPE_DILATING = 1.0, 0.006      # SLOPE_DILATING for each square of a degree of ψ


def upright_cut(scene, model):
    """Steps of the ground in soil with cohesion and weight, without bodies, in plane strain, so few cells high that they
    stand under too much gravity."""
    soil = model.soil
    if soil.held or scene.bodies or not np.any(scene.gravity) or soil.grid.collapsed.sum() != 1:
        return
    height, cell = step_of_ground(scene, soil), soil.grid.smallest_cell
    material = material_at(scene, soil, top_of(soil) - height + 0.5 * cell)
    if height <= STEEP * cell or material.law not in (CLAY, *SAND) or material.law in SAND and not material.cohesion:
        return
    number = CUT + (0.0 if material.law == CLAY else DILATING * (material.dilation_angle or 0.0))
    if number * cell / height > EXCESS:
        kind = "clay" if material.law == CLAY else "soil with friction"
        yield (f"the ground has an upright step {height:.3g} m high, {height / cell:.2g} cells of {cell:.3g} m, in {kind}: "
               f"the weight under which it stands is about {number * cell / height:.0%} too high, limit {EXCESS:.0%}. Use "
               f"cells of at most {EXCESS / number * height:.2g} m")


def frictional_slope(scene, model):
    """Slopes of the ground steeper than the friction angle of soil with cohesion, without bodies, in plane strain, so few
    cells high that they stand under too much gravity."""
    soil = model.soil
    if soil.held or scene.bodies or not np.any(scene.gravity) or soil.grid.collapsed.sum() != 1 or scene.soil.ground is None:
        return
    cell, material = soil.grid.smallest_cell, material_at(scene, soil, top_of(soil))
    if material.law not in SAND or not material.cohesion or step_of_ground(scene, soil):
        return
    height, slope = _steep_part(scene, soil, np.tan(np.radians(material.friction_angle)))
    if not height:
        return
    number = max(SLOPE, SLOPE_DILATING * (material.dilation_angle or 0.0) ** 2)
    if number * cell > EXCESS * height:
        yield (f"the ground has a slope of {slope:.3g} degrees, {height:.3g} m and {height / cell:.2g} cells high, in soil "
               f"with friction: the weight under which it stands is about {number * cell / height:.0%} too high, limit "
               f"{EXCESS:.0%}, the more the soil dilates. Use cells of at most {EXCESS / number * height:.2g} m")


def _steep_part(scene, soil, least):
    """(Height [m], mean slope [degrees]) of the highest part of the ground in the grid that is steeper than `least` [-]
    throughout; (0, 0) where there is none."""
    x, y, z = heights(scene.soil.ground)
    if y is not None or soil.grid.collapsed[0]:
        return 0.0, 0.0
    start, end = soil.grid.extent[0]
    at = np.unique(np.concatenate([[start, end], x[(x > start) & (x < end)]]))
    rise, run = np.diff(heights_at((x, y, z), at[:, None])), np.diff(at)
    steep = np.where(np.abs(rise) > least * run, np.sign(rise), 0.0)
    parts = np.split(np.arange(len(run)), np.flatnonzero(np.diff(steep)) + 1)
    found = [(abs(rise[part].sum()), run[part].sum()) for part in parts if steep[part[0]]]
    height, length = max(found, default=(0.0, 1.0))
    return float(height), float(np.degrees(np.arctan2(height, length)))


LIMITS = (upright_cut, frictional_slope)
