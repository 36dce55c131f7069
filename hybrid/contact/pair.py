"""What Newton's method asks of the contact between one rigid body and the soil during a step.

`ContactPair` has points on the soil's surface, `GroundPair` places on a body over level held ground. Both are frozen during
a step but for what Newton's method decides about them: those that stick, and for points of the soil the facets that hold
them, bonds of the first guess and the shares of an interface. Where a pair has nothing to decide, what is here holds.
"""

from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from hybrid.runtime.comm import count


class Pair:
    """A body (RigidBody) and the frozen `points` of its contact: m of them, with masks (m,) bool touching, of the start of
    the step, and sticking. A contact is what `evaluate` returned (PointContact)."""

    def __init__(self, body, points):
        self.body, self.points = body, points

    def evaluate(self, displacement, pose):
        """PointContact at nodal increments (N, 3) [m] (None: held soil) and a pose."""
        raise NotImplementedError

    def springs(self, contact):
        """Root of the sum of squares [N/m] of the stiffnesses of all springs in contact."""
        raise NotImplementedError

    def add_residual(self, contact, force):
        """Add contact to nodal residuals (N, 3) [N], None when the soil is held; returns the body's residual (6,)
        [N, N m about its centre]."""
        raise NotImplementedError

    def add_tangent(self, contact, pattern, values, uw, wu, kind):
        """Add the tangent of a `kind` (assembly.Tangent) to the soil block `values` and to its coupling with the body's m
        free components, uw (n, m) and wu (m, n); returns K_ww (6, 6)."""
        raise NotImplementedError

    def tunnelled(self, contact, displacement, pose, depth):
        """Number of contact points of all processes that the step carried through the body, or deeper than `depth` [m]
        into it on their way."""
        raise NotImplementedError

    def commit(self, contact, displacement):
        """ContactHistory after acceptance."""
        raise NotImplementedError

    def separated(self, contact):
        """Numbers of the points that touched when the step began, and of those of them that do not in `contact`."""
        touching = self.points.touching.copy()
        before = count(touching)
        touching[contact.active] = False
        return before, count(touching)

    @contextmanager
    def sticking(self, chosen):
        """Context in which the shear of `chosen`, an index of contact points, has no limit."""
        mask = np.zeros(len(self.points), bool)
        mask[chosen] = True
        with self._with(sticking=mask):
            yield

    @contextmanager
    def bilateral(self):
        """Context in which contact of the points that touched when the step began is bilateral: they pull too."""
        yield

    def share_interface(self, contact):
        """Let the points that touch in `contact` bear the adhesion of the clay around them, in proportion to their
        pressure, in place of those that touched before. Returns the share of their shear strength under this pressure by
        which its sum changes."""
        return 0.0

    def restore_interface(self):
        """Let the points bear what they did before `share_interface`."""

    def hold_facets(self, contact):
        """Hold the points that touch to the facets that carry them in `contact`. Returns those facets (m,), -1 for none."""
        return np.full(len(self.points), -1)

    def release_facets(self):
        """Let every point find its facet again."""

    def facet_error(self, contact, displacement, pose):
        """Largest difference [-] between the overlaps with the held facets and with the surface, 0 without any held."""
        return 0.0

    @contextmanager
    def _with(self, **values):
        """Context in which the points have other `values`."""
        points = self.points
        self.points = replace(points, **values)
        try:
            yield
        finally:
            self.points = points
