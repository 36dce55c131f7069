"""Energy that bodies lose when they hit one another, held ground or elastic soil, in increments too long for their contact.

Increments resolve an impact between bodies (`hybrid.step.pair_terms`), but not light contacts. Unresolved, a cradle of three
steel balls loses 54 % of its energy in two impacts with steps of twice their contact, and wedges that tumble into one
another gain up to 32 %. No single one may lose enough to be reported by `EnergyBalance`, and the scheme hands an impulse on
over some steps, so the loss is summed while bodies are near one another, and judged when nothing has happened for a few
steps.

Where all bodies are free and none touches the soil, the energy is that of the motion relative to their common centre of
mass: the rest takes no part in an impact. Of bodies that hit the ground it is that of all motion but for what of it along
the ground and of spin is left all the time: a ball that falls 0.5 m in steps of 2 ms loses two thirds of the energy of its
fall whether it is thrown forwards with 10 m/s or not.

A ball of 47 kg that falls 0.5 m on held ground keeps half of its energy at each bounce in steps of 2 ms, and nearly all of
it in steps of 0.2 ms. Where bodies were near one another in the impact, one of them was hit: the text says so, as the ground
may have no part in it. Elastic soil takes some of it in waves too short for its cells, which die out.

A run may end before an impact can be judged: an arch that falls lost 80 % of the energy of its motion in two steps, got back
half of that, and the run ended. What bodies that are laid on one another lose as their springs settle is no impact.
"""

import numpy as np

from hybrid.monitors.absorbed_impact import BROUGHT, least_energy, motion_energy
from hybrid.monitors.monitor import Monitor

LOST = 0.12         # of the kinetic energy of all bodies; ten increments in the contact time lose 4 %
ON_SOIL = 0.3       # of soil that deforms, which takes some of it without increments being too long
QUIET = 5           # steps without a force between bodies
GRAZES = 0.02       # of the kinetic energy: with less of it along z a body rolls or slides along the ground
STEADY = 0.01       # of the kinetic energy: change of the balance in one of them, of an impulse that has been given
LATER = 0.2         # of the largest energy of motion so far: a body with less is still being braked by elastic soil
ROUND_OFF = 1e-9    # of the largest rate of a body
SURE = 2 * LOST     # of the kinetic energy, where a run ends: some of what is missing may still come back
WAVES = (" or cells too coarse for waves in the soil. Use a smaller time.step, ten in the time for which they touch, and "
         "then smaller cells")
SHORTER = ", whose time `check` shows. Use a smaller time.step, a tenth of that keeps 96 %"


class ImpactLoss(Monitor):
    """Base of monitors that sum what the balance loses from before bodies hit something until nothing happens any more.

    Impacts that are reported add up, so that the last text has all that they have cost."""

    grows = True

    def __init__(self, model, state):
        super().__init__(model, state)
        self._error = 0.0                       # [J], of the balance at the last step
        self._kinetic = 0.0 if state is None else _free_energy(model.bodies, state.bodies)      # [J], of the bodies there
        self._before = None                     # [J], the error before bodies came near, None while they are apart
        # Largest energy [J] of their motion since then; steps for which nothing has happened
        self._largest, self._quiet = 0.0, 0
        self._work = self._brought = 0.0        # [J], that of loads, lines and drives at the last step, and since then
        self._lost = self._of = 0.0             # [J], in all impacts that were reported, and the largest energy before one
        self._hit = False                       # whether bodies have pressed one another since then

    def follow(self, view):
        """(loss of the present impact [J], whether it is over and too large) at a StepView."""
        error, kinetic = view.energy["error"], self.motion(view)
        work = sum(view.energy.get(name, 0.0) for name in BROUGHT)
        change = abs(error - self._error)
        if self._before is None:    # steps apart cost nothing, so each begins afresh
            self._before, self._largest, self._quiet, self._brought = self._error, self._kinetic, 0, 0.0
        self._brought, self._work = self._brought + abs(work - self._work), work
        self._error, self._kinetic, self._largest = error, kinetic, max(self._largest, kinetic)
        self._quiet = 0 if view.bodies_in_contact or change > STEADY * self.size else self._quiet + 1
        loss = self._before - error
        return loss, self._quiet >= QUIET and loss > LOST * self.size > 0.0

    @property
    def size(self):
        """[J] of the motion that takes part in the impact."""
        return self._largest

    def motion(self, view):
        """[J] of the bodies' motion."""
        return _free_energy(view.model.bodies, view.state.bodies)

    def text(self, view, loss, what, cure, limit=LOST):
        """Text about an impact that cost `loss` [J], with those reported before."""
        self._lost, self._of = self._lost + loss, max(self._of, self.size)
        of = max(self._of, self._lost)      # gravity gives them more than they ever had at a time
        return (f"{what}: {self._lost:.3g} J of the {of:.3g} J of their motion are lost without a cause in the balance "
                f"up to t = {view.state.time:.4g} s ({self._lost / of:.0%}, limit {limit:.0%}): increments are too long "
                f"for their contact{cure}, or {view.finer('1e-4')}")

    def forget(self):
        """Begin afresh with the next step."""
        self._before, self._hit = None, False


