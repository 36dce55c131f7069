"""Bodies put on soil with all of their weight at once, without inertia: supported where an increment has no solution."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from put_on_soil import CLAY, put_on_soil

from hybrid.runtime.errors import StepError
from hybrid.setup.build import build
from hybrid.step import increments
from hybrid.step.support import Support, _out_of_balance, work_of_support
from hybrid.step.workspace import Workspace
from hybrid.study.scenes import box, sphere

DENSITY, RADIUS = 4000.0, 0.45
SMALLEST = 0.1      # [s]: shortest increment, with which the ball finds its place
BALL = put_on_soil(
    sphere(RADIUS, size=0.1, growth=0.0, density=DENSITY, rest_on=0.0, held=("x", "y", "rx", "ry", "rz")),
    size=0.15, x=(0.0, 1.2), y=(0.0, 1.2), z=(-1.2, 0.6), material=replace(CLAY, density=1600.0))


def test_a_ball_put_on_clay_sinks_in_until_it_is_borne():
    record, = build(replace(BALL, time=replace(BALL.time, smallest=SMALLEST))).steps()
    one = record.bodies[0]
    assert one.contact_force[2] == pytest.approx(DENSITY * 9.81 * np.pi * RADIUS**3 / 3, rel=0.02)     # of a quarter
    assert 0.05 < RADIUS - one.position[2] < 0.2
    energies = record.energies
    assert abs(energies["error"]) < 0.1 * energies["plastic"] and energies["load"] < -0.5 * energies["plastic"]


def test_it_has_no_solution_without_support(monkeypatch):
    monkeypatch.setattr(increments.Support, "at_start", lambda step, length: None)
    with pytest.raises(StepError, match="step 1 failed"):
        list(build(replace(BALL, time=replace(BALL.time, smallest=SMALLEST))).steps())


@pytest.mark.parametrize("height, supported", [(3.0, True), (1.0, False)])
def test_another_body_takes_the_support_away_only_where_it_may_touch(height, supported):
    """A box held over the ball, whose top is at 0.9 m; the weight of the ball may rest on a body near it."""
    lid = box(0.2, 0.2, 0.1, size=20.0, position=(0.0, 0.0, height), held=("x", "y", "z", "rx", "ry", "rz"), name="lid")
    simulation = build(replace(BALL, bodies=(*BALL.bodies, lid)))
    step = increments.begin(simulation.model, simulation.state, 0.25, True, Workspace(simulation.model))
    assert (Support.at_start(step, 1.0) is not None) == supported


@pytest.mark.parametrize("force, moment, out", [(0.0, 0.0, False), (2.0, 0.0, True), (0.0, 0.2, False), (0.0, 1.2, True)])
def test_a_moment_alone_puts_a_body_out_of_balance(force, moment, out):
    body = SimpleNamespace(body=SimpleNamespace(radius=0.5))
    left, weight = np.array([0.0, 0.0, force, moment, 0.0, 0.0]), np.array([0.0, 0.0, -100.0, 0.0, 0.0, 0.0])
    assert _out_of_balance(body, left, {"weight": weight, "contact": -weight}) == out


def test_a_support_fades_to_nothing_and_does_the_work_of_its_mean():
    simulation = build(BALL)
    step = increments.begin(simulation.model, simulation.state, 0.25, True, Workspace(simulation.model))
    support = Support.at_start(step, 1.0)
    weight = -sum(step.bodies[0].at_start(step.at_rest().displacement, simulation.model.loads.gravity).values())
    assert support.imbalance[0] == pytest.approx(np.where(step.bodies[0].free, -weight, 0.0))
    own = support.under(step).bodies[0]
    assert own.support == pytest.approx(np.outer([1.0, 0.75], support.imbalance[0]))
    before = step.state.bodies[0]
    lower = replace(before, position=before.position - [0.0, 0.0, 0.1])
    assert work_of_support(own, before, lower) == pytest.approx(-0.1 * 0.875 * support.imbalance[0][2])
    last = replace(support, begin=support.begin - 0.75).under(step).bodies[0]
    assert not last.support[1].any()
