"""What a stage makes of the model, and the state at its start: guides, rules, loads, lines."""

from dataclasses import replace

import numpy as np
import pytest

from hybrid.body.rigid import FREEDOMS
from hybrid.laws.hencky import Hencky
from hybrid.scene import Axis, Faces, Grid, Pull, Stage
from hybrid.scheme import Scheme
from hybrid.setup.build import build
from hybrid.study.scenes import box, elastic, plane, scene

SPEED, WEIGHT = 0.5, np.array([0.0, 0.0, -9.81])


@pytest.fixture(scope="module")
def simulation():
    """Two boxes over held soil: one free, one driven along x and held in rotation."""
    side = Axis(start=0.0, end=2.0, size=0.5)
    bodies = (box(0.4, 0.4, 0.2, name="free", position=(0.5, 0.5, 1.0), velocity=(0.0, SPEED, 0.0)),
              box(0.4, 0.4, 0.2, name="driven", position=(1.5, 1.5, 1.0), velocity=(SPEED, 0.0, 0.0), driven=("x",),
                  held=("rx", "ry", "rz")))
    return build(scene("two", Grid(side, side, Axis(start=-0.5, end=0.0, size=0.5), Faces()), elastic(1e6), bodies,
                       0.01, [Stage("fly", 1)], soil={"held": True}, gravity=tuple(WEIGHT)))


def freedoms(body):
    return [name for name, free in zip(FREEDOMS, body.free) if free]


def test_a_stage_holds_more_components_of_every_body(simulation):
    model = simulation.model
    assert [freedoms(b) for b in model.bodies] == [list(FREEDOMS), ["y", "z"]] and model.body_unknowns == 8
    stage = model.for_stage(held=("x", "rz"))
    assert [freedoms(b) for b in stage.bodies] == [["y", "z", "rx", "ry"], ["y", "z"]] and stage.body_unknowns == 6
    assert model.bodies[1].drive[0] == SPEED and not stage.bodies[1].drive.any()     # held is stronger than driven
    assert model.for_stage().body_unknowns == model.body_unknowns == 8


def test_a_stage_may_have_its_own_rule_and_loads(simulation):
    loads, scheme = simulation.model.loads.during(0.0, 1.0, (0.0, 0.5)), simulation.model.scheme
    stage = simulation.model.for_stage(beta=0.5625, gamma=1.0, loads=loads)
    assert stage.scheme == Scheme.newmark(0.5625, 1.0) and simulation.model.scheme is scheme != stage.scheme
    assert not stage.loads.gravity_alone and np.array_equal(stage.gravity, WEIGHT)
    assert np.array_equal(stage.loads.on_bodies(1.0), 0.5 * WEIGHT)


def test_the_impulse_that_stops_a_body_is_work_of_the_drive(simulation):
    stage, mass = simulation.model.for_stage(held=("y",)), simulation.masses[0].mass
    state = stage.begin_stage(simulation.state)
    assert not state.bodies[0].velocity.any() and state.bodies[1].velocity[0] == SPEED
    assert state.work["drive"] == pytest.approx(-0.5 * mass * SPEED**2)
    assert simulation.state.bodies[0].velocity[1] == SPEED and not simulation.state.work     # the old state is kept


def test_contact_stiffness_is_that_of_the_soil(simulation):
    """Half of the points, of three times the modulus: on soil that deforms the stiffness follows it."""
    model = simulation.model
    soil = model.soil
    fewer = replace(soil, law=Hencky(3.0 * soil.law.young[::2], 0.3), held=False)
    for given, factor in ((fewer, fewer.law.young), (replace(fewer, held=True), np.ones(len(fewer.law.young)))):
        other = model.with_soil(given)
        for one, new in zip(model.bodies, other.bodies):
            assert new.contact_pressure == pytest.approx(one.penalty * factor)


def test_works_of_a_pulled_body():
    """A line pulls at 1 m/s, its end moves Δt; the mean of its force at both ends of a step works along that way."""
    pull = Pull((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 1e4, 2.0)
    simulation = build(plane(box(1.0, 1.0, 0.2, rest_on=0.5, pull=pull, held=("y", "z", "rx", "ry", "rz")), 3, 0.01))
    tensions, works = [0.0], []
    for record in simulation.steps():
        tensions.append(record.bodies[0].line_tension)
        works.append(record.energies["pull"])
    means = 0.5 * (np.array(tensions[1:]) + tensions[:-1])
    assert means[-1] > 0 and works == pytest.approx(0.01 * np.cumsum(means), rel=1e-9)
    assert record.energies["drive"] == record.energies["load"] == 0.0
