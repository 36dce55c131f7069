"""Soil that spreads until it reaches an end of the grid where rollers or fixed nodes hold it.

A specimen of clay, 0.5 m of a half model in cells of 0.125 m, pressed together with 0.25 m of empty grid beside it: its load
was right until it had spread to the last cell, then 11 times too large after 3 % more. With inertia soil that runs out
stops there, which may be a wall that is meant: a column of clay 2 m high came to rest at the end of the grid, 4 m away,
and ran 0.9 m farther on a longer one.
"""

import numpy as np

from hybrid.monitors.monitor import Monitor
from hybrid.runtime.comm import anywhere, maximum, minimum

FACES = tuple((axis, side) for axis in (0, 1) for side in (0, 1))


class GridEnd(Monitor):
    """Warns once for each side of the grid that holds soil which did not reach it at the start."""

    def __init__(self, model, state):
        super().__init__(model, state)
        # one number a face: 1 where soil is apart from one that would hold it
        self._apart = [0] * 4 if state is None or model.soil.held else [
            int(gap > cell and _holds(model.soil.grid, *face)) for face, (gap, cell) in _gaps(model.soil.grid, state.points)]
        self._extent = [] if state is None else model.soil.grid.extent.tolist()    # a grid that moves has another one later

    def warnings(self, view):
        """Time, place and remedy."""
        if not any(self._apart):
            return
        grid = view.model.soil.grid
        for apart, ((axis, side), (gap, cell)) in zip(self._apart, _gaps(grid, view.state.points)):
            if apart and gap < cell and grid.extent[axis, side] == self._extent[axis][side]:
                name, end = "xy"[axis], ("start", "end")[side]
                wrong = "it runs no farther" if view.scheme.inertia else "forces are too large"
                yield (axis, side), (
                    f"soil has spread to the last cell before the end of the grid at {name} = "
                    f"{grid.extent[axis, side]:.4g} m at t = {view.state.time:.4g} s, and is held there from now on, which "
                    f"it was not at the start: {wrong}. Move grid.{name}.{end} outwards, unless that is a wall")


def _holds(grid, axis, side):
    """Whether all nodes of a face of the grid are held along its normal: those of a free one are on a fixed base alone."""
    at = grid.axes[axis] == grid.extent[axis, side]
    return not grid.collapsed[axis] and not anywhere(
        ~np.moveaxis(grid.fixed.reshape(*grid.shape, 3)[..., axis], axis, 0)[at])


def _gaps(grid, points):
    """[((axis, side), (gap, cell))] [m] between the soil and each side of the grid, and the size of the last cell there."""
    active = points.active
    found = []
    for axis, side in FACES:
        position, half = points.position[active, axis], points.half_width[active, axis]
        gap = minimum(position - half, np.inf) - grid.extent[axis, 0] if side == 0 else (
            grid.extent[axis, 1] - maximum(position + half, -np.inf))
        nodes = grid.lines[axis] if len(grid.lines[axis]) > 1 else grid.extent[axis]
        found.append(((axis, side), (gap, abs(nodes[-1] - nodes[-2]) if side else abs(nodes[1] - nodes[0]))))
    return found
