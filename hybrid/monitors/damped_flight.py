"""Motion of joined bodies that touch nothing, from which the time integration takes energy.

Without contact nothing but drives, loads and friction of joints changes the energy of bodies above held ground: what the
balance lacks then, little by little, is what the scheme took. A free body keeps it, but for its attitude (`FastRotation`). A bar on a hinge that swings by 90 degrees loses 7 % of its height in a period
of 22 steps, and up to half of it where it passes just above the ground, so that it is not in flight.
"""

from hybrid.monitors.monitor import Monitor

LOST = 0.1      # of the largest kinetic energy so far
AFTER = 5       # steps after contact in which what an impact takes may still be missing
AT_ONCE = 0.1   # of the same: more in one step is an impact that begins and ends in it, or a load that does


class DampedFlight(Monitor):
    """Warns once that bodies have lost LOST of their kinetic energy while they touched nothing. A pull line that is stiffer
    than the steps resolve is to be damped."""

    grows = True

    def __init__(self, model, state):
        super().__init__(model, state)
        self._lost = self._largest = self._error = 0.0      # [J]
        self._free = 0      # steps without contact

    def warnings(self, view):
        """Energy lost, limit and remedy."""
        model = view.model
        if not (model.joints and model.soil.held and view.keeps_energy) or any(body.line for body in model.bodies):
            return
        self._largest = max(self._largest, view.energy["kinetic"])
        self._free = 0 if view.touches_soil or view.bodies_in_contact else self._free + 1
        change, self._error = view.energy["error"] - self._error, view.energy["error"]
        if abs(change) > AT_ONCE * self._largest:
            self._free = 0
        if self._free > AFTER:
            self._lost -= change
        if self._lost > LOST * self._largest > 0.0:
            yield "lost", (
                f"the time integration has taken {self._lost / self._largest:.0%} of the largest kinetic energy, limit "
                f"{LOST:.0%}, from joined bodies that touch nothing, up to t = {view.state.time:.4g} s: they swing and turn in too "
                f"few steps. Use half the time.step, or {view.finer('1e-3')}")
