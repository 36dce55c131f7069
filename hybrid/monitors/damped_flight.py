"""Motion of joined bodies that touch nothing, from which the time integration takes energy.

Without contact nothing but drives, loads and friction of joints changes the energy of bodies: what the balance lacks then,
little by little, is what the scheme took. A free body keeps it, but for its attitude (`FastRotation`). A bar on a hinge that
swings by 90 degrees loses 7 % of its height in a period of 22 steps, and up to half of it where it is not in flight, as it
passes just above the ground, or hangs on a body that stands there.
"""

from hybrid.body.rigid import kinetic_energy
from hybrid.monitors.monitor import Monitor
from hybrid.runtime.comm import anywhere

LOST = 0.1      # of the largest kinetic energy so far
AFTER = 5       # steps after contact in which what an impact takes may still be missing
AT_ONCE = 0.3   # of the same: more in one step is an impact that begins and ends in it, or a load that does
PUSHED = 0.1    # of the same: work of a load in a step, by the trapezoidal rule, that may be wrong by as much as is lost
RESTS = 0.01    # of the same: soil, or a body in contact, with less rests


class DampedFlight(Monitor):
    """Warns once that joined bodies have lost LOST of their kinetic energy while all that touched anything was at rest. A
    pull line that is stiffer than the steps resolve is to be damped."""

    grows = True

    def __init__(self, model, state):
        super().__init__(model, state)
        # energies lost, largest kinetic one; error of the balance, and work of stops and loads, at the last step
        self._lost = self._largest = self._error = self._stop = self._load = 0.0    # [J]
        self._free = 0      # steps without contact of what moves

    def warnings(self, view):
        """Energy lost, limit and remedy."""
        model = view.model
        if not (model.joints and view.keeps_energy) or any(body.line for body in model.bodies):
            return
        self._largest = max(self._largest, view.energy["kinetic"])
        change, self._error = view.energy["error"] - self._error, view.energy["error"]
        engaged, self._stop = view.energy.get("stop", 0.0) != self._stop, view.energy.get("stop", 0.0)
        pushed, self._load = view.energy.get("load", 0.0) - self._load, view.energy.get("load", 0.0)
        quiet = abs(change) <= AT_ONCE * self._largest and abs(pushed) <= PUSHED * self._largest and not engaged
        quiet = quiet and self._rest(view)
        self._free = self._free + 1 if quiet else 0
        if self._free > AFTER:
            self._lost -= change
        if self._lost > LOST * self._largest > 0.0:
            yield "lost", (
                f"the time integration has taken {self._lost / self._largest:.0%} of the largest kinetic energy, limit "
                f"{LOST:.0%}, from joined bodies that touch nothing, up to t = {view.state.time:.4g} s: they swing and turn "
                f"in too few steps. Use half the time.step, or {view.finer('1e-3')}")

    def _rest(self, view):
        """Whether the soil and all bodies in contact rest."""
        least, pairs = RESTS * self._largest, view.report.evaluation.pairs
        touching = {number for number, _, _, contact in view.bodies if anywhere([len(contact)])}
        for one, sides in zip(pairs.step.near, pairs.contacts) if pairs else ():
            touching.update(one.pair.numbers if any(len(side.active) for side in sides) else ())
        energies = [kinetic_energy(body, motion) for _, body, motion, _ in view.bodies]
        of_soil = view.energy["kinetic"] - sum(energies)
        return of_soil <= least and all(energies[number] <= least for number in touching)
