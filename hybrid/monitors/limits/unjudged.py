"""Bodies too few cells wide for their load to be predicted, where no other limit gives an error.

A block of 0.7 m x 0.5 m pushed 0.12 m into clay and as far forwards, in cells of 0.25 m: 3.6 kN along its path,
forwards, and 7 kN across it, where symmetry has none; with half the cells -7.7 and 2.5 kN, and a quarter less
downwards. A smooth square of 3 cells bears 12 % too much, of 4 cells 2 %. A strip on legs of 1.25 cells, pushed in by half a
leg's depth: a third more than with half the cells.
"""

import numpy as np

from hybrid.monitors.limits.loading import loadings, to_failure
from hybrid.monitors.limits.shape import feet, heading, narrowest
from hybrid.monitors.limits.start import top_of
from hybrid.runtime.comm import anywhere

FEW = 4.0       # cells across the travel of a body
ROUNDED = 0.97  # of FEW, that cells of the size that a text gives may have
AHEAD = 2.0     # cells that a body pushes beyond its path
BARELY = 0.05   # cells: bodies that go less deep hardly move the soil


def unjudged(scene, model, messages):
    """Bodies less than FEW cells wide across their path through soil that yields; messages: texts of other limits."""
    cell = model.soil.grid.smallest_cell
    found = {_subject(text, model.bodies) for text in messages if " cell" in text}
    for body, travel, place, plane, by_force, *_ in to_failure(scene, model, loadings(scene, model)):
        moved = cell * travel / np.linalg.norm(travel) if by_force else travel
        legs = feet(body, place, moved, top_of(model.soil)) if plane and travel[2] < 0.0 else []
        parts = [leg for *_, leg in legs] if len(legs) > 1 else [place]
        widths = [narrowest(model.soil.grid, part, travel) for part in parts]
        across = min((width for width in widths if width), default=0.0)     # a mirrored leg is outside of the grid
        deep = top_of(model.soil) - place[:, 2].min() - min(moved[2], 0.0)
        few = 0.0 < across < FEW * ROUNDED * cell and deep > BARELY * cell
        if few and body.name not in found and _pushes(model.soil, place, moved):
            found.add(body.name)
            subject = f"{body.name} has {len(parts)} parts ahead, one" if len(parts) > 1 else f"{body.name} is"
            yield (f"{subject} {across / cell:.2g} cells of {cell:.3g} m wide across its path {heading(travel)}, limit "
                   f"{FEW:g}: too few to predict its load (a block of 2 and 3 cells pushed into clay: a quarter too much "
                   "downwards, and the wrong sign sideways). Use cells of at most "
                   f"{across / FEW:.2g} m at it, and compare two sizes of cells")


def _pushes(soil, place, moved):
    """Whether there is soil in front of a body with vertices at `place` (V, 3) [m] that is `moved` (3,) [m]: of a belt under
    sand there is none."""
    at, ahead = soil.constants.position, moved + AHEAD * soil.grid.smallest_cell * np.sign(moved)
    low, high = place.min(axis=0), place.max(axis=0)
    inside = ((at > low) & (at < high)) | soil.grid.collapsed
    swept = ((at > low + np.minimum(ahead, 0.0)) & (at < high + np.maximum(ahead, 0.0))) | soil.grid.collapsed
    return anywhere(swept.all(axis=1) & ~inside.all(axis=1))


def _subject(text, bodies):
    """Name of the body that a text begins with; of two the longer one; "" of none."""
    return max((body.name for body in bodies if text.startswith(f"{body.name} ")), key=len, default="")
