"""A grid that goes along with driven bodies through the soil (`hybrid.grid.carried_axis`).

Its nodes keep their numbers, and what holds them. It has no state: where the bodies are, and how fast, says where it is. At
the end of a step bodies lie within its cells as at the start, with edges on lines of the grid or beside them.
"""

from dataclasses import replace

import numpy as np

from hybrid.soil.domains import updated_half
from hybrid.step import processes


class CarriedGrid:
    """How the grid of a scene goes along.

    axes     {number of an axis: CarriedAxis, or None for one whose cells the `moving` grid lays out around its body}
    start    (3,) [m] place at the start of body 0, whose displacement along these axes all bodies share
    moving   MovingGrid, or None
    """

    def __init__(self, axes, start, moving):
        self._axes, self._start, self._moving = axes, start, moving

    @property
    def names(self):
        """Names of the axes along which it goes."""
        return ["xyz"[axis] for axis in self._axes]

    def follow(self, model, state, workspace, length):
        """(Model, State) of a stage with the grid where the bodies will have gone after a step of this `length` [s]; of
        several processes each then has the points in its block of it."""
        body, lines = state.bodies[0], list(model.soil.grid.lines)
        way = body.position + length * body.velocity - self._start
        for axis, carried in self._axes.items():
            carried = carried or self._moving.carried_axis(axis, model, state)
            lines[axis] = carried.at(way[axis])
        if not all(map(np.array_equal, lines, model.soil.grid.lines)):
            model = processes.with_nodes_at(model, tuple(lines))
            workspace.follow_points(model)
            workspace.systems.assemble_afresh()
        points = state.points
        half = updated_half(model.soil.domain, model.soil.constants.half_width, points.deformation, points.position, lines)
        return processes.settle(model, replace(state, points=replace(points, half_width=half)), workspace)
