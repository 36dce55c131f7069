"""A body that slides off the grid, or falls beside the soil, ends the run with its state kept; it is not "completed"."""

import json

import pytest

import hybrid
from hybrid.output import checkpoint
from hybrid.runtime.errors import StepError
from hybrid.scene import Output, Time
from hybrid.setup.build import build
from hybrid.study.scenes import soil_scene, steel


def scene(steps=6, **body):
    """A cube of 0.2 m over held soil, the grid of which is 0.8 m wide and ends 0.4 m above and below z = 0."""
    cube = steel(0.2, 0.2, 0.2, name="cube", **{"position": (0.4, 0.4, 0.0), **body})
    return soil_scene([cube], held=True, steps=steps, time=Time(step=0.01), gravity=(0.0, 0.0, -9.81))


def test_a_body_that_slides_off_the_grid_stops_the_run_with_its_state(tmp_path):
    """0.3 m at 0.08 m a step: in the fourth step."""
    described = scene(rest_on=0.0, velocity=(8.0, 0.0, 0.0))
    described = hybrid.Scene(**{**vars(described), "output": Output(every=0, checkpoint=100)})
    with pytest.raises(StepError, match="stopped after step 4, whose state is kept: cube leaves the grid: at t = 0.04"):
        hybrid.run(described, out=tmp_path, quiet=True)
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["outcome"] == "failed" and summary["step"] == 4
    assert checkpoint.load(tmp_path / checkpoint.NAME, build(described).scene).step == 4


def test_a_body_beside_the_soil_stops_the_run():
    """It starts beside the grid, above the soil, and is wholly below its surface in the third step."""
    simulation = build(scene(position=(2.0, 0.4, 0.0), rest_on=0.05, velocity=(0.01, 0.0, -10.0)))
    with pytest.raises(StepError, match="step 3, whose state is kept: cube falls free at z = -0.1.*below the surface"):
        simulation.run()
    assert simulation.state.step == 3


@pytest.mark.parametrize("body", [
    {"rest_on": 0.1, "velocity": (0.0, 0.0, 10.0)},                             # flies up, through the top of the grid
    {"rest_on": 0.1, "velocity": (8.0, 0.0, 0.0), "driven": ("x", "y", "z")},   # is driven out
    {"rest_on": 0.01, "velocity": (0.0, 0.0, -3.0)},                            # hits the soil
])
def test_what_does_not_stop_a_run(body):
    assert build(scene(**body)).run()["outcome"] == "completed"
