"""What a run warns of, before it (`limits`, `initial_equilibrium`) and during it (one monitor for each kind of error).

| monitor          | warns that                                                              |
|------------------|-------------------------------------------------------------------------|
| DomainExit       | a body leaves the grid; stops the run where nothing drives it there     |
| GridEnd          | soil spreads to an end of the grid, which holds it                      |
| LostContact      | nothing; stops a run in which a body falls beside or through the soil   |
| LostPoints       | points are inactive, detached from the soil, or distorted               |
| MissedContact    | a body is inside the soil, between contact points, and has no contact   |
| Penetration      | a body overlaps the soil by more than a point domain                    |
| ForceOscillation | the contact force oscillates because the scheme does not damp           |
| EnergyBalance    | energy is gained, or lost in one step, that the balance cannot explain  |
| AbsorbedImpact   | falling bodies, or soil that flows fast, lose energy without a cause    |
| DampedVibration  | the time integration damps a vibration that the steps resolve           |
| DampedFlight     | it damps the motion of bodies that touch nothing                        |
| FastRotation     | a body that an impact has set spinning tumbles by too much in a step    |
| BodyImpact       | bodies that hit one another lose or gain energy without a cause         |
| PlasticIncrement | an increment without inertia adds too much plastic strain               |
| FlowingSoil      | soil that no body moves flows under its weight, without inertia         |
| CreepingSoil     | soil at rest creeps, with inertia, as the ghost penalty lets it         |
| BodyOverlap      | bodies are pressed deep into one another                                |
| GroundImpact     | bodies that hit held ground or elastic soil lose energy without a cause |
| LastImpact       | a run ends in an impact of bodies that has lost energy without a cause  |
| IdleAdhesion     | clay that touches a body has too little pressure for its adhesion       |
| PartedSides      | clay stands away from the sides of a pile or a skirt                    |
| ShortLine        | the far end of a line through soil is nearer than where it comes up      |
| Untouched        | at the end of a run: a driven body has touched nothing                  |
| JudgedIncrements | many increments end with a residual above the tolerance                 |

Other errors stop no run. `failure_hints` adds probable causes and remedies to the message of a step that fails.
"""

import pickle
from ast import literal_eval

import numpy as np

from hybrid.monitors.absorbed_impact import AbsorbedImpact
from hybrid.monitors.body_overlap import BodyOverlap
from hybrid.monitors.creeping_soil import CreepingSoil
from hybrid.monitors.damped_flight import DampedFlight
from hybrid.monitors.damped_vibration import DampedVibration
from hybrid.monitors.domain_exit import DomainExit
from hybrid.monitors.energy_balance import EnergyBalance
from hybrid.monitors.fast_rotation import FastRotation
from hybrid.monitors.flowing_soil import FlowingSoil
from hybrid.monitors.force_oscillation import ForceOscillation
from hybrid.monitors.grid_end import GridEnd
from hybrid.monitors.idle_adhesion import IdleAdhesion
from hybrid.monitors.impacts import BodyImpact, GroundImpact, LastImpact
from hybrid.monitors.judged_increments import JudgedIncrements
from hybrid.monitors.lost_contact import LostContact
from hybrid.monitors.lost_points import LostPoints
from hybrid.monitors.missed_contact import MissedContact
from hybrid.monitors.monitor import StepView
from hybrid.monitors.parted_sides import PartedSides
from hybrid.monitors.penetration import Penetration
from hybrid.monitors.plastic_increment import PlasticIncrement
from hybrid.monitors.short_line import ShortLine
from hybrid.monitors.untouched import Untouched

MONITORS = (
    DomainExit, GridEnd, LostContact, LostPoints, MissedContact, Penetration, ForceOscillation, EnergyBalance,
    PlasticIncrement, FlowingSoil, CreepingSoil, BodyOverlap, JudgedIncrements, AbsorbedImpact, BodyImpact, GroundImpact,
    LastImpact, IdleAdhesion, PartedSides, ShortLine, Untouched, DampedVibration, DampedFlight, FastRotation)

__all__ = ["MONITORS", "Monitors", "StepView", *(kind.__name__ for kind in MONITORS)]


class Monitors:
    """All monitors of a run of `model` from `state` on. given: texts so far."""

    def __init__(self, model, state):
        self._monitors = [kind(model, state) for kind in MONITORS]
        self.given = []

    def notes(self, view, initial=()):
        """Texts about a StepView, each given once in a run, after `initial` ones."""
        texts = *initial, *(text for monitor in self._monitors for text in monitor.notes(view))
        self.given += texts
        return texts

    def later(self):
        """{text as it was given: the text with the value of the last step} of notes whose values have changed."""
        return {text: last for monitor in self._monitors for text, last in monitor.later().items()}

    def memory(self):
        """Function that gives the text of what has been given and of what the monitors have seen until now, for a run that
        is resumed: to put it together takes longer than to note it."""
        over = {text for monitor in self._monitors if monitor.of_end for text in monitor.texts()}
        memory = {type(monitor).__name__: monitor.memory() for monitor in self._monitors}
        noted = pickle.dumps(([text for text in self.given if text not in over], memory))
        return lambda: repr(_plain(pickle.loads(noted)))

    def restore(self, text):
        """Go on from the `memory` of another run; afresh where that cannot be read, as with numbers that are not finite."""
        try:
            self.given, memory = literal_eval(text)
        except (ValueError, SyntaxError, TypeError):
            return
        for monitor in self._monitors:
            monitor.restore(memory.get(type(monitor).__name__, {}))

    def stop(self, view):
        """Text about what makes it useless to go on from a StepView; empty if nothing does."""
        return ". ".join(text for monitor in self._monitors for text in monitor.stops(view))


def _plain(value):
    """A value with numbers of Python in place of those of numpy, which `literal_eval` reads."""
    if isinstance(value, dict):
        return {_plain(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple, set)):
        return type(value)(map(_plain, value))
    return value.item() if isinstance(value, np.generic) else value
