"""Waves that a body which swings on soil, or in it, sends out, and which come back from the sides of the grid.

No end of the grid lets waves through: rollers, held nodes and free faces throw all of them back. A strip of 2 m on elastic
ground, c_s = 105 m/s, shaken with 15 Hz; half peak to peak in each period, 79 μm without ends:

| soil beside it and below | periods 1 to 8, μm                         |
|--------------------------|--------------------------------------------|
| 15 widths                | 83  79  79  79  80  69                     |
| 6 widths                 | 83  80  61  62 104  83  66  47             |
| 3 widths                 | 84  45 120 111 131 156 132 128             |

Soil that a body covers from side to side is a column, whose waves only go up and down.
"""

import numpy as np

from hybrid.laws.hencky import BULK, SHEAR
from hybrid.monitors.limits.stages import swinging_tables
from hybrid.monitors.limits.start import outline, top_of
from hybrid.runtime.comm import maximum, minimum
from hybrid.soil.points import extent

# Periods over the time of a shear wave to the end and back, above which soil follows as without inertia: a strip shaken in
# 50 of that of a compression wave moved by as much, and by 1 % more with twice the soil beside it
SLOW = 4.0
BESIDE = 1.0        # cells of soil beside a body that cover it to the side


def returning_waves(scene, model):
    """Bodies with a load or a motion that swings while waves come back from the sides of the soil."""
    soil = model.soil
    if soil.held or not model.scheme.inertia or soil.law.parameters is None:
        return
    speed, shear_speed = _wave_speeds(soil)
    for described, body in zip(scene.bodies, model.bodies):
        swings = [(scene.step_of(stage) * stage.steps, periods) for s, stage in enumerate(scene.stages)
                  for _, periods, _, name in swinging_tables(scene, s) if name in (None, described.name)]
        _, place = outline(described, body, soil)
        if not swings or place[:, 2].min() > top_of(soil) + soil.grid.smallest_cell:
            continue
        ways = _ways_to_ends(soil, place)
        if not ways:
            continue
        way, name, end = min(ways)
        back = 2.0 * way / speed
        fast = [lasts for lasts, periods in swings if back < lasts < SLOW * periods * 2.0 * way / shear_speed]
        if fast:
            lasts = max(fast)
            yield (f"{body.name} swings for {lasts:.3g} s, and its waves come back from the end of the soil at {name} = "
                   f"{end:.4g} m after {back:.2g} s, as no end of the grid lets them through: a shaken strip moved by "
                   "40 % too little to 30 % too much with 6 widths of soil beside it, up to twice as much with 3. Where "
                   f"the ground goes on, give the soil {0.5 * lasts * speed:.3g} m on each side and below, in cells that "
                   "grow outwards, or look at the time before that only")


def _wave_speeds(soil):
    """Largest speed [m/s] of compression waves in the soil, and smallest one of shear waves."""
    bulk, shear = soil.law.parameters[:, [BULK, SHEAR]].T
    volume = soil.constants.volume / soil.constants.mass
    return maximum(np.sqrt((bulk + 4.0 / 3.0 * shear) * volume)), minimum(np.sqrt(shear * volume))


def _ways_to_ends(soil, place):
    """[(way [m], axis, end [m])] from a body with its vertices at `place` (V, 3) to the sides of the soil that it does not
    reach, as it does a plane of symmetry that it lies in."""
    found = []
    for axis in np.flatnonzero(~soil.grid.collapsed[:2]):
        low, high = extent(soil.constants, axis)
        for way, end in ((place[:, axis].min() - low, low), (high - place[:, axis].max(), high)):
            if way > BESIDE * soil.grid.smallest_cell:
                found.append((float(way), "xy"[axis], float(end)))
    return found


LIMITS = (returning_waves,)
