"""Hinges with stops and with friction."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from hybrid.body import stage_start
from hybrid.scene import Joint, Load, Motion, Stage
from hybrid.setup.build import build
from hybrid.step import joint_rates
from tests.helpers.joined import CENTRE, G, LENGTHS, arm, bar, joined, pendulum


def test_a_pendulum_stops_at_its_limit_without_rebound():
    """It falls by 60 degrees, loses all its energy at the stop, and rests there on the moment m g l cos 60."""
    simulation = build(pendulum(120, 0.005, limits=(-10.0, 60.0)))
    records = list(simulation.steps())
    mass, _ = bar(LENGTHS[0])
    angle = np.array([record.joints[0].angle for record in records])
    fallen = mass * G * 0.3 * np.sin(np.pi / 3)
    stopped = np.argmax(angle > 59.999)
    assert records[-1].energies["stop"] == pytest.approx(fallen, rel=0.01)
    np.testing.assert_allclose(angle[stopped:], 60.0, atol=1e-5)
    assert angle.max() < 60.0 + 1e-5
    np.testing.assert_allclose(simulation.state.bodies[0].spin, 0.0, atol=1e-6)
    moment = records[-1].joints[0].force[4]
    assert moment == pytest.approx(-mass * G * 0.3 * np.cos(np.pi / 3), rel=1e-5)
    inertia = mass * (0.6**2 + 0.08**2) / 12 + mass * 0.3**2

    def swing(t, y):
        return [y[1], mass * G * 0.3 * np.cos(y[0]) / inertia]

    def reach(t, y):
        return y[0] - np.pi / 3

    reach.terminal = True
    time = solve_ivp(swing, (0.0, 2.0), [0.0, 0.0], events=reach, rtol=1e-10).t[-1]
    assert records[stopped].time == pytest.approx(time, abs=0.01)
    assert sum(record.rejections for record in records) == 0


@pytest.mark.parametrize("count, lost", [(44, 0.01), (22, 0.08)])
def test_a_pendulum_keeps_its_height(count, lost):
    """Share of its fall that a bar let go from the horizontal does not regain in a period, with nothing set; with what damps
    contact in its flight as well, much of it."""
    period = 4.0 * ellipk(0.5) * np.sqrt((0.6**2 + 0.08**2 + 12.0 * 0.3**2) / 12.0 / (G * 0.3))
    scene, found, notes = pendulum(count, period / count), {}, {}
    for name, radius in (("nothing set", None), ("damped", 0.0)):
        simulation = build(replace(scene, time=replace(scene.time, spectral_radius=radius)))
        height = np.array([record.bodies[0].position[2] for record in simulation.steps()])
        found[name], notes[name] = (5.0 - height[-4:].max()) / (5.0 - height.min()), " ".join(simulation.notes)
    assert 0.0 <= found["nothing set"] < lost
    assert found["damped"] > 0.1 and "time integration has taken" in notes["damped"]
    assert count == 22 or "has taken" not in notes["nothing set"]


@pytest.mark.parametrize("count", [20, 25])
def test_a_pendulum_whose_first_step_is_long_finds_an_increment_short_enough_for_its_accuracy(count):
    """Its velocity after that step is off along the hinge: to undo that in a short increment, it took an acceleration so
    large that no increment met the accuracy."""
    scene = pendulum(count, 1.6 / count)
    records = list(build(replace(scene, time=replace(scene.time, accuracy=1e-3))).steps())
    assert len(records) == count and sum(record.increments for record in records) < 250
    assert abs(records[-1].energies["error"]) < 0.01 * max(record.energies["kinetic"] for record in records)


def test_a_carriage_that_a_point_guides_loses_nothing_where_increments_are_shortened():
    """A bar hangs on it, whose increments follow from an accuracy."""
    scene = joined([arm("carriage", 0.4, 0.0), arm("bar", 0.6, 0.3)],
                   [Joint("pin", "hinge", ("carriage", "bar"), (0.0, 0.0, CENTRE), axis=(0.0, 1.0, 0.0))], 20, 0.05)
    guides = (Motion(body="carriage", held=("rx", "ry", "rz")),
              *(Motion(body="carriage", point=(0.0, 0.0, CENTRE), held=(axis,)) for axis in "yz"),
              Motion(body="carriage", point=(0.0, 0.0, CENTRE), component="x", velocity=0.5))
    scene = replace(scene, time=replace(scene.time, accuracy=1e-3), stages=(Stage("go", 20, motions=guides),))
    records = list(build(scene).steps())
    assert abs(records[-1].energies["error"]) < 0.02 * max(record.energies["kinetic"] for record in records)


def test_a_pendulum_that_swings_away_from_its_stop_is_free_again():
    """Pushed against the stop by a moment, then let go."""
    push = Load(moment=(0.0, -100.0, 0.0))
    scene = replace(pendulum(1, 0.005, limits=(0.0, 170.0)), stages=(Stage("push", 10, loads=(push,)), Stage("fall", 20)))
    simulation = build(scene)
    records = list(simulation.steps())
    angle = np.array([record.joints[0].angle for record in records])
    np.testing.assert_allclose(angle[:10], 0.0, atol=1e-5)
    mass, _ = bar(LENGTHS[0])
    inertia = mass * (0.6**2 + 0.08**2) / 12 + mass * 0.3**2
    assert np.radians(angle[-1]) == pytest.approx(0.5 * mass * G * 0.3 / inertia * 0.1**2, rel=0.1)


def test_friction_of_a_hinge_holds_or_takes_energy():
    mass, _ = bar(LENGTHS[0])
    weight = mass * G * 0.3
    held = list(build(pendulum(20, 0.01, friction_moment=1.1 * weight)).steps())
    assert all(record.iterations < 4 for record in held)
    assert max(abs(record.joints[0].angle) for record in held) < 1e-4
    assert held[-1].joints[0].force[4] == pytest.approx(-weight, rel=1e-3)
    slipped = list(build(pendulum(40, 0.005, friction_moment=0.3 * weight)).steps())
    angle = np.radians(slipped[-1].joints[0].angle)
    assert angle > 0.3
    assert slipped[-1].energies["friction"] == pytest.approx(0.3 * weight * angle, rel=1e-3)
    assert slipped[-1].energies["kinetic"] == pytest.approx(
        weight * np.sin(angle) - 0.3 * weight * angle, rel=0.01)


def rotor(steps, moment, **given):
    """A bar that turns about its middle with friction, without gravity."""
    pin = Joint(name="pin", kind="hinge", bodies=("rotor",), point=(0.0, 0.0, CENTRE), axis=(0.0, 1.0, 0.0),
                friction_moment=moment)
    return joined([arm("rotor", LENGTHS[0], 0.0, **given)], [pin], steps, 0.02, gravity=(0.0, 0.0, 0.0))


def test_friction_of_a_hinge_slows_a_rotor_down_in_every_turn():
    """Also where its angle passes 180 degrees, from which it is counted on from -180."""
    _, inertia = bar(LENGTHS[0])
    records = list(build(rotor(100, 0.5 * inertia, spin=(0.0, 4.0, 0.0))).steps())
    spin = np.array([record.bodies[0].spin[1] for record in records])
    np.testing.assert_allclose(np.diff(spin)[20:], -0.5 * 0.02, rtol=1e-6)
    assert min(np.diff([record.joints[0].angle for record in records])) < -300.0


@pytest.mark.parametrize("rate", [0.5, -0.5])
def test_a_driven_hinge_feels_its_friction(rate):
    turned = rotor(10, 3.0, held=("x", "y", "z", "rx", "rz"), driven=("ry",), spin=(0.0, rate, 0.0))
    last = list(build(turned).steps())[-1]
    assert last.bodies[0].reaction["ry"] == pytest.approx(3.0 * np.sign(rate))
    assert last.energies["friction"] == pytest.approx(3.0 * 0.5 * 0.2)


def test_friction_of_a_hinge_that_guides_hold_bears_nothing():
    still = rotor(2, 3.0, held=("x", "y", "z", "rx", "ry", "rz"))
    assert list(build(still).steps())[-1].joints[0].force[4] == 0.0


@pytest.mark.parametrize("remember", [True, False])
def test_work_of_a_pendulum_that_is_driven_from_the_first_step(monkeypatch, remember):
    """Its reaction before that step is not known: what balances its weight and inertia alone leaves out the hinge, which
    bears the weight and gives the middle its speed."""
    drive = Stage("drive", 10, motions=(Motion(component="ry", velocity=0.5),))
    if not remember:
        engage = stage_start.engage_guides
        monkeypatch.setattr(stage_start, "engage_guides", lambda *given: engage(*given[:4]))
    *_, last = build(replace(pendulum(10, 0.02), stages=(drive,))).steps()
    wrong = abs(last.energies["error"]) > 0.1 * last.energies["kinetic"]
    assert wrong != remember


@pytest.mark.parametrize("share, held_first", [(0.98, False), (0.98, True), (1.02, False)])
def test_friction_of_a_hinge_acts_from_the_start(share, held_first, monkeypatch):
    """An arm let go level against a moment of `share` of its weight's: I φ'' = m g l/2 cos φ - M, or rest. Without friction
    in the accelerations at the start the velocity is wrong by Δt M/2I for good: 43 % of the angle after a second."""
    (mass, inertia), length = bar(LENGTHS[0]), LENGTHS[0]
    moment = 0.5 * mass * G * length
    described = pendulum(50, 0.01, friction_moment=share * moment)
    if held_first:
        hold = Stage("hold", 2, held=("ry",))
        described = replace(described, stages=(hold, *described.stages))
    whole = inertia + mass * (length / 2)**2
    exact = solve_ivp(lambda t, y: (y[1], max(moment * np.cos(y[0]) - share * moment, 0.0) / whole), (0.0, 0.5), (0.0, 0.0),
                      rtol=1e-10, atol=1e-12).y[0, -1]

    def angle():
        simulation = build(described)
        *_, last = simulation.steps()
        return 2.0 * np.arccos(min(1.0, abs(last.bodies[0].quaternion[0])))

    assert angle() == pytest.approx(exact, rel=0.01, abs=1e-9)
    monkeypatch.setattr(joint_rates, "with_friction", lambda model, bodies, joints, active: (bodies, joints))
    if share < 1.0:
        assert angle() > 1.2 * exact
