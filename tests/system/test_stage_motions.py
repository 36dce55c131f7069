"""Motions and loads of bodies by stage: closed forms of flight, balance of energy, tangent of a load, press and drag."""

from dataclasses import replace

import numpy as np
import pytest

from hybrid.body.attitude import exp_so3
from hybrid.body.guides import PointLoad, load_on
from hybrid.body.table import Table
from hybrid.output.checkpoint import load, save
from hybrid.runtime.errors import SceneError
from hybrid.scene import Axis, Faces, Grid, Load, Motion, Stage
from hybrid.scene.file import validate
from hybrid.setup.build import build
from hybrid.study.scenes import SCHEMES, box, elastic, plane, scene

STEP = 0.01
every_scheme = pytest.mark.parametrize("options", SCHEMES.values(), ids=SCHEMES)
TURNS = ("rx", "ry", "rz")


def flying(options, stages, gravity=(0.0, 0.0, 0.0), **body):
    """A box high above held soil; (simulation, records of its steps, states of the box after them)."""
    described = plane(box(0.5, 0.4, 0.2, position=(0.0, 0.0, 2.0), **body), 1, STEP, gravity=gravity, time=options)
    simulation, motions = build(replace(described, stages=stages)), []
    records = [motions.append(simulation.state.bodies[0]) or record for record in simulation.steps()]
    return simulation, records, motions


def missed(records):
    """Energy that the balance misses, relative to the largest term in it."""
    scale = max(abs(value) for record in records for value in record.energies.values())
    return np.abs([record.energies["error"] for record in records]).max() / scale


@every_scheme
def test_a_constant_force_and_then_another_one(options):
    """Free flight under F/m, which the next stage changes: exact from the first step, work F·x."""
    mass = 0.5 * 0.4 * 0.2 * 1000.0
    first, second = np.array([3.0, 0.0, -2.0]), np.array([0.0, 5.0, 4.0])
    stages = (Stage("one", 6, loads=(Load(force=tuple(mass * first)),)),
              Stage("two", 6, loads=(Load(force=tuple(mass * second)),)))
    _, records, motions = flying(options, stages)
    for n, motion in enumerate(motions, 1):
        one, two = STEP * min(n, 6), STEP * max(n - 6, 0)
        way = 0.5 * first * one**2 + first * one * two + 0.5 * second * two**2
        np.testing.assert_allclose(motion.position - (0.0, 0.0, 2.0), way, atol=1e-13)
    assert missed(records) < 1e-10 or options.get("gamma") == 1.0
    at_change = motions[5].position - (0.0, 0.0, 2.0)
    work = mass * (first @ at_change + second @ (motions[-1].position - motions[5].position))
    assert records[-1].energies["load"] == pytest.approx(work, rel=1e-12)
    assert records[-1].bodies[0].work["load"] == pytest.approx(work, rel=1e-12)
    np.testing.assert_allclose(records[-1].bodies[0].load[:3], mass * second)


def test_a_force_beside_the_centre_turns_the_body():
    """W = J⁻¹ (r × F) t about a principal axis for short times, energy kept by energy-momentum."""
    stages = (Stage("go", 20, loads=(Load(point=(0.0, 0.2, 0.1), force=(200.0, 0.0, 0.0)),)),)
    simulation, records, motions = flying({"scheme": "energy-momentum"}, stages)
    centre = simulation.masses[0].centre
    moment = np.cross(np.array([0.0, 0.2, 0.1]) - centre, [200.0, 0.0, 0.0])
    np.testing.assert_allclose(motions[0].rotation @ motions[0].spin,
                               np.linalg.solve(simulation.masses[0].inertia, moment) * STEP, rtol=2e-3, atol=5e-4)
    assert missed(records) < 1e-9


