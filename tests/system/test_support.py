"""Bodies put on soil with all of their weight at once, without inertia: supported where the first increment has no solution."""

from dataclasses import replace

import numpy as np
import pytest

import hybrid
from hybrid.runtime.data import GEOMETRY
from hybrid.runtime.errors import StepError
from hybrid.step import increments
from hybrid.step.support import Support, work_of_support
from hybrid.step.workspace import Workspace

BALL = """
time = { step = 1.0, inertia = false }
[grid]
x = { start = 0.0, end = 1.2, size = 0.15 }
y = { start = 0.0, end = 1.2, size = 0.15 }
z = { start = -1.2, end = 0.6, size = 0.15 }
faces = { z_min = "fixed" }
[soil]
top = 0.0
material = { law = "von-mises", young = 5e6, poisson = 0.49, density = 1600.0, strength = 10e3 }
[[body]]
name = "ball"
geometry = "GEOMETRY/sphere.geo"
parameters = { radius = 0.45, size = 0.1 }
density = 4000.0
rest_on = 0.0
held = ["x", "y", "rx", "ry", "rz"]
[[stage]]
name = "put"
steps = 1
"""


def ball(tmp_path):
    path = tmp_path / "ball.toml"
    path.write_text(BALL.replace("GEOMETRY", str(GEOMETRY)))
    return hybrid.build(hybrid.load_scene(path))


def test_a_ball_put_on_clay_sinks_in_until_it_is_borne(tmp_path):
    record, = ball(tmp_path).steps()
    one = record.bodies[0]
    assert one.contact_force[2] == pytest.approx(4000.0 * 9.81 * np.pi * 0.45**3 / 3, rel=0.02)     # of a quarter
    assert 0.05 < 0.45 - one.position[2] < 0.2
    energies = record.energies
    assert abs(energies["error"]) < 0.1 * energies["plastic"] and energies["load"] < -0.5 * energies["plastic"]


def test_it_has_no_solution_without_support(tmp_path, monkeypatch):
    monkeypatch.setattr(increments.Support, "at_start", lambda step, length: None)
    with pytest.raises(StepError, match="step 1 failed"):
        list(ball(tmp_path).steps())


def test_a_support_fades_to_nothing_and_does_the_work_of_its_mean(tmp_path):
    simulation = ball(tmp_path)
    step = increments.begin(simulation.model, simulation.state, 0.25, True, Workspace(simulation.model))
    support = Support.at_start(step, 1.0)
    weight = -step.bodies[0].at_start(step.at_rest().displacement, simulation.model.loads.gravity).sum(axis=0)
    assert support.imbalance[0] == pytest.approx(np.where(step.bodies[0].free, -weight, 0.0))
    own = support.under(step).bodies[0]
    assert own.support == pytest.approx(np.outer([1.0, 0.75], support.imbalance[0]))
    before = step.state.bodies[0]
    lower = replace(before, position=before.position - [0.0, 0.0, 0.1])
    assert work_of_support(own, before, lower) == pytest.approx(-0.1 * 0.875 * support.imbalance[0][2])
    last = replace(support, begin=support.begin - 0.75).under(step).bodies[0]
    assert not last.support[1].any()
