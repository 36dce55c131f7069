"""Energy that bodies lose when they hit held ground, or elastic soil, in steps too long for their contact.

A ball of 47 kg that falls 0.5 m keeps half of its energy at each bounce in steps of 2 ms, and nearly all of it in steps
of 0.2 ms. Where bodies were near one another in the impact, one of them was hit: the text says so, as the ground may have no
part in it. Elastic soil takes some of it in waves too short for its cells, which die out.
"""

from hybrid.monitors.absorbed_impact import least_energy
from hybrid.monitors.body_impact import LOST, ON_SOIL, QUIET, ImpactLoss, near


class GroundImpact(ImpactLoss):
    """Warns once that impacts on held ground, and once that impacts of bodies there, have cost more than LOST of the kinetic
    energy, or ON_SOIL on elastic soil; those of bodies there are `BodyImpact`'s."""

    def __init__(self, model, state):
        super().__init__(model, state)
        self._touched = False   # whether a body has touched the ground since something happens,
        self._hit = False       # and whether bodies were near one another

    def warnings(self, view):
        """Energy, time, share, limit and remedy."""
        soil = view.model.soil
        if not soil.held and soil.law.plastic or not view.keeps_energy:
            return
        loss, found = self.follow(view, view.bodies_in_contact)
        self._touched |= view.touches_soil
        self._hit |= view.bodies_in_contact or near(view)
        found = found and (soil.held or not self._hit and loss > ON_SOIL * self._largest)
        if found and self._touched and self._largest > least_energy(view.model):
            yield self._message(view, loss)
        self._hit = self._quiet < QUIET and self._hit
        if self._quiet >= QUIET or view.bodies_in_contact and not self._touched:       # by one another: `BodyImpact`
            self._touched = False
            self.forget()

    def _message(self, view, loss):
        """(key, text) about an impact that cost `loss` [J]."""
        if self._hit:
            return "bodies", self.text(view, loss, "impact of bodies with one another on held ground",
                                       ", whose time `check` shows. Use a smaller time.step, a tenth of that keeps 96 %")
        if not view.model.soil.held:
            return "ground", self.text(
                view, loss, "impact on elastic soil", " or cells too coarse for its waves. Use a smaller time.step, ten in "
                "the time for which they touch, and then smaller cells", ON_SOIL)
        return "ground", self.text(view, loss, "impact on held ground",
                                   ". Use a smaller time.step, ten in the time for which they touch keep 96 %", LOST)

