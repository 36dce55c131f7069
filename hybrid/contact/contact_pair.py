"""Contact of one rigid body with the soil during a step: points on the soil's surface against the body's surface.

    ∫ p_f E g dA  over the soil's surface, by the contact points near the body        `hybrid.contact.contact_points`
    those that press, and the law of penalty and friction at each of them            `hybrid.contact.soil_to_body`, `law`
    their forces and tangent in the block system                                     `hybrid.contact.assembly`
"""

from contextlib import contextmanager
from copy import copy
from dataclasses import replace

import numpy as np

from hybrid.contact import assembly, held_facets, soil_to_body, tunnelling
from hybrid.contact.contact_points import find_contact_points
from hybrid.contact.interface import RAMP
from hybrid.contact.pair import Pair
from hybrid.runtime.comm import total

TINY = 1e-300       # [N]


class ContactPair(Pair):
    """A body and the contact points near it, those of `find_contact_points`."""

    def __init__(self, soil, body, state, history, reach, expected, limits=None, begins=False):
        """As find_contact_points."""
        super().__init__(body, find_contact_points(soil, body, state, history, reach, expected, limits, begins))
        self._limits = None     # of the interface before `share_interface`

    def near(self, nodes, contact):
        """The pair with the contact points alone that touch in `contact` or move with any of `nodes` (N,) bool."""
        chosen = (nodes[self.points.node] & (self.points.weight > 0.0)).any(axis=1)
        chosen[contact.active] = True
        pair = copy(self)
        pair.points = self.points.select(chosen)
        return pair

    def evaluate(self, displacement, pose):
        body = self.body
        return soil_to_body.evaluate(self.points, self.points.moved(displacement), *pose, body.surface, body.friction,
                                     body.tangential)

    def springs(self, contact):
        return float(np.sqrt(total(self.points.stiffness[contact.active] ** 2)))

    def add_residual(self, contact, force):
        return assembly.add_residual(contact, self.points, force)

    def add_tangent(self, contact, pattern, values, uw, wu, kind=assembly.Tangent.CONSISTENT):
        D = assembly.derivative(contact, kind)
        ww, Q = assembly.body_tangent(contact, D)
        if pattern.size:
            assembly.add_tangent(contact, self.points, D, Q, pattern, values, self.body.free, uw, wu)
        return ww

    def tunnelled(self, contact, displacement, pose, depth):
        return tunnelling.count_tunnelled(
            self.points, contact, self.points.moved(displacement), *pose, self.body.surface, depth)

    def share_interface(self, contact):
        points, limits = self.points, self.points.limits
        if points.shared is None:
            return 0.0
        touching, pressed = np.zeros(len(points), bool), np.zeros(len(points))
        touching[contact.active], pressed[contact.active] = True, contact.pressure
        shear = points.shared(touching, pressed)
        by_pressure = min(RAMP, self.body.friction) * contact.pressure
        before, after = (float(total(np.minimum(values[contact.active], by_pressure))) for values in (limits.shear, shear))
        self._limits, self.points = limits, replace(points, limits=limits._replace(shear=shear))
        return abs(after - before) / max(after, before, TINY)

    def restore_interface(self):
        if self.points.shared is not None:
            self.points = replace(self.points, limits=self._limits)

    @contextmanager
    def bilateral(self):
        points, m = self.points, len(self.points)
        tension = np.where(points.touching & (points.stiffness > 0.0), np.inf, 0.0)
        with self._with(limits=points.limits._replace(tension=tension, opened=np.zeros(m, bool))):
            yield

    def hold_facets(self, contact):
        facet = held_facets.facets(self.points, contact, self.body.surface)
        self.points = replace(self.points, facet=facet)
        return facet

    def release_facets(self):
        self.points = replace(self.points, facet=None)

    def facet_error(self, contact, displacement, pose):
        if self.points.facet is None:
            return 0.0
        return held_facets.facet_error(
            self.points, contact, self.points.moved(displacement), *pose, self.body.surface)

    def commit(self, contact, displacement):
        return soil_to_body.commit(self.points, self.points.moved(displacement), contact)
