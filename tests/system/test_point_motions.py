"""Motion of a named point of a body: closed form of a plate driven at its corner, work, release, checkpoint, refusals."""

from dataclasses import replace

import numpy as np
import pytest
from differences import central
from scipy.integrate import solve_ivp

from hybrid.body.attitude import exp_so3
from hybrid.body.guides import Guide
from hybrid.body.point_guides import PointGuide
from hybrid.body.table import Table
from hybrid.output.checkpoint import load, save
from hybrid.runtime.data import DEMOS
from hybrid.runtime.errors import SceneError
from hybrid.scene import Joint, Motion, Stage
from hybrid.scene.file import load_scene, validate
from hybrid.setup.build import build
from hybrid.study.scenes import box, plane

SIDES, CORNER, SPEED = (0.6, 0.4, 0.1), (0.3, 0.2, 0.0), 0.8
IN_PLANE = ("z", "rx", "ry")


def plate(stages, step=0.01, gravity=(0.0, 0.0, 0.0), joints=(), **body):
    """A plate high above held soil."""
    described = plane(box(*SIDES, position=(0.0, 0.0, 3.0), **body), 1, step, gravity=gravity,
                      solver={"linear": "direct", "tolerance": 1e-9})
    return replace(described, stages=stages, joints=joints)


def drive(steps, **motion):
    return Stage("drive", steps, motions=(Motion(point=CORNER, **motion),))


def run(scene):
    simulation, motions = build(scene), []
    return simulation, [motions.append(simulation.state.bodies[0]) or record for record in simulation.steps()], motions


def corner(simulation, motion):
    return motion.position + motion.rotation @ (np.array(CORNER) - simulation.masses[0].centre)


def turned(time):
    """Angle [rad] of the plate whose corner moves along x at SPEED from rest: ½ (J + m r² sin²φ) φ'² is constant."""
    mass = 1000.0 * np.prod(SIDES)
    inertia = mass * (SIDES[0]**2 + SIDES[1]**2) / 12
    arm, first = np.hypot(*CORNER[:2]), np.arctan2(CORNER[1], CORNER[0])

    def all_of_it(phi):
        return inertia + mass * arm**2 * np.sin(phi)**2

    rate = -arm * np.sin(first) * mass * SPEED / all_of_it(first)
    way = solve_ivp(lambda _, phi: rate * np.sqrt(all_of_it(first) / all_of_it(phi)), (0, time), [first], rtol=1e-11,
                    atol=1e-12)
    return way.y[0, -1] - first


def test_a_plate_driven_at_its_corner_turns_as_integrated_with_second_order():
    """And the corner is where the table has it to round-off; the work of the drive is the kinetic energy."""
    missed = []
    for steps in (20, 40):
        simulation, records, motions = run(plate((drive(steps, component="x", velocity=SPEED),), 0.4 / steps, held=IN_PLANE))
        at = np.array([corner(simulation, motion)[0] for motion in motions]) - CORNER[0]
        np.testing.assert_allclose(at, SPEED * 0.4 / steps * np.arange(1, steps + 1), atol=1e-10)
        angle = np.arctan2(motions[-1].rotation[1, 0], motions[-1].rotation[0, 0])
        missed.append(abs(angle - turned(0.4)))
        work = records[-1].bodies[0].work["0.3_0.2_0 x"]
        assert work == pytest.approx(records[-1].energies["kinetic"], rel=0.04 / steps)     # the scheme damps
        assert work == records[-1].energies["drive"]
    assert missed[1] < 1e-3 and np.log2(missed[0] / missed[1]) > 1.7
    columns = " ".join(records[-1].row())
    assert "body_reaction_0.3_0.2_0_fx_N" in columns and "body_drive_0.3_0.2_0_x_J" in columns


def test_work_is_reaction_times_motion_under_a_weight():
    """A plate lifted slowly at its corner by a table of displacements hangs from it in the end: reaction m g, work of the
    drive against the weight."""
    stages = (replace(drive(200, component="z", displacement=((0.0, 0.0), (1.0, 0.2)), held=("x", "y")),),)
    simulation, records, motions = run(plate(stages, 0.01, (0.0, 0.0, -9.81)))
    np.testing.assert_allclose(corner(simulation, motions[-1]), np.add(CORNER, (0.0, 0.0, 3.2)), atol=1e-9)
    error = np.abs([record.energies["error"] for record in records]).max()
    assert error < 0.02 * max(record.energies["kinetic"] for record in records)


