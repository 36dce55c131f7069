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


def test_clay_does_not_part_from_a_plate_thinner_than_a_cell_and_the_limit_says_so():
    """Half a cell thick, it carries as if the clay stuck to it (11.0; 10.4); so it does for the first half of a cell of
    its way if it is 1.5 cells thick, but of two cells never."""
    simulation = build(load_scene(DEMO, [*COARSE, "body.plate.parameters.height=0.05"]))
    note, = (text for text in simulation.warned if "thick" in text)
    assert "plate is 0.05 m thick where the soil is on both sides of it, 0.503 cells of 0.1 m, limit 2" in note
    force = [-record.bodies[0].contact_force[2] for record in simulation.steps()]
    assert max(force) / (HALF * SLICE * STRENGTH) > 9.0


@pytest.mark.parametrize("more, warned", [
    (["body.plate.parameters.height=0.15"], True), (["body.plate.parameters.height=0.2"], False),
    (["body.plate.parameters.height=0.05", "body.plate.tension=full"], False),
    (["body.plate.parameters.height=0.05", "body.plate.velocity=[0.01, 0, 0]", "body.plate.driven=['x']",
      "body.plate.held=['y', 'z', 'rx', 'ry', 'rz']"], False),
    (["body.plate.parameters.height=0.05", "soil.material={relative_density=38.0, young=2e7}"], False),
    (["body.plate.parameters.height=0.05", "body.plate.position=[0.0, 0.025, 0.1]"], False)])
def test_only_walls_that_soil_should_part_from_are_reported(more, warned):
    """Not those that the soil is to stay on, that move along themselves, in sand without tension, or above the ground."""
    assert any("thick where" in text for text in build(load_scene(DEMO, [*COARSE, *more])).warned) == warned
