"""Bodies that are in the soil where no corner of it meets them: smaller than the spacing of corners, or sharp.

The first pass of contact sees the soil at the corners of its points' domains only. A vertex of a body that touches
nothing, and is deeper in a domain than DEPTH of its height, has come between them. That matters where it is as much as
PART of the body's radius: the tip of a large anchor comes between corners wherever it lands, until its flukes meet
some.
"""

import numpy as np
from scipy.spatial import cKDTree

DEPTH = 0.25    # of a domain: sharp edges have no force there yet, spheres of twice the spacing touch at half of it
PART = 0.05


class Between:
    """Says once for each body that it has come between the corners."""

    def __init__(self):
        self._said = set()

    def notes(self, model, state, contacts, scheme=None):
        """Texts about bodies that have, by the Contacts that led to `state`."""
        texts = []
        for b, (body, motion, contact) in enumerate(zip(model.bodies, state.bodies, contacts)):
            if b in self._said or len(contact) or body.second_pass == 1.0 or model.soil.basis != "gimp":
                continue
            deep, way = _deepest(body, motion, state.points, ~model.soil.grid.collapsed)
            if deep > DEPTH and way > PART * body.radius:
                self._said.add(b)
                texts.append(
                    f"{body.name} is between the corners of the soil: at t = {state.time:.4g} s it is {deep:.2g} of a "
                    f"point's domain deep and touches nothing, limit {DEPTH:g}. Where it is sharp or small the soil "
                    "does not resist; set body.second_pass = 1, or use smaller cells")
        return tuple(texts)


def _deepest(body, motion, points, across):
    """How deep the deepest vertex of a body is in its domain, from above, [-] and [m]; 0 where none is in one."""
    place = motion.position + body.surface.vertices @ motion.rotation.T
    lower, upper = place.min(axis=0), place.max(axis=0)
    near = _within(points, lower, upper, across)
    if len(near) == 0:
        return 0.0, 0.0
    position, half = points.position[near], points.half_width[near]
    scale = half.mean(axis=0)
    _, at = cKDTree(position * across / scale).query(place * across / scale, p=np.inf)
    away = place - position[at]
    inside = ((np.abs(away) < half[at]) | ~across).all(axis=1)
    deep = np.where(inside, 0.5 * (1.0 - away[:, 2] / half[at, 2]), 0.0)
    vertex = deep.argmax()
    return float(deep[vertex]), float(deep[vertex] * 2 * half[at[vertex], 2])


def _within(points, lower, upper, across):
    """Numbers of the points whose domains meet the box from `lower` to `upper` (3,) [m] along the axes `across`; from
    above, as a body in the air is above all of them."""
    near = np.arange(len(points)) if points.inactive is None else np.flatnonzero(~points.inactive)
    for axis in np.flatnonzero(across)[::-1]:
        x, half = points.position[near, axis], points.half_width[near, axis]
        near = near[(x + half > lower[axis]) & (x - half < upper[axis])]
    return near