def test_a_released_point_flies_on():
    """Without gravity nothing acts from then on: centre and spin keep their rates."""
    stages = (drive(12, component="x", velocity=((0.0, 0.0), (0.12, SPEED))), Stage("fly", 6))
    simulation, records, motions = run(plate(stages, held=IN_PLANE))
    np.testing.assert_allclose(motions[-1].velocity, motions[12].velocity, atol=2e-3 * SPEED)
    np.testing.assert_allclose(motions[-1].spin, motions[12].spin, atol=2e-3 * abs(motions[12].spin[2]))
    assert not records[-1].bodies[0].reaction.keys() & {"0.3_0.2_0 x"}
    assert records[-1].energies["drive"] == records[11].energies["drive"]


def test_a_resumed_run_is_the_run_in_one_go(tmp_path):
    stages = (Stage("wait", 2), drive(6, component="x", velocity=((0.0, 0.0), (0.05, SPEED))), Stage("fly", 2))
    scene = plate(stages, joints=(Joint("pin", "rod", ("body",), (-0.3, 0.0, 0.0), end=(-1.5, 0.0, 3.0)),))
    whole, _, _ = run(scene)
    for steps in (4, 8):
        first = build(scene)
        for record in first.steps():
            if record.step == steps:
                break
        save(tmp_path / "c.npz", first.state, first.scene)
        second = build(scene)
        second.resume(load(tmp_path / "c.npz", second.scene))
        list(second.steps())
        for name in ("position", "rotation", "velocity", "spin"):
            assert np.array_equal(getattr(second.state.bodies[0], name), getattr(whole.state.bodies[0], name))
        assert second.state.work == whole.state.work


def test_gradient_and_curvature_by_differences():
    pose = np.array([0.3, -0.2, 0.5]), exp_so3([0.5, -0.9, 0.3])
    other = np.zeros(3), np.eye(3)
    guide = PointGuide("p", np.array([0.8, 0.1, -0.4]), Guide(1, Table.of(((0.0, 1.0),), 0.0), True), (0, None))

    def at(q):
        return (pose[0] + q[:3], exp_so3(q[3:]) @ pose[1]), other

    gradient = guide.rows((pose, other), 0.1)[1]
    np.testing.assert_allclose(gradient[:, :6], central(lambda q: guide.rows(at(q), 0.1)[0], 6), atol=1e-9)
    bent = guide.curvature((pose, other), np.array([3.0]))
    np.testing.assert_allclose(bent[:6, :6], central(lambda q: 3.0 * guide.rows(at(q))[1][0, :6], 6), atol=1e-8)
    assert not bent[6:].any() and not gradient[:, 6:].any()


@pytest.mark.parametrize("motion, text", [
    ({"held": ("rx",)}, "translations with a point"), ({"free": ("x",)}, "left out with a point")])
def test_motions_that_a_point_does_not_have_are_refused(motion, text):
    with pytest.raises(SceneError, match=text):
        validate(plate((drive(2, **motion),)))


def test_a_point_that_cannot_move_and_one_that_is_not_there_are_refused():
    with pytest.raises(SceneError, match="leave no freedom"):
        build(plate((drive(2, component="z", velocity=0.1),), held=IN_PLANE))
    with pytest.raises(SceneError, match="not a physical point"):
        build(plate((Stage("a", 2, motions=(Motion(point="nose", held=("x",)),)),)))
    with pytest.raises(SceneError, match="one that damps"):
        validate(replace(plate((drive(2, held=("x",)),)), time=replace(plate(()).time, scheme="energy-momentum")))


def test_the_plate_of_the_demo_is_pressed_dragged_at_its_corner_and_released():
    """The force on the way is near α s_u B = 1 kN; the corner follows the CSV table; the released plate springs back a
    little."""
    coarse = [f"grid.{axis}.size=0.25" for axis in "xz"]
    scene = load_scene(DEMOS / "stages.toml", [*coarse, "output.pictures=[]"])
    simulation = build(scene)
    records, at = [], []
    for record in simulation.steps():
        body = simulation.state.bodies[0]
        records.append(record)
        at.append(float((body.position + body.rotation @ (0.5, 0.0, 0.125))[0]))
    way = np.interp(np.arange(1, 21), [0, 5, 10, 15, 20], [0.0, 0.05, 0.15, 0.15, 0.25])
    np.testing.assert_allclose(np.array(at[10:30]) - at[9], way, atol=1e-7)
    force = np.array([record.bodies[0].reaction["0.5_0_0.125 x"] for record in records[10:30]])
    assert 700.0 < force.mean() < 1000.0
    assert -0.01 < at[-1] - at[29] < 0.0 and not records[-1].bodies[0].reaction.get("x", 0.0)
