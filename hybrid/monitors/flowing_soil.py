"""Soil that flows under nothing but its weight in steps without inertia: a slope or a cut that has failed.

Without inertia a failed mass has no equilibrium, but large displacements give it a new one: a vertical cut in clay sinks
by a few per cent of its height at every increase of gravity, with few iterations, and the run completes. What tells this
flow from elastic settlement is that the work of the weight is dissipated instead of stored. With d_s the largest
displacement of a point in step s,

    D_s = growth of the plastic work    E_s = change of the elastic energy
    flow = Σ d_s  over steps with D_s > 5 |E_s|, one after the other

A slope near failure dissipates more than it stores where it yields: with D > |E| one of soft clay that stood at 0.9 of its
limit counted as flowing, and the time at which a steep one failed came 22 % too early. But where gravity grows, all of the
soil stores work: one of c-φ soil of E = 25 MPa that slid by a tenth of its height had D = 3 |E|. There a longer way counts.

Cuts of a height H, E = 1, 5, 100 MPa, 8 cells high, gravity growing in 10 or 40 steps:

| γ H / s_u       | flow                                                        |
|-----------------|-------------------------------------------------------------|
| up to 4         | none; the soil settles by up to 0.05 H                      |
| 4.5 to 8        | 0.008 to 0.19 H, but for 0 of 1 MPa up to 5                 |
"""

import numpy as np

from hybrid.monitors.monitor import Monitor
from hybrid.runtime.comm import anywhere
from hybrid.soil.points import extent

# Shares of the elastic energy, the dissipation in a step in which soil flows, with ways as shares of the height of the soil
FLOWS = (5.0, 0.005), (1.0, 0.03)
STILL = 0.1         # of what the soil moves by in a step: a body that touches it and moves more has a share in that


class FlowingSoil(Monitor):
    """Warns that soil which no body moves flows under its weight, without inertia."""

    grows = True
    forgets = ("_last",)    # it has bodies, and the first step of a run that is resumed is left out

    def __init__(self, model, state):
        super().__init__(model, state)
        self._flow = [(0.0, None)] * len(FLOWS)     # [m]; [s], end of the last step before it
        # (number, time [s], bodies, which of them touch the soil, plastic work [J], elastic energy [J]) of the last step
        self._last = None
        if state is not None and not model.soil.held:
            in_contact = [anywhere(history.touching) for history in state.contacts]
            self._last = state.step, state.time, state.bodies, in_contact, 0.0, model.soil.stored_energy(state.points)

    def warnings(self, view):
        """Time, flow, limit and remedy."""
        soil = view.model.soil
        if view.scheme.inertia or soil.held or not soil.law.plastic or not view.model.gravity.any():
            return
        now = view.state
        in_contact = [anywhere([len(contact)]) for contact in view.contacts]
        works = view.energy["plastic"], view.energy["elastic"]
        last, self._last = self._last, (now.step, now.time, now.bodies, in_contact, *works)
        if last[0] != now.step - 1:     # first step of a run that is resumed
            return
        _, time, bodies, touched, plastic, elastic = last
        stored = abs(view.energy["elastic"] - elastic)      # or given back, where a body is lifted off
        dissipated, height = view.energy["plastic"] - plastic, np.ptp(extent(soil.constants, 2))
        still = not _pushed(view, bodies, np.logical_or(in_contact, touched))
        for i, (share, limit) in enumerate(FLOWS):
            flow, since = self._flow[i]
            if dissipated > share * stored and still:
                self._flow[i] = flow + view.report.moved, time if since is None else since
            elif not self.given("flow"):        # it has come to rest
                self._flow[i] = 0.0, None
            if self._flow[i][0] > limit * height:
                yield "flow", self._text(*self._flow[i], now.time, height, share, limit)
                return

    def _text(self, flow, since, until, height, share, limit):
        return (
            f"soil flows under its weight: from t = {since:.4g} to {until:.4g} s points have moved by up to {flow:.3g} m, "
            f"{flow / height:.2g} of the height of the soil, limit {limit:g}, in steps in which no body moved them and "
            f"{f'{share:g} times as much' if share > 1.0 else 'more'} work was dissipated {'as' if share > 1.0 else 'than'} "
            "stored. It has failed: its strength does not carry its weight, and without inertia the shapes that follow are "
            f"not those of a real collapse. It began to flow at t = {since:.4g} s. Raise the strength or flatten the "
            "ground, or follow the collapse with time.inertia = true")


def _pushed(view, before, in_contact):
    """Whether a body that touches the soil, or has until then, has moved in the step; before: BodyState of each body at its
    begin; in_contact: (nb,) bool."""
    return any(in_contact[b] and _moved(body, before[b], after) > STILL * view.report.moved
               for b, body, after, _ in view.bodies)


def _moved(body, before, after):
    """Largest displacement [m] that translation and rotation of a body may have given to a point of it."""
    return np.linalg.norm(after.position - before.position) + np.linalg.norm(after.rotation - before.rotation) * body.radius
