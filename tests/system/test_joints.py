"""Joined bodies: double pendulum, a spinning hinged pair, rods, lines, welds."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from hybrid.body.attitude import exp_so3
from hybrid.linalg.petsc import BlockSystem
from hybrid.output.checkpoint import load, save
from hybrid.runtime.data import DEMOS
from hybrid.runtime.errors import SceneError
from hybrid.scene import Axis, Body, Faces, Grid, Joint, Load, Motion, Stage
from hybrid.scene.file import load_scene, validate
from hybrid.setup.build import build
from hybrid.step import joint_rates
from hybrid.step.equations import begin
from hybrid.step.evaluation import Unknowns
from hybrid.step.joint_rates import second_rates_of_rows
from hybrid.step.workspace import Workspace
from hybrid.study.scenes import GEOMETRY, box, elastic, plane
from hybrid.study.scenes import scene as soil_box
from tests.helpers.joined import CENTRE, G, GRAVITY, LENGTHS, TIGHT, arm, bar, joined, pendulum


def double_pendulum(steps, step):
    first, second = LENGTHS
    scene = pendulum(steps, step)
    pin = Joint("knee", "hinge", ("lower", "upper"), (-second / 2, 0.0, CENTRE), axis=(0.0, 1.0, 0.0))
    return replace(scene, bodies=(*scene.bodies, arm("lower", second, first + second / 2)), joints=(*scene.joints, pin))


def double_reference(time):
    """Angles from the downward vertical of both bars, released at rest from the horizontal."""
    (m1, i1), (m2, i2), (long, short) = bar(LENGTHS[0]), bar(LENGTHS[1]), LENGTHS
    l1, l2 = long / 2, short / 2

    def rates(_, y):
        a, b, u, v = y
        mass = np.array([[i1 + m1 * l1**2 + m2 * long**2, m2 * long * l2 * np.cos(a - b)],
                         [m2 * long * l2 * np.cos(a - b), i2 + m2 * l2**2]])
        force = [-m2 * long * l2 * np.sin(a - b) * v * v - (m1 * l1 + m2 * long) * G * np.sin(a),
                 m2 * long * l2 * np.sin(a - b) * u * u - m2 * G * l2 * np.sin(b)]
        return [u, v, *np.linalg.solve(mass, force)]

    return solve_ivp(rates, (0.0, time), [np.pi / 2, np.pi / 2, 0.0, 0.0], "DOP853", rtol=1e-12, atol=1e-12).y[:, -1]


def double_error(steps, duration=1.0, **time):
    scene = double_pendulum(steps, duration / steps)
    simulation = build(replace(scene, time=replace(scene.time, **time)))
    records = list(simulation.steps())
    a, b = double_reference(duration)[:2]
    (long, short), upper, lower = LENGTHS, *(motion.position for motion in simulation.state.bodies)
    expected = np.array([[0.5 * long * np.sin(a), 0.0, -0.5 * long * np.cos(a)],
                         [long * np.sin(a) + 0.5 * short * np.sin(b), 0.0,
                          -long * np.cos(a) - 0.5 * short * np.cos(b)]]) + (0.0, 0.0, 5.0 + CENTRE)
    return np.linalg.norm(np.array([upper, lower]) - expected), simulation, records


def test_double_pendulum_converges_to_an_accurate_integration_with_second_order():
    errors = [double_error(steps, 0.5)[0] for steps in (50, 100, 200)]
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[-1] < 5e-3 and (rates > 1.7).all(), (errors, rates)


def test_the_demo_of_joints_is_near_an_accurate_integration():
    """Angles of both hinges after half a second."""
    simulation = build(load_scene(DEMOS / "joints.toml", ["output.pictures=[]"]))
    *_, record = simulation.steps()
    a, b = double_reference(0.5)[:2]
    assert record.joints[0].angle == pytest.approx(90.0 - np.degrees(a), abs=0.02)
    assert record.joints[1].angle == pytest.approx(np.degrees(a - b), abs=0.12)


def test_the_order_is_lost_with_a_scheme_of_first_order():
    errors = [double_error(steps, 0.5, beta=0.5625, gamma=1.0)[0] for steps in (50, 100)]
    assert np.log2(errors[0] / errors[1]) < 1.4


def test_a_stage_that_changes_nothing_leaves_joined_bodies_as_they_move():
    """One that holds a component changes their rates: a projection of them would book work of a drive."""
    def ended(stages, **values):
        scene = double_pendulum(40, 0.02)
        simulation = build(replace(scene, stages=tuple(
            replace(scene.stages[0], name=f"stage {i}", steps=40 // stages, **(values if i else {}))
            for i in range(stages))))
        *_, record = simulation.steps()
        return np.array([body.position for body in record.bodies]), record.energies["drive"]

    (whole, drive), (parts, of_parts), (held, of_held) = ended(1), ended(4), ended(2, held=("y",))
    assert np.array_equal(whole, parts) and drive == of_parts == 0.0
    assert of_held != 0.0 and not np.array_equal(whole, held)


def test_joined_bodies_let_go_at_a_point_accelerate_as_their_joints_allow():
    """A drive has held the end of a double pendulum; what it pushed with accelerates that body alone before."""
    scene = double_pendulum(1, 0.01)
    held = Motion(body="lower", component="z", point=(0.2, 0.0, CENTRE), velocity=-0.3)
    simulation = build(replace(scene, stages=(Stage("driven", 5, motions=(held,)), Stage("free", 5))))
    for _ in zip(range(5), simulation.steps()):
        pass
    before, model = simulation.stage_model(0, 0.0), simulation.stage_model(1, 0.05)
    state = model.begin_stage(simulation.state, before)
    assert np.abs(second_rates_of_rows(model.joints, state.bodies)).max() < 1e-6
    released = joint_rates.released(model, simulation.state, before.guides)
    assert np.abs(second_rates_of_rows(model.joints, released.bodies)).max() > 1.0


def test_joints_hold_to_round_off_and_their_forces_are_in_the_history():
    _, simulation, records = double_error(50)
    upper, lower = simulation.state.bodies
    knee = upper.position + upper.rotation @ (LENGTHS[0] / 2, 0.0, 0.0)
    np.testing.assert_allclose(knee, lower.position - lower.rotation @ (LENGTHS[1] / 2, 0.0, 0.0), atol=1e-7)
    row = records[-1].row()
    assert {"pin_fx_N", "pin_my_Nm", "knee_angle_deg"} <= set(row)
    assert abs(row["pin_fy_N"]) < 1e-6
    forces = np.array([[record.joints[0].force[:3], record.joints[1].force[:3]] for record in records])
    masses = [mass.mass for mass in simulation.masses]
    accelerations = simulation.state.bodies[1].acceleration
    np.testing.assert_allclose(forces[-1, 1], masses[1] * (accelerations + (0.0, 0.0, G)), rtol=1e-5, atol=1e-3)


# ------------------------------------------------------------------ in space


def pair_reference(simulation, joint, time):
    """Positions of two hinged bodies after free flight, from accelerations with constraint forces, to round-off."""
    start = simulation.initial_bodies
    mass = np.array([m.mass for m in simulation.masses])
    inertia = [m.inertia for m in simulation.masses]
    arms, axis = joint.points, np.cross(joint.turning[1], joint.turning[2])

    def rates(_, y):
        x, v, w = y[:6].reshape(2, 3), y[6:12].reshape(2, 3), y[12:18].reshape(2, 3)
        turn = [Rotation.from_quat(q / np.linalg.norm(q)).as_matrix() for q in y[18:].reshape(2, 4)]
        s = [turn[i] @ arms[i] for i in (0, 1)]
        e = turn[1] @ axis
        across = np.linalg.svd(e[None])[2][1:]
        kkt, rhs = np.zeros((17, 17)), np.zeros(17)
        for i, sign in ((0, 1.0), (1, -1.0)):
            full = turn[i] @ inertia[i] @ turn[i].T
            own = slice(6 * i, 6 * i + 6)
            kkt[own, own] = np.block([[mass[i] * np.eye(3), np.zeros((3, 3))], [np.zeros((3, 3)), full]])
            rhs[6 * i + 3:6 * i + 6] = -np.cross(w[i], full @ w[i])
            tilde = np.array([[0, -s[i][2], s[i][1]], [s[i][2], 0, -s[i][0]], [-s[i][1], s[i][0], 0]])
            kkt[12:15, 6 * i:6 * i + 3], kkt[12:15, 6 * i + 3:6 * i + 6] = sign * np.eye(3), -sign * tilde
            kkt[15:, 6 * i + 3:6 * i + 6] = sign * across
            rhs[12:15] -= sign * np.cross(w[i], np.cross(w[i], s[i]))
        rhs[15:] = across @ np.cross(w[1], e) * ((w[0] - w[1]) @ e)
        kkt[:12, 12:] = kkt[12:, :12].T
        a = np.linalg.solve(kkt, rhs)[:12].reshape(2, 2, 3)
        turning = [quaternion_rate(w[i], y[18 + 4 * i:22 + 4 * i]) for i in (0, 1)]
        return np.concatenate([v.ravel(), a[:, 0].ravel(), a[:, 1].ravel(), *turning])

    y = np.concatenate([*(b.position for b in start), *(b.velocity for b in start), *(b.rotation @ b.spin for b in start),
                        *(Rotation.from_matrix(b.rotation).as_quat() for b in start)])
    end = solve_ivp(rates, (0.0, time), y, "DOP853", rtol=1e-11, atol=1e-11).y[:, -1]
    return end[:6].reshape(2, 3)


def quaternion_rate(w, q):
    """dq/dt of a quaternion (x, y, z, w) for a spin in space."""
    return 0.5 * np.concatenate([q[3] * w + np.cross(w, q[:3]), [-w @ q[:3]]])


def spinning(steps, duration=0.5):
    """A bar and a box on a hinge, tumbling in free flight: rates of one rigid body, and a rotation about the hinge."""
    spin, hinge, turn = np.array([3.0, -2.0, 4.0]), np.array([0.3, 0.0, 5.0]), np.array([1.0, 0.0, 1.0])
    centres = np.array([[0.0, 0.0, 5.0], [0.5, 0.0, 5.0]])
    spins = [spin + 2.5 * turn, spin]
    bodies = [box(0.6, 0.1, 0.08, name="bar", position=(0.0, 0.0, 5.0), spin=tuple(spins[0]),
                  velocity=tuple(np.cross(spins[0], centres[0] - hinge))),
              box(0.4, 0.2, 0.08, name="box", position=(0.5, 0.0, 5.0), spin=tuple(spins[1]),
                  velocity=tuple(np.cross(spins[1], centres[1] - hinge)))]
    joint = Joint("pin", "hinge", ("bar", "box"), (0.3, 0.0, CENTRE), axis=tuple(turn))
    return joined(bodies, [joint], steps, duration / steps, gravity=(0.0, 0.0, 0.0))


def test_a_spinning_hinged_pair_converges_with_second_order():
    errors = []
    for steps in (50, 100, 200):
        simulation = build(spinning(steps))
        joint, start = simulation.model.joints[0], sum(
            m.mass * b.velocity for m, b in zip(simulation.masses, simulation.initial_bodies))
        list(simulation.steps())
        end = sum(m.mass * b.velocity for m, b in zip(simulation.masses, simulation.state.bodies))
        np.testing.assert_allclose(end, start, atol=1e-6 * np.linalg.norm(start))
        expected = pair_reference(simulation, joint, 0.5)
        errors.append(np.linalg.norm([b.position for b in simulation.state.bodies] - expected))
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[-1] < 2e-3 and (rates > 1.7).all(), (errors, rates)


def welded(steps):
    """Largest difference of the positions of a bar, and of two halves of it that are welded, pushed at an end for 0.2 s."""
    bodies = [arm("one", 0.3, 0.15), arm("other", 0.3, 0.45)]
    weld = Joint("weld", "weld", ("one", "other"), (0.15, 0.0, CENTRE))
    push = Stage("push", steps, loads=(Load(body="one", point=(-0.15, 0.0, CENTRE), force=(0.0, 0.0, 20.0)),))
    two = build(replace(joined(bodies, [weld], 1, 0.2 / steps), stages=(push,)))
    whole = replace(push, loads=(replace(push.loads[0], body="body", point=(-0.3, 0.0, CENTRE)),))
    one = build(replace(plane(arm("body", 0.6, 0.3), 1, 0.2 / steps, gravity=GRAVITY, solver=TIGHT), stages=(whole,)))
    for simulation in (two, one):
        list(simulation.steps())
    np.testing.assert_allclose(two.state.bodies[1].rotation, two.state.bodies[0].rotation, atol=1e-7)
    return np.abs(0.5 * (two.state.bodies[0].position + two.state.bodies[1].position)
                  - one.state.bodies[0].position).max() + (
        np.abs(two.state.bodies[1].rotation - one.state.bodies[0].rotation).max())


def test_a_weld_makes_one_body_of_two():
    errors = np.array([welded(steps) for steps in (20, 40, 80)])
    assert errors[-1] < 3e-4 and (np.log2(errors[:-1] / errors[1:]) > 1.7).all(), errors


@pytest.mark.parametrize("kind", ["rod", "line"])
def test_a_weight_on_a_rod_or_a_line_hangs_by_its_weight(kind):
    """A line that is longer than the way to its end lets the body fall until it is taut, then stops it."""
    length = 1.0 if kind == "rod" else 1.2
    joint = Joint("cable", kind, ("upper",), (0.0, 0.0, CENTRE), end=(0.3, 0.0, 6.0), length=length)
    simulation = build(joined([arm("upper", 0.6, 0.3)], [joint], 60, 0.01))
    records = list(simulation.steps())
    mass, _ = bar(0.6)
    assert records[-1].joints[0].force[2] == pytest.approx(mass * G, rel=1e-5)
    assert simulation.state.bodies[0].position[2] == pytest.approx(6.0 - length, abs=1e-6)
    if kind == "line":
        assert not records[10].joints[0].force.any()
        assert records[-1].energies["stop"] == pytest.approx(mass * G * 0.2, rel=0.02)


def test_driven_through_a_ball_joint_and_with_redundant_rows():
    """A held plane of motion makes rows of a hinge redundant: forces are finite and along the plane."""
    flat = {"held": ("y", "rx", "rz")}
    bodies = [arm("upper", 0.6, 0.3, **flat), arm("lower", 0.4, 0.8, **flat)]
    joints = [Joint("pin", "hinge", ("upper",), (-0.3, 0.0, CENTRE), axis=(0.0, 1.0, 0.0)),
              Joint("knee", "ball", ("lower", "upper"), (-0.2, 0.0, CENTRE))]
    simulation = build(joined(bodies, joints, 20, 0.01))
    records = list(simulation.steps())
    assert np.isfinite(records[-1].joints[1].force).all() and records[-1].joints[0].force[1] == 0.0
    free = build(double_pendulum(20, 0.01))
    list(free.steps())
    np.testing.assert_allclose(simulation.state.bodies[1].position, free.state.bodies[1].position, atol=1e-6)


def test_a_driven_crank_moves_a_rod():
    """Two bars on a hinge, the first turned by a table: its hinge to the ground needs no guide for translations."""
    scene = double_pendulum(1, 0.01)
    turn = Motion(body="upper", component="ry", displacement=((0.0, 0.0), (0.2, 30.0)))
    simulation = build(replace(scene, stages=(Stage("turn", 20, motions=(turn,)),)))
    list(simulation.steps())
    upper = simulation.state.bodies[0]
    np.testing.assert_allclose(upper.rotation, exp_so3([0.0, np.pi / 6, 0.0]), atol=1e-10)
    np.testing.assert_allclose(upper.position - upper.rotation @ (0.3, 0.0, 0.0), (0.0, 0.0, 5.0), atol=1e-6)


def test_the_drive_pays_for_what_follows_on_a_joint():
    """Two bars in line on a rod, the first set in motion at once: the drive does the work of the impulse on both."""
    bodies = [arm("front", 0.6, 0.0), arm("rear", 0.4, -1.0)]
    rod = Joint("rod", "rod", ("front", "rear"), (-0.3, 0.0, CENTRE), end=(0.2, 0.0, CENTRE))
    scene, go = joined(bodies, [rod], 10, 0.01, gravity=(0.0, 0.0, 0.0)), Motion(body="front", component="x", velocity=0.5)
    simulation = build(replace(scene, stages=(Stage("go", 10, motions=(go,)),)))
    *_, last = simulation.steps()
    energy = 0.5 * (bar(0.6)[0] + bar(0.4)[0]) * 0.5**2
    assert last.energies["kinetic"] == pytest.approx(energy, rel=1e-6) == last.energies["drive"]
    assert abs(last.energies["error"]) < 1e-6 * energy


def test_increments_by_accuracy_pass_an_impact():
    scene = pendulum(30, 0.02, limits=(-10.0, 60.0))
    scene = replace(scene, time=replace(scene.time, accuracy=1e-3))
    records = list(build(scene).steps())
    assert records[-1].joints[0].angle == pytest.approx(60.0, abs=1e-4)
    mass, _ = bar(LENGTHS[0])
    assert records[-1].energies["stop"] == pytest.approx(mass * G * 0.3 * np.sin(np.pi / 3), rel=0.01)


def test_without_inertia_a_load_goes_through_joints_into_the_soil():
    """A plate over all of the elastic soil, and a post on it: welded, or on a hinge that a stop keeps upright."""
    side = Axis(start=-0.4, end=0.4, size=0.2)
    turns = ("x", "y", "rx", "rz")
    bodies = [box(1.06, 1.06, 0.1, name="plate", rest_on=0.0, held=turns),
              box(0.1, 0.1, 0.4, name="post", position=(0.0, 0.0, 0.3), held=("y", "rx", "rz"))]
    push = Load(body="post", point=(0.0, 0.0, 0.2), force=((0.0, 0.0, 0.0, 0.0), (1.0, 50.0, 0.0, -2000.0)))
    for joint in (Joint("foot", "weld", ("post", "plate"), (0.0, 0.0, -0.2)),
                  Joint("foot", "hinge", ("post", "plate"), (0.0, 0.0, -0.2), axis=(0.0, 1.0, 0.0), limits=(-5.0, 0.0))):
        scene = soil_box("post", Grid(side, side, Axis(start=-0.4, end=0.2, size=0.2), Faces()), elastic(1e6, 0.25), bodies,
                         0.5, [Stage("press", 2, loads=(push,))], soil={"top": 0.0}, time={"inertia": False}, solver=TIGHT)
        records = list(build(replace(scene, joints=(joint,))).steps())
        assert records[-1].bodies[0].contact_force[2] == pytest.approx(2000.0, rel=1e-6)
        np.testing.assert_allclose(records[-1].joints[0].force[[0, 2]], [-50.0, 2000.0], rtol=1e-6)
        assert records[-1].joints[0].force[4] == pytest.approx(-50.0 * 0.4, rel=0.02)


# ------------------------------------------------------------------ tangent, checkpoint, refusals


def test_tangent_of_joined_bodies_by_differences():
    simulation = build(double_pendulum(4, 0.01))
    list(simulation.steps())
    workspace = Workspace(simulation.model)
    step = begin(simulation.model, simulation.state, 0.01, False, workspace)
    guess = step.predictor()
    guess = Unknowns(guess.displacement, guess.poses, guess.multipliers + np.linspace(-30.0, 40.0, len(guess.multipliers)))
    evaluation = step.evaluate(guess)
    step.assemble(evaluation)
    assert isinstance(step.system, BlockSystem)
    m, h = len(evaluation.body), 1e-7
    fd = np.array([(step.evaluate(step.moved(guess, np.zeros(0), h * e)).body
                    - step.evaluate(step.moved(guess, np.zeros(0), -h * e)).body) / (2 * h) for e in np.eye(m)]).T
    np.testing.assert_allclose(step.system.ww, fd, atol=1e-5 * np.abs(fd).max())
    workspace.destroy()


def test_a_resumed_run_of_joined_bodies_equals_the_run_in_one_go(tmp_path):
    scene = pendulum(80, 0.01, limits=(-10.0, 60.0))
    whole = build(scene)
    for record in whole.steps():
        if record.step == 30:
            save(tmp_path / "checkpoint.npz", whole.state, whole.scene)
    again = build(scene)
    again.resume(load(tmp_path / "checkpoint.npz", again.scene))
    list(again.steps())
    for one, other in zip(whole.state.bodies, again.state.bodies):
        np.testing.assert_array_equal(one.position, other.position)
        np.testing.assert_array_equal(one.spin, other.spin)
    np.testing.assert_array_equal(whole.state.joints.multipliers, again.state.joints.multipliers)


@pytest.mark.parametrize("changes, match", [
    ({"kind": "ball"}, "axis = given: must be left out"), ({"axis": None}, "axis = left out: must be given"),
    ({"bodies": ("ship",)}, "names of bodies: upper"), ({"bodies": ()}, "one name, or two"),
    ({"limits": (10.0, 60.0)}, "0, the angle at the start, between them"), ({"name": "upper"}, "names of bodies"),
    ({"name": "upper_contact"}, "columns of history.csv"), ({"name": "upper_on_upper"}, "columns of history.csv"),
    ({"length": 2.0}, "left out with kind = 'hinge'"), ({"point": "eye"}, "joint.0.point = 'eye' is not a physical point"),
])
def test_contradictions_are_refused(changes, match):
    scene = pendulum(1, 0.01)
    with pytest.raises(SceneError, match=match):
        build(replace(scene, joints=(replace(scene.joints[0], **changes),)))


def test_schemes_without_damping_and_velocities_against_a_joint_are_refused():
    scene = pendulum(1, 0.01)
    with pytest.raises(SceneError, match="damps in a scene with joints"):
        validate(replace(scene, time=replace(scene.time, scheme="energy-momentum")))
    with pytest.raises(SceneError, match="velocities that it does not allow"):
        build(replace(scene, bodies=(replace(scene.bodies[0], velocity=(1.0, 0.0, 0.0)),)))


def test_without_inertia_a_body_welded_to_a_driven_one_follows_it():
    """Velocities at the start, of which the follower can have none, mean nothing then."""
    bodies = [arm("driver", 0.6, 0.0, driven=("x",), velocity=(0.1, 0.0, 0.0), held=("y", "z", "rx", "ry", "rz")),
              arm("follower", 0.4, 0.5)]
    weld = Joint("weld", "weld", ("follower", "driver"), (-0.2, 0.0, CENTRE))
    simulation = build(joined(bodies, [weld], 2, 1.0, gravity=(0.0, 0.0, 0.0), time={"inertia": False}))
    list(simulation.steps())
    np.testing.assert_allclose(simulation.state.bodies[1].position, (0.7, 0.0, 5.0), atol=1e-9)


def test_a_meshed_cylinder_spins_about_a_hinge_on_its_axis():
    """Its centre of mass is half a micrometre off the axis, which no choice of velocities cures."""
    wheel = Body(name="upper", geometry=GEOMETRY / "cylinder.geo", parameters={"radius": 0.3, "height": 0.2, "size": 0.08},
                 density=1000.0, position=(0.0, 0.0, 1.0), spin=(0.0, 0.0, 6.0))
    hinge = Joint(name="pin", kind="hinge", bodies=("upper",), point=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0))
    simulation = build(joined([wheel], [hinge], 1, 0.01))
    assert simulation.state.bodies[0].spin[2] == pytest.approx(6.0, rel=1e-4)
