"""A coarse anchor, from .geo to its drag through sand: physics, not only completion."""

import numpy as np
import pytest
from demo_scripts import demo

from hybrid.runtime.data import DEMOS
from hybrid.scene.file import load_scene
from hybrid.setup.build import build


@pytest.fixture(scope="module")
def drag():
    """(simulation, records) of the coarse demo."""
    simulation = build(demo("anchor").coarse_anchor(drag_steps=50))
    return simulation, list(simulation.steps())


def of(records, stage):
    return [r for r in records if r.stage == stage]


def test_it_settles_before_the_pull(drag):
    simulation, records = drag
    last = of(records, "settle")[-1].bodies[0]
    weight = 9.81 * simulation.masses[0].mass
    assert abs(last.contact_force[2] - weight) < 0.15 * weight
    assert np.linalg.norm(last.velocity) < 0.1


def test_it_embeds(drag):
    simulation, records = drag
    tip = simulation.meshes[0].named_points["tip"] - simulation.masses[0].centre
    pose = simulation.state.bodies[0]
    assert (pose.position + pose.rotation @ tip)[2] < -0.5
    first, last = of(records, "drag")[0].bodies[0], of(records, "drag")[-1].bodies[0]
    assert last.position[2] < first.position[2] - 0.05
    assert 0.8 < last.position[0] - first.position[0] < 1.3


def test_tension_is_positive_finite_and_of_the_size_of_the_resistance(drag):
    _, records = drag
    tension = np.array([r.bodies[0].line_tension for r in of(records, "drag")])
    assert np.isfinite(tension).all() and (tension >= 0).all()
    assert tension.mean() > 10e3
    assert (tension[-20:] > 0).all()  # before it digs in, the anchor leaps at the first pull and the line slackens
    resistance = -np.array([r.bodies[0].contact_force[0] for r in of(records, "drag")])
    assert tension[-20:].mean() == pytest.approx(resistance[-20:].mean(), rel=0.06)


def test_soil_in_front_heaves(drag):
    simulation, _ = drag
    start, now = simulation.initial_position, simulation.state.points.position
    tip_x = simulation.state.bodies[0].position[0] + 0.8
    front = (start[:, 0] > tip_x - 0.6) & (start[:, 0] < tip_x + 0.8) & (start[:, 1] < 1.2) & (start[:, 2] > -0.4)
    assert (now - start)[front, 2].mean() > 0.03


def test_energy_of_the_drag_balances(drag):
    """On cells of 0.4 m, where the anchor leaps, 1.6 % of what is put in is lost: in the steps and in springs that
    soften. By when it leaps, 0.5 to 3.1 % in nine runs from starts a quarter of a cell and less apart."""
    _, records = drag
    before, after = of(records, "settle")[-1].energies, of(records, "drag")[-1].energies
    put_in = after["pull"] + before["potential"] - after["potential"]
    error = after["error"] - before["error"]
    assert -0.035 * put_in < error < 0.0


@pytest.mark.slow
def test_energy_of_the_demo_balances():
    """demos/anchor.toml: 3.7 % of the work of the pull are missing in the end, 3.0 % in the drag; 3.2 and 2.6 %, in the drag
    2.5 and 1.9 %, from 20 and 50 mm on."""
    records = list(build(load_scene(DEMOS / "anchor.toml")).steps())
    before, after = of(records, "settle")[-1].energies, of(records, "drag")[-1].energies
    assert after["error"] == pytest.approx(-0.032 * after["pull"], abs=0.01 * after["pull"])
    assert abs(after["error"] - before["error"]) < 0.035 * after["pull"]


def test_no_point_leaves_the_grid(drag):
    simulation, _ = drag
    points, extent = simulation.state.points, simulation.model.soil.grid.extent
    assert (points.position - points.half_width >= extent[:, 0] - 1e-9).all()
    assert (points.position + points.half_width <= extent[:, 1] + 1e-9).all()
    assert points.stress.shape == (len(points), 3, 3) and np.isfinite(points.stress).all()


def test_soil_mass_is_carried_by_the_grid(drag):
    simulation, _ = drag
    step = simulation.model.soil.begin(simulation.state.points, simulation.model.gravity)
    assert step.mass.sum() == pytest.approx(simulation.model.soil.constants.mass.sum(), rel=1e-12)
