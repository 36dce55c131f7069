"""Bodies that tumble so fast in a step that their attitude, and the energy of those that are joined, is lost.

A body that spins from the start is judged before the run (`hybrid.monitors.limits.stepping`). One that an impact sets
spinning is not known then: hinged bodies that turned by 0.2 rad a step after one had a kinetic energy that went up and down
by 16 %.
"""

import numpy as np

from hybrid.monitors.limits.stepping import rotation_limit, tumbles
from hybrid.monitors.monitor import Monitor

FAR = 10.0      # [rad] turned by since the steps are too long for it, from which on the attitude is wrong by 0.05 rad


class FastRotation(Monitor):
    """Warns once for each body that has tumbled by FAR in increments too long for it, unless it begins so."""

    def __init__(self, model, state):
        super().__init__(model, state)
        self._turned, self._from_start = {}, []     # {number of a body: angle [rad]}; numbers of those that began so

    def warnings(self, view):
        """Body, angle a step, limit and remedy."""
        if not view.scheme.inertia or view.report.error is not None:
            return
        limit, kind = rotation_limit(view.scheme)
        for number, body, motion, _ in view.bodies:
            angle = view.report.dt * float(np.linalg.norm(motion.spin))
            if angle <= limit or self.given(number) or not tumbles(motion.spin, body) or _led(view.model, number):
                continue
            if view.state.step == 1:
                self._from_start.append(number)
            self._turned[number] = self._turned.get(number, 0.0) + angle
            if number not in self._from_start and self._turned[number] > FAR:
                yield number, (f"{body.name} tumbles, by {angle:.3g} rad a step at t = {view.state.time:.4g} s, limit "
                               f"{limit:g} rad for {kind}: its attitude is wrong by 0.05 rad or more by now, and the "
                               "energy of bodies that are joined to it goes up and down. Use a smaller time.step, or "
                               "time.accuracy = 1e-3")


def _led(model, number):
    """Whether a joint connects a body to the ground, or to one that is not free: it may turn about a fixed axis."""
    others = {b for joint in model.joints if number in joint.bodies for b in joint.bodies}
    return any(b is None or not model.bodies[b].free.all() for b in others)
