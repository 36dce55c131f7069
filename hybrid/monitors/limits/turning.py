"""Bodies that are turned in clay: torque of few cells, measured in space on a vane with D = H and a round pile, set up
afresh.

    vane that clay sticks to                 (1 + 1.3/n)³        n cells in its diameter: 1.65, 1.43 with 7, 10;
                                                                  2.44 with 5, whose blades are a cell thick
    round pile along which clay slips        -13, -6, +12 %      with 4, 6, 8 in its diameter, α = 0.5, length 1.5 D;
                                                                  -25 % with 4 where α = 1

Between blades clay is sheared in the cell beyond them (`cells`), so that the torque is that of a body 1.3 cells larger.
Along a round body it slips, at its outline, and the torque depends on where lines of the grid cut that.
"""

import numpy as np

from hybrid.monitors.limits.stages import stride_of
from hybrid.monitors.limits.loading import CLAY, EXCESS, law_at, outline, top_of

SHEARED = 1.3                   # cells by which the sheared surface is wider, and longer, than the body
BLADES = 0.1                    # share of its surface with which a body pushes soil as it turns; of a round one 0
SLIPPING = 16.0                 # cells in the diameter of a round body, twice the most that were measured


def turned(scene, model):
    """Bodies in clay that are turned, or that a moment turns, with so few cells in them that the torque is more than
    EXCESS too high."""
    soil = model.soil
    if soil.held or not soil.law.plastic or soil.grid.collapsed.any():
        return
    for described, body in zip(scene.bodies, model.bodies):
        axes = [axis for axis in range(3) if _turns(scene, described, body, axis)]
        whole, place = outline(described, body, soil)
        top = top_of(soil)      # what stands above the ground bears nothing
        place = np.column_stack([place[:, :2], np.minimum(place[:, 2], top)])
        middle = 0.5 * (place[:, 2].min() + place[:, 2].max())
        if middle >= top or law_at(scene, soil, middle) != CLAY:
            continue
        for axis in axes:
            yield from _torque(whole, place, axis, soil.grid.smallest_cell)


def _turns(scene, described, body, axis):
    """Whether a body is driven about an axis, or free to follow a moment of a stage about it."""
    if not body.guided[3 + axis]:
        return any(load.moment is not None and np.any(load.moment.values[:, axis]) for stage in body.stages or ()
                   for load in stage.loads)
    return any(stride_of(scene, stage, described, f"r{'xyz'[axis]}") > 0.0 for stage in scene.stages)


def _torque(body, place, axis, cell):
    """Text, if any, about the torque on a body with its vertices at `place` about an axis."""
    sizes = np.ptp(place, axis=0)
    length, across = sizes[axis], np.delete(sizes, axis).max()
    begin = f"{body.name} is turned about {'xyz'[axis]} in clay, {across / cell:.2g} cells of {cell:.3g} m across"
    if _pushes(body, place, axis) > BLADES:
        excess = (1.0 + SHEARED * cell / across) ** 2 * (1.0 + SHEARED * cell / length) - 1.0
        if excess > EXCESS:
            yield (f"{begin}, and shears it in the next cell: its torque is about {excess:.0%} too high, limit "
                   f"{EXCESS:.0%}, that of a body {SHEARED:g} cells wider and longer. Use cells of at most "
                   f"{EXCESS / SHEARED / (2 / across + 1 / length):.2g} m at the body, or take the diameter as "
                   f"{across + SHEARED * cell:.3g} m and the length as {length + SHEARED * cell:.3g} m where s_u follows "
                   "from the torque")
    elif body.interface and body.interface.adhesion and across < SLIPPING * cell:
        yield (f"{begin}, limit {SLIPPING:g}, and the clay slips along its round side: the torque of a pile was 13 % and "
               "6 % too low with 4 and 6 cells, and 12 % too high with 8, with half the clay's strength on it. Use cells "
               f"of at most {across / SLIPPING:.2g} m at the body, or compare several sizes of cells")


def _pushes(body, place, axis):
    """Share of a body's surface that it moves towards the soil, or away from it, as it turns about an axis through the
    middle of its outline."""
    corners = place[body.surface.triangles]
    normal = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    arm = corners.mean(axis=1) - 0.5 * (place.min(axis=0) + place.max(axis=0))
    travel = np.cross(np.eye(3)[axis], arm)
    travel /= np.maximum(np.linalg.norm(travel, axis=1), 1e-12 * np.ptp(place, axis=0).max())[:, None]
    return np.abs((normal * travel).sum(axis=1)).sum() / np.linalg.norm(normal, axis=1).sum()


LIMITS = (turned,)
