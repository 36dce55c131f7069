"""A run that ends in an impact of bodies, before `body_impact` and `ground_impact` can judge what it has cost.

An arch that falls lost 80 % of the energy of its motion in two steps, got back half of that, and the run ended, without a
note. What bodies that are laid on one another lose as their springs settle is no impact.
"""

from hybrid.monitors.absorbed_impact import least_energy
from hybrid.monitors.body_impact import LOST, QUIET, ImpactLoss

SURE = 2 * LOST     # of the kinetic energy: some of what is missing may still come back


class LastImpact(ImpactLoss):
    """Warns at the end of a run of an impact of bodies that has cost more than SURE of their kinetic energy so far."""

    of_end = True
    forgets = ("_lost", "_of")

    def __init__(self, model, state):
        super().__init__(model, state)
        self._hit = False       # whether bodies have pressed one another since something happens

    def warnings(self, view):
        """Energy, time, share, limit and remedy."""
        on_soil = not view.model.soil.held and view.touches_soil
        if not view.model.pairs or on_soil or not view.keeps_energy:
            return
        loss, _ = self.follow(view, view.bodies_in_contact)
        self._hit |= view.bodies_in_contact
        if view.last and self._hit and loss > max(SURE * self._largest, least_energy(view.model)):
            yield "last", self.text(view, loss, "impact of bodies in which the run ends",
                                    ", whose time `check` shows. Use a smaller time.step, a tenth of that keeps 96 %", SURE)
        if self._quiet >= QUIET:
            self.forget()
            self._hit = False