@every_scheme
def test_a_ramp_of_velocity_needs_mass_times_acceleration(options):
    """x driven by a table: displacement its integral, reaction m a, work ½ m v²; then released it flies on."""
    mass, ramp = 40.0, ((0.0, 0.0), (0.06, 0.6))
    stages = (Stage("drive", 12, motions=(Motion(component="x", velocity=ramp),)), Stage("fly", 4))
    _, records, motions = flying(options, stages)
    for n, (record, motion) in enumerate(zip(records, motions), 1):
        t = n * STEP
        assert motion.position[0] == pytest.approx(5 * min(t, 0.06)**2 + 0.6 * max(t - 0.06, 0.0), abs=1e-12)
        if n <= 12:
            assert motion.reaction[0] == pytest.approx(mass * 10.0 * (n <= 6), abs=1e-8)
            assert record.bodies[0].reaction["x"] == motion.reaction[0]
        assert motion.velocity[0] == pytest.approx(10 * min(t, 0.06), abs=1e-11)
    assert records[11].bodies[0].work["x"] == pytest.approx(0.5 * mass * 0.36, rel=1e-10)
    assert "drive_x_J" in " ".join(records[11].row()) and "reaction_fx_N" in " ".join(records[11].row())
    assert not records[-1].bodies[0].reaction
    assert missed(records) < 1e-10


@every_scheme
def test_a_displacement_changes_at_constant_velocity_with_jolts_between(options):
    stages = (Stage("drive", 12, motions=(
        Motion(component="ry", displacement=((0.02, 0.0), (0.05, 9.0), (0.1, 0.0))), Motion(held=("x", "y")))),)
    _, records, motions = flying(options, stages)
    angle = np.interp(STEP * np.arange(1, 13), [0.02, 0.05, 0.1], [0.0, np.pi / 20, 0.0])
    found = [np.arctan2(m.rotation[0, 2], m.rotation[0, 0]) for m in motions]
    np.testing.assert_allclose(found, angle, atol=1e-12)
    assert missed(records) < 1e-9
    assert motions[-1].spin == pytest.approx(0.0, abs=1e-12)


@every_scheme
def test_what_a_stage_releases_falls_freely_from_its_start(options):
    held = ("x", "y", "z", *TURNS)
    stages = (Stage("fall", 3, motions=(Motion(free=("z",)),)), Stage("stop", 2),
              Stage("slide", 3, motions=(Motion(body="body", free=("x",)),)))
    _, records, motions = flying(options, stages, (2.0, 0.0, -9.81), held=held)
    for n in (1, 2, 3):
        assert motions[n - 1].position[2] == pytest.approx(2.0 - 0.5 * 9.81 * (n * STEP)**2, abs=1e-13)
        assert motions[n + 4].position[0] == pytest.approx((n * STEP)**2, abs=1e-13)
    np.testing.assert_allclose(motions[4].position, motions[2].position)
    assert missed(records) < 1e-10


def test_the_tangent_of_a_load_by_differences():
    at, rotation = 0.4, exp_so3([0.5, -0.9, 0.3])
    loads = (PointLoad(np.array([0.8, 0.1, -0.4]), Table.of([(0.0, 1.0, 2.0, 3.0), (1.0, 9.0, -2.0, 1.0)], 0.0)),
             PointLoad(np.zeros(3), None, Table.of([(0.0, 5.0, 6.0, -7.0)], 0.0)))
    _, tangent = load_on(loads, rotation, at)
    h = 1e-6
    fd = np.array([(load_on(loads, exp_so3(h * e) @ rotation, at)[0] - load_on(loads, exp_so3(-h * e) @ rotation, at)[0])
                   / (2 * h) for e in np.eye(3)]).T
    np.testing.assert_allclose(tangent[:, 3:], fd, atol=1e-8)
    assert not tangent[:, :3].any()


# ------------------------------------------------------------------ press, then drag


