"""Energy of falling bodies that the balance loses in an impact on soil that yields, a little in every step.

A sphere dropped on glass beads loses 32, 24, 18 % of its energy with 4, 5, 6 cells in its diameter, and stops 25, 15,
10 % too early (demos/random/README.md). No single step loses enough to be reported by `EnergyBalance`. A ball of 0.25 m at
3 m/s lost 25 % in clay in steps of 2 ms and 42 % in 0.5 ms. In elastic soil what a run loses is mostly waves that go on.

What goes on falling has not hit anything, but soil that flows around it fast loses energy as well: clay took 31 % more
from a torpedo of four cells at 6 m/s than from one that was driven in slowly, nearly all of it lost, and a block of clay
that fell by 0.2 m on a plate lost 41 %. There the loss is compared with what soil, friction and ghost penalty took.
"""

import numpy as np

from hybrid.body import rigid
from hybrid.monitors.monitor import Monitor
from hybrid.runtime.comm import total
from hybrid.soil.points import extent

ABSORBED = 0.15     # of the largest kinetic energy of the bodies, over a run
FALLING = 0.5       # smallest share of the energy that stored so far is that of the bodies' motion
# Of the loss, in one step: steps that resolve an impact spread it over some. A box that falls 1 m, 8 cells, steps of 2 and
# 0.4 ms: 4.6 and 2.6 kJ of 12.4 on sand, 4.3 and 2.0 on c-φ soil, 5.1 and 4.5 on clay, 5.3 with a time.accuracy of 1e-3
AT_ONCE = 0.6
STOPPED = 0.5       # of the largest energy of their motion, below which an impact has stopped bodies
BROUGHT, STORED = ("pull", "drive", "load"), ("kinetic", "elastic", "contact")
FLOW = 0.2          # of what soil, friction and ghost penalty took, with what is lost,
TAKEN = 0.25        # and of the largest kinetic energy of all, what they took at least
TAKERS = "plastic", "friction", "ghost"
# Of the energy of a fall from the radius of the bodies, without bodies of the soil from its own height: what has less
# settles on soil or contact springs, or is the shock of weight that acts at once
SMALL = 0.01

OTHERS = 0.05   # of the energy of a fall: work on bodies, since what is lost was counted from, that makes it begin afresh

BACK = "more was missing before, and has come back or is little beside the work on the bodies since"


class AbsorbedImpact(Monitor):
    """Warns once that falling bodies have lost more energy than soil, friction and ghost penalty took up, and once that soil
    which flows fast has."""

    grows = True

    def __init__(self, model, state):
        super().__init__(model, state)
        # [J], largest kinetic energy of the bodies, and largest stored one, so far; a first step may end after the impact
        self._falling = self._stored = 0.0 if state is None else motion_energy(model.bodies, state.bodies)
        self._sudden = False                # whether most of what is lost at first is lost in one step
        self._error = self._at_once = 0.0   # [J], of the balance at the last step, and its largest loss in a step
        self._base, self._work = 0.0, [0.0] * len(BROUGHT)      # [J], error and work when others last moved the bodies
        self._fastest = self._taken = 0.0   # [J], largest kinetic energy of all since then, what soil had taken until then
        self._flowed = [0.0] * 4            # largest share lost by soil that flows; [J] lost, of which; [s] when

    def warnings(self, view):
        """Energy, share, limit and remedy."""
        energy, soil = view.energy, view.model.soil
        if not view.keeps_energy or soil.held or not soil.law.plastic:
            return
        moving, stored = motion_energy(view.model.bodies, view.state.bodies), view.work(STORED)
        work = [energy.get(name, 0.0) for name in BROUGHT]
        brought = sum(abs(now - before) for now, before in zip(work, self._work))
        others = brought > OTHERS * max(self._falling, least_energy(view.model))
        if others and not self.given("absorbed"):       # what a drive has lifted falls from now on
            self._falling, self._stored, self._at_once, self._base = moving, stored, 0.0, energy["error"]
            self._error, self._work = energy["error"], work
            self._fastest, self._taken = energy["kinetic"], view.work(TAKERS)
        self._falling = max(self._falling, moving)
        self._at_once, self._error = max(self._at_once, self._error - energy["error"]), energy["error"]
        self._stored, lost = max(self._stored, stored), self._base - energy["error"]
        fell = max(self._falling, least_energy(view.model))
        impact = not view.bodies_in_contact and self._falling > FALLING * self._stored and lost > ABSORBED * fell > 0.0
        impact = impact and moving < STOPPED * self._falling    # a ball that rolls down clay goes faster and faster
        if not self.given("absorbed"):
            self._sudden = self._at_once > AT_ONCE * lost
        if impact or self.given("absorbed"):
            # what has been lifted since falls again
            fallen = max(self._falling + max(sum(work) - sum(self._work), 0.0), lost)
            over = "" if lost > ABSORBED * fallen else " within the"
            yield "absorbed", (
                f"impact: {lost:.3g} J of the {fallen:.3g} J of moving bodies are lost without a cause in the balance "
                f"up to t = {view.state.time:.4g} s ({lost / fallen:.0%},{over} limit {ABSORBED:.0%}): "
                f"{BACK if over else self._cause()}")
        elif not view.bodies_in_contact:
            yield from self._flow(view, lost)

    def _flow(self, view, lost):
        """Energy `lost` [J], share, limit and remedy where soil flows fast."""
        self._fastest, taken = max(self._fastest, view.energy["kinetic"]), view.work(TAKERS) - self._taken
        found = lost > FLOW * (taken + lost) and taken > TAKEN * self._fastest > 0.0
        found = found and taken + lost > least_energy(view.model)       # of a body that is put down, and settles
        if found and lost / (taken + lost) > self._flowed[0]:
            self._flowed = [lost / (taken + lost), lost, taken + lost, view.state.time]
        share, lost, taken, until = self._flowed
        if share:
            yield "flow", (
                f"soil flows fast: {lost:.3g} J of the {taken:.3g} J that it took up until t = {until:.4g} s are lost "
                f"without a cause in the balance ({share:.0%}, limit {FLOW:.0%}): cells are too coarse for it, and its "
                "resistance is too high by about as much. Use smaller cells where it is fastest; shorter steps alone, each "
                "of which loses some, lose more")

    def _cause(self):
        """Cause and remedy of a loss: in steps too long for the impact, or little by little in cells too coarse for it."""
        if self._sudden:
            return ("most of it in a single step. Use a fifth of the time.step, with which sand and soil with cohesion and "
                    "friction lost half as much, and where that hardly helps, as on clay, smaller cells at the bodies")
        return ("cells are too coarse for it, and the bodies go less deep (measured on spheres that fall on sand: by 10 % "
                "where 18 % are lost, by 25 % where 32 % are). Use smaller cells at the bodies; shorter steps alone, each "
                "of which loses some, lose more")


def least_energy(model):
    """Energy [J] of motion below which nothing is an impact."""
    if model.bodies:
        reach = sum(body.mass.mass * body.radius for body in model.bodies)
    else:
        reach = total(model.soil.constants.mass) * np.ptp(extent(model.soil.constants, 2))
    return SMALL * float(reach * np.linalg.norm(model.gravity))


def motion_energy(bodies, motions):
    """Kinetic energy [J] of bodies."""
    return sum(rigid.kinetic_energy(body, motion) for body, motion in zip(bodies, motions))
