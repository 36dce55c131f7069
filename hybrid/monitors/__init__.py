"""What a run tells while it goes: all that may go wrong quietly, looked at after each outer step."""

from hybrid.monitors.domain_exit import Leaving
from hybrid.monitors.energy_balance import Gain
from hybrid.monitors.force_oscillation import Ringing
from hybrid.monitors.lost_points import Astray
from hybrid.monitors.missed_contact import Between
from hybrid.monitors.penetration import Deep
from hybrid.monitors.plastic_increment import Flow


class Watch:
    """Everything that is watched in a run of `model` from `state` on."""

    def __init__(self, model, state):
        self._leaving, self._gain, self._flow = Leaving(model, state.bodies), Gain(), Flow()
        self._astray = None if model.soil.held else Astray(model, state.points)
        self._contact = Between(), Deep(), Ringing()

    def notes(self, model, state, scheme, report, energy):
        """Texts about what is new at `state`, which a step by `scheme` led to; report: of that step; energy: now."""
        notes = self._leaving.notes(model, state)
        if self._astray:
            notes += self._astray.notes(model, state)
        for kind in self._contact:
            notes += kind.notes(model, state, report.evaluation.contacts, scheme)
        notes += self._gain.notes(state.time, energy, scheme.damps or not scheme.inertia)
        return notes + self._flow.notes(state.time, report.flow)
