"""Bodies that leave the grid: beyond it there is no soil, so their contact ends there and the user should know.

A body leaves when a vertex of its surface passes a face of the grid that none had passed at the start. Upwards that is
nothing to speak of, along a collapsed axis it means nothing, and a platen wider than the soil is meant so.
"""

from hybrid.body import rigid

FACES = tuple((axis, side) for axis in range(3) for side in (0, 1) if (axis, side) != (2, 1))


class Leaving:
    """Says once for each body and face of the grid that the body has left there."""

    def __init__(self, model, bodies):
        """bodies: their states at the start."""
        self._said = {(b, face) for b, face, _, _ in _beyond(model, bodies)}

    def notes(self, model, state):
        """Texts about what has left since the last call: body, time, place, limit and remedy."""
        found = [left for left in _beyond(model, state.bodies) if left[:2] not in self._said]
        self._said |= {left[:2] for left in found}
        return tuple(_text(model.bodies[b].name, state.time, face, at, end) for b, face, at, end in found)


def _beyond(model, bodies):
    """Yield (body, face, coordinate it reaches, coordinate of the face) [m]."""
    grid = model.soil.grid
    slack = 1e-6 * grid.smallest_cell
    for b, (body, state) in enumerate(zip(model.bodies, bodies)):
        place = rigid.bounding_box(body, state)
        for axis, side in FACES:
            at = place[side, axis]
            end = grid.extent[axis, side]
            if not grid.collapsed[axis] and (at - end) * (2 * side - 1) > slack:
                yield b, (axis, side), at, end


def _text(name, time, face, at, end):
    axis, side = "xyz"[face[0]], ("start", "end")[face[1]]
    return (f"{name} leaves the grid: at t = {time:.4g} s it reaches {axis} = {at:.4g} m, the grid ends at "
            f"{axis} = {end:.4g} m. There is no soil beyond, so its contact ends there; move grid.{axis}.{side} "
            "outwards, or stop the run earlier")
