"""Driven bodies that touched nothing in a whole run: their forces are zero because of where they are, not because of the
soil."""

import numpy as np

from hybrid.body import rigid
from hybrid.monitors.monitor import Monitor
from hybrid.runtime.comm import anywhere


class Untouched(Monitor):
    """Notes at the end of a run that a body, driven along an axis, has touched neither soil nor another body.

    One in a joint may only carry another. Contact is looked at after each outer step."""

    of_end = True

    def __init__(self, model, state):
        super().__init__(model, state)
        self._touched, self._since = set(), None    # numbers of bodies; number of the first step seen

    def warnings(self, view):
        """Body, gap and remedy."""
        self._since = view.state.step if self._since is None else self._since
        self._touched |= {b for b, _, _, contact in view.bodies if b not in self._touched
                          and anywhere([len(contact)])} | _pressed(view)
        if not view.last or self._since > 1:    # a run that was resumed may have touched before
            return
        joined = {b for joint in view.model.joints for b in joint.bodies}
        for b, body, motion, _ in view.bodies:
            if b not in self._touched and b not in joined and body.driven[:3].any():
                gap = rigid.bounding_box(body, motion)[0, 2] - view.surface()
                where = f": at the end it is {gap:.3g} m above the highest soil" if np.isfinite(gap) and gap > 0.0 else ""
                yield b, (f"{body.name} is driven and touches neither soil nor another body at the end of any step, so "
                          f"that its forces in the history are zero{where}. Let it begin at the soil (body.rest_on, "
                          "body.position), or drive it farther; an impact within a step shows with shorter ones")


def _pressed(view):
    """Numbers of the bodies that press on another one."""
    pairs = view.report.evaluation.pairs
    if pairs is None:
        return set()
    return {b for index, pair in enumerate(view.model.pairs) if np.any(pairs.of_pair(index)[0]) for b in pair.numbers}