class BodyImpact(ImpactLoss):
    """Warns once that impacts between bodies have cost more than LOST of their kinetic energy, ON_SOIL where one of them
    touches soil that deforms. Those on held ground are `GroundImpact`'s."""

    def __init__(self, model, state):
        super().__init__(model, state)
        self._limit = LOST      # since bodies came near
        self._on_soil = False   # whether a body has touched soil that deforms, whose waves go on while it is in the air
        if state is not None and _free(model.bodies):
            self._kinetic -= of_all_together(model.bodies, state.bodies)

    def motion(self, view):
        energy, bodies = super().motion(view), view.model.bodies
        flies = _free(bodies) and not view.touches_soil
        return energy - of_all_together(bodies, view.state.bodies) if flies else energy

    def warnings(self, view):
        """Energy, time, share, limit and remedy."""
        if not view.model.pairs or not view.keeps_energy:
            return
        loss, found = self.follow(view)
        on_soil = view.touches_soil
        self._on_soil |= on_soil and not view.model.soil.held
        self._limit = ON_SOIL if on_soil or self._on_soil else self._limit
        self._hit |= view.bodies_in_contact    # on soil, where bodies that stand near one another lose energy to it
        found = found and loss > self._limit * self._largest and (self._hit or self._limit < ON_SOIL)
        found = found and self._largest > least_energy(view.model)      # of bodies that are laid on one another
        on_ground = on_soil and view.model.soil.held
        if found:
            cure = WAVES if self._on_soil and not view.model.soil.law.plastic else SHORTER
            yield "impact", self.text(view, loss, "impact of bodies", cure, self._limit)
        gained = not on_soil and self._hit and self._quiet >= QUIET and -loss > LOST * (self._largest + loss) > 0.0
        if gained:
            yield "gain", (f"impact of bodies: {-loss:.3g} J were added to the {self._largest + loss:.3g} J of their motion "
                           f"without a cause in the balance up to t = {view.state.time:.4g} s "
                           f"({-loss / (self._largest + loss):.0%}, limit {LOST:.0%}): increments are too long for contact "
                           f"of their edges. Use a quarter of the time.step, or {view.finer('1e-4')}")
        # bodies that stay near one another on soil lose a little to it in all that time
        over = self._quiet >= QUIET and (self._limit == ON_SOIL or not near(view))
        if on_ground or found or gained or over:
            self.forget()
            self._limit = LOST


