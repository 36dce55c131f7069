"""Bodies inside the soil where no corner touches them: smaller than the spacing of corners, or sharp.

Contact at corners samples the soil at the corners of its points' domains only. A body without contact has missed
them if one of its vertices is deeper in a domain than DEPTH of the domain's height. That matters where the depth is at
least PART of the body's radius: the tip of a large anchor lies between corners wherever it lands, until its flukes
touch some.
"""

import numpy as np
from scipy.spatial import cKDTree

from hybrid.monitors.monitor import Monitor
from hybrid.runtime.comm import anywhere, maximum

DEPTH = 0.25    # of a domain: sharp edges have no force there yet, spheres of twice the spacing touch at half of it
PART = 0.05


class MissedContact(Monitor):
    """Warns once for each body that is inside the soil without contact."""

    def warnings(self, view):
        """Body, depth, limit and remedy."""
        soil = view.model.soil
        for b, body, motion, contact in view.bodies:
            if self.given(b) or anywhere([len(contact)]) or not body.places.at_corners or soil.basis != "gimp":
                continue
            found = _deepest(body, motion, view.state.points, ~soil.grid.collapsed)
            share, depth = (maximum([value]) for value in found)
            if share > DEPTH and depth > PART * body.radius:
                yield b, (
                    f"{body.name} is inside the soil without contact: at t = {view.state.time:.4g} s its deepest "
                    f"vertex is {share:.2g} of a point domain's height below the top of that domain, limit {DEPTH:g}. "
                    "It lies between the corners of the domains, so that no force stops the body. Set "
                    'body.contact = "faces", or use smaller cells')


def _deepest(body, motion, points, across):
    """Depth of a body's deepest vertex below the top of its domain, over the domain's height [-] and in [m]; 0 where no
    vertex is in a domain. across: (3,) bool, axes that are not collapsed."""
    place = motion.position + body.surface.vertices @ motion.rotation.T
    lower, upper = place.min(axis=0), place.max(axis=0)
    ids = _within(points, lower, upper, across)
    if len(ids) == 0:
        return 0.0, 0.0
    position, half = points.position[ids], points.half_width[ids]
    scale = half.mean(axis=0)
    _, nearest = cKDTree(position * across / scale).query(place * across / scale, p=np.inf)
    offset = place - position[nearest]
    inside = ((np.abs(offset) < half[nearest]) | ~across).all(axis=1)
    share = np.where(inside, 0.5 * (1.0 - offset[:, 2] / half[nearest, 2]), 0.0)
    vertex = share.argmax()
    return float(share[vertex]), float(share[vertex] * 2 * half[nearest[vertex], 2])


def _within(points, lower, upper, across):
    """Ids of the active points whose domains intersect the box from `lower` to `upper` (3,) [m] along the axes
    `across`; z first, as a body in the air is above all points."""
    ids = np.flatnonzero(points.active)
    for axis in np.flatnonzero(across)[::-1]:
        x, half = points.position[ids, axis], points.half_width[ids, axis]
        ids = ids[(x + half > lower[axis]) & (x - half < upper[axis])]
    return ids
