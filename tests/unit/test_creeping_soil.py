"""The monitor of soil at rest that creeps: what moves slowly for long is reported, what others move, or stops, is not."""

from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.monitors import StepView
from hybrid.monitors.creeping_soil import STEPS, CreepingSoil


def notes(steps=STEPS + 2, each=0.03, kinetic=1e-4, ghost=0.3, held=False, plastic=True, inertia=True, first_order=False,
          gravity=(1.0, 1.0), drive=0.0):
    """Of steps in which 1 t of soil dissipates `each` [J], in cells of 0.1 m."""
    soil = SimpleNamespace(held=held, law=SimpleNamespace(plastic=plastic), ghost_factor=ghost,
                           constants=SimpleNamespace(mass=np.full(10, 100.0)), grid=SimpleNamespace(smallest_cell=0.1))
    loads = SimpleNamespace(low=gravity[0], high=gravity[1])
    model = SimpleNamespace(soil=soil, loads=loads, gravity=np.array([0.0, 0.0, -10.0]))
    monitor, found = CreepingSoil(None, None), []
    for step in range(steps):
        energy = {"kinetic": kinetic if step else 1.0, "plastic": 0.8 * each * step, "ghost": 0.2 * each * step,
                  "drive": drive * step}
        found += monitor.notes(StepView(model, SimpleNamespace(time=0.1 * step), SimpleNamespace(
            inertia=inertia, first_order=first_order), None, energy))
    return found


def test_soil_that_creeps_is_reported_once():
    text, = notes(3 * STEPS)
    assert "from t = 0 to 5 s it has dissipated 1.5 J, with a kinetic energy of 0.0001 J" in text
    assert "Set soil.ghost = 0" in text


@pytest.mark.parametrize("other", [
    {"steps": STEPS}, {"each": 1e-4}, {"kinetic": 0.01}, {"kinetic": 1e-7, "each": 0.019}, {"ghost": 0.0}, {"held": True},
    {"plastic": False}, {"inertia": False}, {"first_order": True}, {"gravity": (0.0, 1.0)}, {"drive": 1e-3}])
def test_other_soil_does_not_creep(other):
    """For a few steps, as fast as it falls, faster, next to nothing, without penalty or plasticity, without inertia, by
    schemes that damp, under gravity that grows, moved by others."""
    assert notes(**other) == []
