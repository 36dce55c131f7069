"""Clay that touches a body and mobilises little of its adhesion, because hardly any pressure is there.

The shear of a contact point without a bond is at most RAMP times its pressure (`hybrid.contact.interface`), so that it
does not jump where the point opens. In soil without weight nothing presses a lid that just touches, or the shaft of a
pile.
"""

import numpy as np

from hybrid.contact.interface import RAMP
from hybrid.monitors.monitor import Monitor
from hybrid.runtime.comm import total

LIMIT = 0.6     # share of the adhesion of the points in contact that their pressure mobilises
STEPS = 3       # in a row


class IdleAdhesion(Monitor):
    """Warns once for each body."""

    def __init__(self, model, state):
        super().__init__(model, state)
        self._steps = [0] * len(model.bodies)

    def warnings(self, view):
        """Body, force, limit and remedy."""
        for number, body, _, contact in view.bodies:
            if not (body.interface and body.interface.adhesion) or body.interface.tension or body.friction < np.inf:
                continue        # friction that is given limits the shear where the pressure is low
            limit = view.report.evaluation.bodies[number].step.pair.points.limits.shear[contact.active]
            mobilised = limit.clip(max=RAMP * contact.pressure.clip(min=0.0))
            mobilised, adhesion = (float(total(force)) for force in (mobilised, limit))
            self._steps[number] = self._steps[number] + 1 if mobilised < LIMIT * adhesion else 0
            if self._steps[number] == STEPS:
                yield number, (
                    f"{body.name} mobilises at most {mobilised:.3g} N of its adhesion to the clay that it touches, "
                    f"{adhesion:.3g} N ({mobilised / adhesion:.0%}, limit {LIMIT:.0%}), at t = {view.state.time:.4g} s: "
                    f"without tension, shear is at most {RAMP:g} times the pressure. {_begin(view.model)} the body on, or "
                    'let clay carry tension on it (body.tension, "full" for clay that never breaks away)')


def _begin(model):
    return "Press" if model.gravity.any() else "Give the soil its weight (gravity), press"
