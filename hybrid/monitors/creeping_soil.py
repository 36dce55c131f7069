"""Soil at rest that creeps, as the ghost penalty resists its increments and not where it is.

Soil with friction stops, or goes faster by g Δt in each step. A column of sand that had run out against a wall, in steps of
10 ms, went on at 2 mm/s at its surface for as long as it was followed, with a kinetic energy of 0.1 mJ and 16 mJ dissipated
in each step; the force on the wall fell by 40 % in 7 s. In steps of 5 ms it crept half as fast, and the force stayed;
without the penalty it came to rest.
"""

import numpy as np

from hybrid.monitors.monitor import Monitor
from hybrid.runtime.comm import total

STEPS = 50          # in a row
SLOW = 10.0         # times its kinetic energy that soil dissipates in a step: weight that sinks by v Δt against m v²/2
# Of a cell by which the weight of the soil would sink with what these steps dissipate: a heap that is all
# but at rest has a fifth of it
LEAST = 1e-3
DISSIPATED, BROUGHT = ("plastic", "ghost"), ("drive", "pull", "load")


class CreepingSoil(Monitor):
    """Warns once of soil that yields, with inertia, and creeps although nothing moves it."""

    grows = True

    def __init__(self, model, state):
        super().__init__(model, state)
        self._steps, self._sum, self._since = 0, 0.0, 0.0   # in a row; [J] dissipated in them; [s] since when
        self._brought, self._dissipated = 0.0, None         # [J] work from outside; dissipated, None before the first step

    def warnings(self, view):
        """Energies, time and remedy."""
        soil, energy = view.model.soil, view.energy
        if not view.keeps_energy or soil.held or not soil.law.plastic or not soil.ghost_factor:
            return
        dissipated, brought = view.work(DISSIPATED), view.work(BROUGHT)
        more = 0.0 if self._dissipated is None else dissipated - self._dissipated
        creeps = more > SLOW * energy["kinetic"] and brought == self._brought and _weighs_the_same(view.model)
        self._dissipated, self._brought = dissipated, brought
        if not creeps:
            self._steps, self._sum, self._since = 0, 0.0, view.state.time
            return
        self._steps, self._sum = self._steps + 1, self._sum + more
        if self._steps >= STEPS and self._sum > LEAST * soil.grid.smallest_cell * _weight(view.model):
            yield "creep", (
                f"soil creeps: from t = {self._since:.4g} to {view.state.time:.4g} s it has dissipated {self._sum:.3g} J, "
                f"with a kinetic energy of {energy['kinetic']:.2g} J, although nothing moves it. The ghost penalty holds "
                "soil in hardly filled cells within a step only, and forces of soil at rest then fall (on a wall by 40 % in "
                "7 s). Set soil.ghost = 0 if what comes after the flow counts, or compare with a time.step half as long")


def _weight(model):
    """Weight [N] of the soil."""
    return float(total(model.soil.constants.mass)) * float(np.linalg.norm(model.gravity))


def _weighs_the_same(model):
    """Whether gravity does not change in the stage."""
    return model.loads.high == model.loads.low
