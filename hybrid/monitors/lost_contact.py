"""Bodies that fall beside or through the soil: what follows is free fall, which no result depends on.

Gravity or a load draws such a body down, nothing touches it, all of it is below the surface of the soil, and there is
neither soil under or over it nor another body under it, or its centre lies in a point's domain. A body above the soil or
another body, in a pit, or lifted out of the soil is none.
"""

import numpy as np

from hybrid.body import rigid
from hybrid.monitors.monitor import Monitor
from hybrid.runtime.comm import anywhere


class LostContact(Monitor):
    """Stops a run when a body is lost."""

    def stops(self, view):
        """Body, time, place and remedy."""
        collapsed, points, active = view.model.soil.grid.collapsed, view.state.points, view.state.points.active
        falling = [(b, body, motion) for b, body, motion, contact in view.bodies
                   if not anywhere([len(contact)]) and body.free[2] and motion.velocity[2] < 0.0]
        if not falling:
            return
        boxes = np.array([rigid.bounding_box(body, motion) for _, body, motion, _ in view.bodies])
        for b, body, motion in falling:
            surface = view.surface()
            falls = _drawn_down(view, body)
            if boxes[b, 1, 2] < surface and _lost(points, active, boxes, b, motion.position, collapsed, falls):
                yield (f"{body.name} falls free at z = {motion.position[2]:.4g} m, below the surface of the soil at "
                       f"{surface:.4g} m, and nothing touches it: at t = {view.state.time:.4g} s it is beside the soil "
                       "or has gone through it. Start it above the soil (body.position), widen the grid, or use a "
                       "smaller time.step")


def _drawn_down(view, body):
    """Whether gravity and loads draw a body down."""
    force = body.mass.mass * view.model.loads.on_bodies(view.state.time)
    return force[2] + sum(load.at(view.state.time)[0][2] for load in body.loads) < 0.0


def _lost(points, active, boxes, b, centre, collapsed, falls):
    """Whether it `falls`, and neither a point (n,) is under or over body b nor another body under it, or a point has the
    body's `centre` (3,) [m] in its domain. boxes: (nb, 2, 3) [m] of the bodies."""
    x, half = points.position, points.half_width
    level = np.array([not collapsed[0], not collapsed[1], False])
    over = ((x + half > boxes[b, 0]) & (x - half < boxes[b, 1]) | ~level).all(axis=1) & active
    inside = ((np.abs(x - centre) < half) | collapsed).all(axis=1) & active
    return anywhere(inside) or falls and not (anywhere(over) or _will_land(boxes, b, level))


def _will_land(boxes, b, level):
    """Whether another body is under body b; level: (3,) bool, axes along which bodies can lie beside one another."""
    box, others = boxes[b], np.delete(boxes, b, axis=0)
    over = ((others[:, 1] > box[0]) & (others[:, 0] < box[1]) | ~level).all(axis=1)
    return bool((over & (others[:, 0, 2] < box[0, 2])).any())
