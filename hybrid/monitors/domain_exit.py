"""Bodies that leave the grid: there is no soil beyond it, so their contact ends there.

A body that is driven past an end is meant to go there, and is only reported. One that is pulled, rolls or falls there
stops the run: what it would do next does not depend on the soil any more. Its state is kept. A body that flies above
the soil goes on, until it is below its surface.

A body leaves the grid when a vertex of its surface passes a face of the grid that none had passed or touched at the start:
a block as wide as the column that it stands on breathes with the column. The
upper face does not count, nor do faces along a collapsed axis; a platen wider than the grid from the start is intended.
"""

import numpy as np

from hybrid.body import rigid
from hybrid.monitors.monitor import Monitor
from hybrid.runtime.comm import anywhere

SLACK = 0.01         # of the smallest cell: less than that past a face is as good as flush with it
FACES = tuple((axis, side) for axis in range(3) for side in (0, 1) if (axis, side) != (2, 1))


class DomainExit(Monitor):
    """Warns once for each body and face of the grid that the body passes; stops where nothing drives it there."""

    def __init__(self, model, state):
        super().__init__(model, state)
        self._from_the_start = {(b, face) for b, face, _, _ in _beyond(model, state.bodies, -SLACK)}
        self._given |= self._from_the_start

    def warnings(self, view):
        """Body, time, place, limit and remedy."""
        for b, face, reached, end in _beyond(view.model, view.state.bodies):
            yield (b, face), _text(view.model.bodies[b].name, view.state.time, face, reached, end)

    def stops(self, view):
        """The same for a body that is free along that axis, and on the soil or below its surface."""
        for b, face, reached, end in _beyond(view.model, view.state.bodies):
            body = view.model.bodies[b]
            if not body.free[face[0]] or (b, face) in self._from_the_start:
                continue
            lowest = rigid.bounding_box(body, view.state.bodies[b])[0, 2]
            if anywhere([len(view.contacts[b])]) or lowest < view.surface():
                yield _text(body.name, view.state.time, face, reached, end)


def _beyond(model, bodies, slack=SLACK):
    """Yield (body, (axis, side), coordinate the body reaches, coordinate of the face) [m] for each face passed by `slack`
    cells."""
    grid = model.soil.grid
    least = slack * grid.smallest_cell
    for b, (body, state) in enumerate(zip(model.bodies, bodies)):
        if _ball_is_inside(grid, body, state):
            continue
        box = rigid.bounding_box(body, state)
        for axis, side in FACES:
            reached, end = box[side, axis], grid.extent[axis, side]
            if not grid.collapsed[axis] and (reached - end) * (2 * side - 1) > least:
                yield b, (axis, side), reached, end


def _ball_is_inside(grid, body, state):
    """Whether the ball about a body passes none of FACES: it is found in a hundredth of the time of the surface's box."""
    low, high = state.position - body.radius > grid.extent[:, 0], state.position + body.radius < grid.extent[:, 1]
    return bool((grid.collapsed | low & (high | (np.arange(3) == 2))).all())


def _text(name, time, face, reached, end):
    axis, side = "xyz"[face[0]], ("start", "end")[face[1]]
    return (f"{name} leaves the grid: at t = {time:.4g} s its surface reaches {axis} = {reached:.4g} m, limit {axis} = "
            f"{end:.4g} m, where the grid ends. There is no soil beyond, so the body has no contact there. Move "
            f"grid.{axis}.{side} outwards, or end the run earlier")
