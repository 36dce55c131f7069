"""Pull-out of a buried strip plate in clay (demos/plate.toml), against limit analysis of weightless clay."""

from pathlib import Path

import numpy as np
import pytest

from hybrid.scene.file import load_scene
from hybrid.setup.build import build

DEMO = Path(__file__).parents[2] / "demos" / "plate.toml"
DEPTH, STRENGTH, HALF, SLICE = 1.5, 10e3, 0.5, 0.05
COARSE = ["grid.x.size=0.1", "grid.z.size=0.1", "body.plate.velocity=[0, 0, 0.01]", "stage.0.steps=6"]


@pytest.mark.parametrize("more, factor, low, high", [
    ([], 2.483 * np.log(DEPTH) + 1.974, 0.98, 1.1),
    (["body.plate.tension=full", "stage.0.steps=10"], 2.90 * DEPTH + 6.02, 1.0, 1.15)])
def test_pull_out_factor(more, factor, low, high):
    """F / (B s_u) with soil that breaks away behind the plate, and with soil that stays on it."""
    simulation = build(load_scene(DEMO, COARSE + more))
    force = np.array([-record.bodies[0].contact_force[2] for record in simulation.steps()]) / (HALF * SLICE * STRENGTH)
    assert low * factor < force.max() < high * factor
