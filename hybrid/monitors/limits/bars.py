"""Bases with holes, rings and frames on clay, whose bars are so few cells wide that they drive the clay of the next cells
too, whatever the width of the whole.

    1 + 0.7/n           n cells in the mean width of the bars, twice the area of the base over the length of all its edges

a little more than of a strip with both edges on lines of the grid (`cells`). A mat of 1.6 m with four holes, pressed by
15 mm, E = 1000 s_u, over what both sizes of cells extrapolate to; a ring of 1.6 m with bars of 0.2 m, over 5.14 s_u A:

| base             | n            | found [%] |
|------------------|--------------|-----------|
| holes of 0.6 m   | 1.4, 2.8     | 48, 23    |
| holes of 0.4 m   | 3, 6         | 12, 6     |
| ring             | 2, 4         | 19, 14    |
"""

import numpy as np
from scipy.spatial import ConvexHull

from hybrid.monitors.limits.cell_size import EXCESS, smaller_cells
from hybrid.monitors.limits.loading import loadings
from hybrid.monitors.limits.materials import CLAY, law_at
from hybrid.monitors.limits.shape import feet
from hybrid.monitors.limits.start import top_of

PER_CELL = 0.7
DOWN = 0.5          # of a travel: what goes down by less is pushed sideways
FRAMED = 1.25       # times the convex outline: edges of a base with holes, or of a cross; an L has 1.08


def bars(scene, model):
    """Bodies pressed on clay with a base of bars, so few cells wide that their load is more than EXCESS too high."""
    soil = model.soil
    if soil.held or soil.grid.collapsed.any():
        return
    cell = soil.grid.resolution
    for body, travel, place, plane, *_ in loadings(scene, model):
        down = plane and travel[2] <= -DOWN * np.linalg.norm(travel)
        if not down or law_at(scene, soil, place[:, 2].min() - 0.5 * cell) != CLAY:
            continue
        width = min((_bar(body, *foot) for foot in feet(body, place, travel, top_of(soil))), default=np.inf)
        if PER_CELL * cell / width > EXCESS:
            yield (f"{body.name} presses clay with a base of bars {width / cell:.2g} cells of {cell:.3g} m wide on average, "
                   f"twice its area over the length of its edges: its load is up to {PER_CELL * cell / width:.0%} too high, "
                   f"limit {EXCESS:.0%}, as they drive the clay of the next cells too. "
                   f"{smaller_cells(EXCESS / PER_CELL * width, ' under it')}")


def _bar(body, area, edges, foot):
    """Mean width [m] of the bars of a base of an `area` [m²] with `edges` [m] and vertices at `foot` (V, 3) [m], inf where
    it has none."""
    whole = edges
    for mirror in (one for one in body.mirrors if one.cut):
        other, axis = foot.copy(), "xyz".index(mirror.axis)
        other[:, axis] = 2.0 * mirror.at - foot[:, axis]
        foot, whole = np.concatenate([foot, other]), 2.0 * whole
    around = ConvexHull(foot[:, :2]).area   # of a plane figure, its perimeter
    return 2.0 * area / edges if whole > FRAMED * around else np.inf


LIMITS = (bars,)
