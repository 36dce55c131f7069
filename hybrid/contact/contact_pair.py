"""Contact of one rigid body with the soil during a step: points on the soil's surface against the body's surface.

    ∫ p_f E g dA  over the soil's surface, by the contact points near the body        `hybrid.contact.contact_points`
    law of penalty and friction at each of them                                      `hybrid.contact.soil_to_body`
    their forces and tangent in the block system                                     `hybrid.contact.assembly`
"""

from contextlib import contextmanager
from copy import copy
from dataclasses import replace

import numpy as np

from hybrid.contact import assembly, held_facets, soil_to_body, tunnelling
from hybrid.contact.contact_points import find_contact_points
from hybrid.contact.interface import RAMP
from hybrid.runtime.comm import count, total

TINY = 1e-300       # [N]


class ContactPair:
    """A body and the contact points near it: frozen during a step but for what Newton's method decides about them: the
    facets that hold them, those that stick, bonds of the first guess, and the shares of an interface."""

    def __init__(self, body, state, history, domains, grid, active, reach, expected, limits=None,
                 begins=False):
        """body: RigidBody; state: BodyState; history: ContactHistory; domains: Domains of the soil's points; active,
        reach, expected, limits, begins: as in find_contact_points."""
        self.body, self._limits = body, None     # of the interface before `share_interface`
        self.points = find_contact_points(domains, body.contact_pressure, body.places, grid, active, state, body.surface,
                                          reach, history, expected, limits, begins)

    def near(self, nodes, contact):
        """The pair with the contact points alone that touch in `contact` or move with any of `nodes` (N,) bool."""
        chosen = (nodes[self.points.node] & (self.points.weight > 0.0)).any(axis=1)
        chosen[contact.active] = True
        pair = copy(self)
        pair.points = self.points.select(chosen)
        return pair

    def evaluate(self, displacement, pose):
        """PointContact at nodal increments (N, 3) [m] (None: held soil) and a pose."""
        body = self.body
        return soil_to_body.evaluate(self.points, self.points.moved(displacement), *pose, body.surface, body.friction,
                                     body.tangential)

    def springs(self, contact):
        """Root of the sum of squares [N/m] of the stiffnesses of all springs in contact."""
        return float(np.sqrt(total(self.points.stiffness[contact.active] ** 2)))

    def add_residual(self, contact, force):
        """Add contact to nodal residuals (N, 3) [N], None when the soil is held; returns the body's residual (6,)
        [N, N m about its centre]."""
        return assembly.add_residual(contact, self.points, force)

    def add_tangent(self, contact, pattern, values, uw, wu, kind=assembly.Tangent.CONSISTENT):
        """Add the tangent to the soil block `values` and to its coupling with the body's m free components, uw (n, m)
        and wu (m, n); returns K_ww (6, 6)."""
        D = assembly.derivative(contact, kind)
        ww, Q = assembly.body_tangent(contact, D)
        if pattern.size:
            assembly.add_tangent(contact, self.points, D, Q, pattern, values, self.body.free, uw, wu)
        return ww

    def tunnelled(self, contact, displacement, pose, depth):
        """Number of contact points that the step carried through the body, or deeper than `depth` [m] into it on their
        way."""
        return tunnelling.count_tunnelled(
            self.points, contact, self.points.moved(displacement), *pose, self.body.surface, depth)

    def share_interface(self, contact):
        """Let the points that touch in `contact` bear the adhesion of the clay around them, in proportion to their
        pressure, in place of those that touched before. Returns the share of their shear strength under this pressure by
        which its sum changes."""
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
        """Let the points bear what they did before `share_interface`."""
        if self.points.shared is not None:
            self.points = replace(self.points, limits=self._limits)

    def separated(self, contact):
        """Numbers of the points that touched when the step began, and of those of them that do not in `contact`."""
        touching = self.points.touching.copy()
        before = count(touching)
        touching[contact.active] = False
        return before, count(touching)

    @contextmanager
    def bilateral(self):
        """Context in which contact of the points that touched when the step began is bilateral: they pull too."""
        points, m = self.points, len(self.points)
        tension = np.where(points.touching & (points.stiffness > 0.0), np.inf, 0.0)
        self.points = replace(points, limits=points.limits._replace(tension=tension, opened=np.zeros(m, bool)))
        try:
            yield
        finally:
            self.points = points

    @contextmanager
    def sticking(self, chosen):
        """Context in which the shear of `chosen`, an index of contact points, has no limit."""
        points, mask = self.points, np.zeros(len(self.points), bool)
        mask[chosen] = True
        self.points = replace(points, sticking=mask)
        try:
            yield
        finally:
            self.points = points

    def hold_facets(self, contact):
        """Hold the points that touch to the facets that carry them in `contact`. Returns those facets (m,)."""
        facet = held_facets.facets(self.points, contact, self.body.surface)
        self.points = replace(self.points, facet=facet)
        return facet

    def release_facets(self):
        """Let every point find its facet again."""
        self.points = replace(self.points, facet=None)

    def facet_error(self, contact, displacement, pose):
        """Largest difference [-] between the overlaps with the held facets and with the surface, 0 without any held."""
        if self.points.facet is None:
            return 0.0
        return held_facets.facet_error(
            self.points, contact, self.points.moved(displacement), *pose, self.body.surface)

    def commit(self, contact, displacement):
        """ContactHistory after acceptance."""
        return soil_to_body.commit(self.points, self.points.moved(displacement), contact)
