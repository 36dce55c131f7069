"""Energy that bodies lose when they hit one another, in steps too long for their contact.

A cradle of three steel balls, whose contacts last 1 ms, loses 54 % of its energy in two impacts with steps of 2 ms, 32 % with 0.5 ms, 33 %
with time.accuracy = 1e-3 and 0.3 % with 1e-4. No single loses enough to be reported by `EnergyBalance`, and the scheme hands an impulse on
over some steps, so the loss is summed while bodies are near one another, and judged when nothing has happened for a few steps.
"""

from hybrid.body import rigid
from hybrid.monitors.monitor import Monitor

LOST = 0.12         # of the kinetic energy of all bodies; ten steps in the contact time lose 4 % (demos/failure/README.md)
QUIET = 5           # steps without a force between bodies
STEADY = 0.01       # of the kinetic energy: change of the balance in one of them, of an impulse that has been given


class BodyImpact(Monitor):
    """Warns once that impacts between bodies that do not touch the soil have cost more than LOST of their kinetic energy."""

    def __init__(self, model, state):
        super().__init__(model, state)
        self._error = self._kinetic = 0.0       # [J], error of the balance and energy of the bodies' motion at the last step
        self._before = None                     # [J], the error before bodies came near one another, None while they are apart
        self._largest, self._quiet = 0.0, 0     # [J], energy of their motion since then; steps for which nothing has happened

    def warnings(self, view):
        """Energy, time, share, limit and remedy."""
        if not view.model.pairs or not view.scheme.inertia or view.scheme.first_order:
            return
        error, kinetic = view.energy["error"], sum(rigid.kinetic_energy(body, motion) for _, body, motion, _ in view.bodies)
        near, change = _near(view), abs(error - self._error)
        if self._before is None:    # steps apart cost nothing, so each begins afresh
            self._before, self._largest, self._quiet = self._error, self._kinetic, 0
        self._error, self._kinetic, self._largest = error, kinetic, max(self._largest, kinetic)
        self._quiet = 0 if view.struck or change > STEADY * self._largest else self._quiet + 1
        loss, done = self._before - error, self._quiet >= QUIET
        on_soil = any(len(contact) for contact in view.contacts)    # which takes energy too (`AbsorbedImpact`)
        if on_soil or done and not near:
            self._before = None
        if done and loss > LOST * self._largest > 0.0 and not on_soil:
            yield "impact", (
                f"impact of bodies: {loss:.3g} J of the {self._largest:.3g} J of their motion are lost without a cause in the balance up to t = "
                f"{view.state.time:.4g} s ({loss / self._largest:.0%}, limit {LOST:.0%}): increments are too long for their contact, whose "
                f"time `check` shows. Use a smaller time.step, a tenth of that keeps 96 %, or {_accuracy(view)}")


def _accuracy(view):
    return "time.accuracy = 1e-4" if view.report.error is None else "a smaller time.accuracy"


def _near(view):
    """Whether bodies were in reach of one another in the last increment of the step."""
    pairs = view.report.evaluation.pairs
    return pairs is not None and len(pairs.contacts) > 0
