"""The model sheet tells the sizes that a run has, and what a scene leaves out."""

from pathlib import Path

import numpy as np
import pytest

from hybrid.build import build
from hybrid.scene_file import load_scene
from hybrid.system.cache import Systems
from hybrid.system.equations import Step

DEMOS = Path(__file__).parents[2] / "demos"


def test_held_soil_leaves_six_unknowns():
    sheet = build(load_scene(DEMOS / "rolling_sphere.toml")).sheet()
    assert sheet["modelled"]["soil unknowns"] == 0 and sheet["modelled"]["body unknowns"] == 6
    assert any("held still" in line for line in sheet["left out"])
    assert sheet["modelled"]["time integration"] == "Newmark, beta = 0.5625, gamma = 1"


@pytest.mark.parametrize("friction", [0.45, 0.0])
def test_sizes_are_those_of_the_first_step(friction):
    simulation = build(load_scene(DEMOS / "anchor.toml", [f"body.0.friction={friction}"]))
    sheet = simulation.sheet()
    step = Step(simulation.model, simulation.state, 0.04, False, Systems(simulation.model))
    assert sheet["modelled"]["soil unknowns"] == step.pattern.size
    assert sheet["modelled"]["entries of the soil block"] == len(step.pattern.indices)
    assert sheet["modelled"]["material points"] == len(simulation.state.points)
    assert sheet["modelled"]["body unknowns"] == 3
    assert any("friction" in line for line in sheet["left out"]) == (friction == 0.0)


def test_demo_anchor_starts_in_equilibrium():
    """Geostatic stress on the demo's graded grid: the soil's residual is round-off."""
    simulation = build(load_scene(DEMOS / "anchor.toml"))
    step = Step(simulation.model, simulation.state, 0.04, False, Systems(simulation.model))
    weight = np.linalg.norm(step.soil.weight)
    assert np.linalg.norm(step.evaluate(step.start()).soil) < 1e-12 * weight