class GroundImpact(ImpactLoss):
    """Warns once that impacts on held ground, and once that impacts of bodies there, have cost more than LOST of the kinetic
    energy, or ON_SOIL on elastic soil; those of bodies there are `BodyImpact`'s."""

    def __init__(self, model, state):
        super().__init__(model, state)
        self._touched = False   # whether a body has touched the ground since something happens
        self._most = self._kinetic      # [J], largest energy of motion so far
        # [J], energy of motion along z and of all other, at the last step; largest and least since something happens
        self._last = (0.0, 0.0) if state is None else _upright_and_other(model.bodies, state.bodies)
        self._upright, self._other = self._last
        self._rubbed = self._rubbing = 0.0      # [J], what friction had taken then, and has taken by now

    @property
    def size(self):
        rest = self._largest - self._other - (self._rubbing - self._rubbed)
        return max(self._upright, rest) if self._upright > GRAZES * self._largest else self._largest

    def warnings(self, view):
        """Energy, time, share, limit and remedy."""
        soil = view.model.soil
        if not soil.held and soil.law.plastic or not view.keeps_energy:
            return
        if self._before is None:
            (self._upright, self._other), self._rubbed = self._last, self._rubbing
        self._rubbing = float(view.energy.get("friction", 0.0))
        self._last = _upright_and_other(view.model.bodies, view.state.bodies)
        self._upright, self._other = max(self._upright, self._last[0]), min(self._other, self._last[1])
        loss, found = self.follow(view)
        self._touched, self._most = self._touched or view.touches_soil, max(self._most, self._largest)
        self._hit |= view.bodies_in_contact or near(view)
        on_soil = loss > ON_SOIL * (self.size + self._brought) and self._largest > LATER * self._most
        found = found and (soil.held or not self._hit and on_soil)
        if found and self._touched and self._largest > least_energy(view.model):
            yield self._message(view, loss)
        self._hit = self._quiet < QUIET and self._hit
        if self._quiet >= QUIET or view.bodies_in_contact and not self._touched:       # by one another: `BodyImpact`
            self._before, self._touched = None, False

    def _message(self, view, loss):
        """(key, text) about an impact that cost `loss` [J]."""
        if self._hit:
            return "bodies", self.text(view, loss, "impact of bodies with one another on held ground", SHORTER)
        if not view.model.soil.held:
            return "ground", self.text(view, loss, "impact on elastic soil", WAVES, ON_SOIL)
        return "ground", self.text(view, loss, "impact on held ground",
                                   ". Use a smaller time.step, ten in the time for which they touch keep 96 %")


class LastImpact(ImpactLoss):
    """Warns at the end of a run of an impact of bodies that has cost more than SURE of their kinetic energy so far, before
    the others can judge it."""

    of_end = True
    forgets = ("_lost", "_of")

    def warnings(self, view):
        """Energy, time, share, limit and remedy."""
        on_soil = not view.model.soil.held and view.touches_soil
        if not view.model.pairs or on_soil or not view.keeps_energy:
            return
        loss, _ = self.follow(view)
        self._hit |= view.bodies_in_contact
        if view.last and self._hit and loss > max(SURE * self._largest, least_energy(view.model)):
            yield "last", self.text(view, loss, "impact of bodies in which the run ends", SHORTER, SURE)
        if self._quiet >= QUIET:
            self.forget()


def _free_energy(bodies, motions):
    """Kinetic energy [J] of the bodies that nothing drives: what drives one gives it back what it loses."""
    free = _undriven(bodies, motions)
    return motion_energy(*zip(*free)) if free else 0.0


def _upright_and_other(bodies, motions):
    """Kinetic energy [J] of these along z, and of their other motion and their spin."""
    upright = sum(0.5 * body.mass.mass * float(motion.velocity[2]) ** 2 for body, motion in _undriven(bodies, motions))
    return upright, _free_energy(bodies, motions) - upright


def _undriven(bodies, motions):
    """Pairs of bodies and motions without those that something drives: held ones have rates of round-off."""
    def moved(free, rates):
        return np.abs(rates[~free]).max(initial=0.0) > ROUND_OFF * np.abs(rates).max()

    return [pair for pair in zip(bodies, motions) if not moved(pair[0].free, pair[1].spatial_rates)]


def _free(bodies):
    return len(bodies) > 1 and all(body.free[:3].all() for body in bodies)


def of_all_together(bodies, motions):
    """Kinetic energy [J] of the common centre of mass of bodies."""
    mass = np.array([body.mass.mass for body in bodies])
    momentum = mass @ np.array([motion.velocity for motion in motions])
    return 0.5 * float(momentum @ momentum) / sum(mass)


def near(view):
    """Whether bodies were in reach of one another in the last increment of the step."""
    pairs = view.report.evaluation.pairs
    return pairs is not None and len(pairs.contacts) > 0
