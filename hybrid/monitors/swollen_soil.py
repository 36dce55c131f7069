"""Sand that has opened and carries pressure again without having closed.

Points of sand that lose all pressure are pulled apart by the grid; where they are pressed again, they resist at once,
at the volume that they have then. Sand without dilation of φ = 33° that fell 0.5 m on a plate came to rest with 1.23 of
its volume, a column 1.8 times as high as wide with 1.14, and a ram that was dropped six times on sand rose by 53 mm
above the ground. Slides, walls and a column that runs out against a wall have less than 1.02.
"""

import numpy as np

from hybrid.monitors.monitor import Monitor
from hybrid.runtime.comm import anywhere, total

# Of the volume of sand under pressure: of sand without dilation, and of sand that dilates where it is sheared
SWOLLEN, DILATES = 0.02, 0.1
EVERY = 10          # steps


class SwollenSoil(Monitor):
    """Warns once of sand that is larger than at the start, by more than its dilation gives."""

    grows = True

    def warnings(self, view):
        """Share, limit and what it means."""
        model, points = view.model, view.state.points
        if not view.scheme.inertia or model.soil.held or not (view.last or view.state.step % EVERY == 0):
            return
        sand, limit = _sand(model.soil.law)
        if not anywhere(sand):
            return
        pressed = sand & (np.trace(points.stress, axis1=1, axis2=2) < 0.0)
        if points.inactive is not None:
            pressed &= ~points.inactive
        volume = model.soil.constants.volume[pressed]
        before, after = (float(total(v)) for v in (volume, volume * np.linalg.det(points.deformation[pressed])))
        if after > limit * before:
            yield "swollen", (
                f"sand has swollen: what carries pressure at t = {view.state.time:.4g} s has {after / before:.2f} of its "
                f"volume at the start, limit {limit:g}. Soil that has opened, as where "
                "it falls, splashes or is lifted, does not close again when it is pressed: heaps are too high, and bodies "
                "on it stand too high. Forces and run-out of what has not opened are not concerned")


def _sand(law):
    """(n,) bool, points of a cone with friction, and the volume from which on they are swollen; none of other laws."""
    if not law.plastic or not hasattr(law, "undrained") or not hasattr(law, "parameters"):
        return np.zeros(0, bool), np.inf
    slope, dilation = law.parameters[:, 2:4].T
    sand = ~law.undrained & (slope > 0.0)
    return sand, 1.0 + (DILATES if anywhere(sand & (dilation > 0.0)) else SWOLLEN)
