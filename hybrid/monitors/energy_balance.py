"""Energy that a run gains, or loses in one step, without a cause in the balance of `hybrid.step.energy`."""

import numpy as np

from hybrid.monitors.monitor import Monitor

# Share of the largest energy stored so far (kinetic, elastic, contact springs; quasi-static: with what was dissipated)
GAIN = 0.25
OF_WORK = 0.02  # of the work from outside, of which a slow plough stores next to nothing
# Steps at the start of a run in which no gain counts while the stored energy grows by this factor in a step
START, GROWTH = 5, 1.5
# Steps for which a gain is above its limit, with and without inertia: where guides take hold of a body between two of them,
# what they do and what friction takes are not of the same step
LASTING = {True: 1, False: 3}
ROUND_OFF = 1e-15   # [J] of a gain that is none, as where nothing has happened yet
LOSS = 0.5      # of the same, in one step; 0.3 is the most in 200 runs whose steps resolve contact
LIFT = 0.01     # of a cell: energy that lifts all bodies by less is no scale, as that of springs in which they come to rest


class EnergyBalance(Monitor):
    """Warns once of an unaccounted gain, and once of an unaccounted loss of most of the energy in one step, as happens
    where an impact falls into one step. A scheme of first order is meant to lose energy, and a quasi-static run has no
    history in time. Where a run starts from rest, the first steps store so little that a light contact would
    count: energies are compared with LIFT of a cell times the weight of the bodies at least, and a gain is judged when
    the energy has a scale, and reported with the time at which it began."""

    def __init__(self, model, state):
        super().__init__(model, state)
        self._largest = self._error = 0.0   # [J], stored energy so far; error of the balance at the last step
        self._least = LIFT * model.soil.grid.smallest_cell * np.linalg.norm(model.loads.gravity) * sum(
            body.mass.mass for body in model.bodies)
        # steps so far; time [s] since which the gain is above its limit, and steps for which it is
        self._steps, self._began, self._above = 0, None, 0
        self._touched = False   # whether bodies have touched anything so far

    def warnings(self, view):
        """Energy, time, limit and remedy."""
        energy, scheme = view.energy, view.scheme
        self._touched = self._touched or view.bodies_in_contact or view.touches_soil
        gain, loss = energy["error"], self._error - energy["error"]
        self._error = gain
        before, self._steps = self._largest, self._steps + 1
        spent = 0.0 if scheme.inertia else view.work(("plastic", "friction"))
        stored = self._largest = max(before, energy["kinetic"] + energy["elastic"] + energy["contact"] + spent)
        scale = max(stored, self._least)
        work = OF_WORK * sum(abs(energy.get(name, 0.0)) for name in ("drive", "pull", "load"))
        above = gain > max(GAIN * scale, work, ROUND_OFF) and stored > 0
        self._began = (view.state.time if self._began is None else self._began) if above else None
        self._above = self._above + 1 if above else 0
        if self._above >= LASTING[scheme.inertia] and (self._steps > START or stored <= GROWTH * before):
            yield "gain", (f"energy balance: unaccounted gain of {gain:.3g} J since t = {self._began:.4g} s "
                           f"({_share(gain, stored, GAIN)}). {_remedy(view, self._touched)}")
        if view.keeps_energy and not view.bodies_in_contact and loss > LOSS * scale > 0:
            yield "loss", (f"energy balance: unaccounted loss of {loss:.3g} J in the step to t = {view.state.time:.4g} s "
                           f"({_share(loss, max(stored, loss), LOSS)}). {_remedy(view, self._touched)}")


def _share(energy, stored, limit):
    return f"{energy / stored:.0%} of the largest stored energy so far, limit {limit:.0%}"


def _remedy(view, touched):
    """What to change in a scene like this one, in which bodies have `touched` something or not."""
    if not view.scheme.inertia:
        return "Use shorter load increments: more stage.steps"
    changes = ["a smaller time.step", view.finer("1e-3")]
    if touched:
        changes.append("a lower body.penalty")
    if view.model.joints and any(body.guides for body in view.model.bodies):
        changes.append("a driven velocity that grows, [[0, 0], [T, v]], where joined bodies are set in motion at once")
    if not view.scheme.damps:
        changes.append("the default time.scheme, which damps")
    moving = ["bodies"] * bool(view.model.bodies) + ["soil"] * (not view.model.soil.held)
    cause = ("Contact opens and closes faster than the time step resolves" if touched else
             f"The time step does not resolve the motion of the {' or the '.join(moving)}")
    return f"{cause}; use {', '.join(changes[:-1])}, or {changes[-1]}"