def pressed_and_dragged():
    """A plate over all of the soil, loaded with 1 kN, then dragged by 2 cm under that load, on elastic soil with
    friction; quasi-static, with a checkpoint due after step 4."""
    side = Axis(start=-0.4, end=0.4, size=0.2)
    down = Load(force=(0.0, 0.0, -1000.0))
    plate = box(1.06, 1.06, 0.1, size=0.2, rest_on=0.0, held=("x", "y", *TURNS), friction=0.3)
    stages = [Stage("press", 2, loads=(Load(force=((0.0, 0.0, 0.0, 0.0), (1.0, 0.0, 0.0, -1000.0))),)),
              Stage("drag", 4, motions=(Motion(component="x", displacement=((0.0, 0.0), (2.0, 0.02))),), loads=(down,))]
    made = scene("drag", Grid(side, side, Axis(start=-0.4, end=0.2, size=0.2), Faces()), elastic(1e6, 0.25), [plate],
                 0.5, stages, soil={"top": 0.0}, time={"inertia": False}, solver={"linear": "direct", "tolerance": 1e-9})
    return replace(made, output=replace(made.output, checkpoint=4))


def test_a_pressed_plate_is_dragged_with_the_force_of_friction(tmp_path):
    simulation = build(pressed_and_dragged())
    records = []
    for record in simulation.steps():
        records.append(record)
        if record.step == 4:
            save(tmp_path / "checkpoint.npz", simulation.state, simulation.scene)
    forces = np.array([record.bodies[0].contact_force for record in records])
    np.testing.assert_allclose(forces[:, 2], [500.0, 1000.0, 1000.0, 1000.0, 1000.0, 1000.0], rtol=1e-6)
    assert records[-1].bodies[0].reaction["x"] == pytest.approx(300.0, rel=1e-6)
    reaction = [r.bodies[0].reaction["x"] for r in records[1:]]
    assert records[-1].bodies[0].work["x"] == pytest.approx(
        0.005 * sum(0.5 * (a + b) for a, b in zip(reaction, reaction[1:])), rel=1e-9)
    again = build(pressed_and_dragged())
    again.resume(load(tmp_path / "checkpoint.npz", again.scene))
    rest = list(again.steps())
    assert [r.row() | {"krylov": 0} | dict.fromkeys([k for k in r.row() if "seconds" in k]) for r in rest] == [
        r.row() | {"krylov": 0} | dict.fromkeys([k for k in r.row() if "seconds" in k]) for r in records[4:]]


# ------------------------------------------------------------------ refusals

ONE = Motion(component="x", velocity=0.1)


@pytest.mark.parametrize("stage, match", [
    (Stage("a", 1, motions=(Motion(component="x"),)), "one of velocity and displacement, but has none"),
    (Stage("a", 1, motions=(Motion(velocity=0.1),)), "stage.0.motion.0: must be a motion|component = left out"),
    (Stage("a", 1, motions=(ONE, Motion(held=("x",)))), "in stage.0.motion.0 too"),
    (Stage("a", 1, motions=(Motion(body="ship", held=("x",)),)), "body = 'ship': must be one of body"),
    (Stage("a", 1, loads=(Load(),)), "a force or a moment"),
    (Stage("a", 1, loads=(Load(point="eye", moment=(1.0, 0.0, 0.0)),)), "a moment has no point"),
    (Stage("a", 1, loads=(Load(force=((1.0, 0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))),)), "times must increase"),
])
def test_contradictions_are_refused(stage, match):
    with pytest.raises(SceneError, match=match):
        validate(replace(plane(box(0.5, 0.4, 0.2), 1, STEP), stages=(stage,)))


def test_a_point_that_the_geometry_does_not_have_is_refused():
    stage = Stage("a", 1, loads=(Load(point="eye", force=(1.0, 0.0, 0.0)),))
    with pytest.raises(SceneError, match=r"stage.0.load.point = 'eye' is not a physical point"):
        build(replace(plane(box(0.5, 0.4, 0.2, position=(0.0, 0.0, 2.0)), 1, STEP), stages=(stage,)))
