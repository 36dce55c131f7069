"""Driven components: guides keep a body's rates, whatever it takes, and the balance of energy knows what it took."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from hybrid.scene import Axis, Faces, Grid, Pull, Stage
from hybrid.setup.build import build
from hybrid.study.scenes import SCHEMES, box, elastic, plane, scene

STEP, STEPS = 0.01, 12
every_scheme = pytest.mark.parametrize("options", SCHEMES.values(), ids=SCHEMES)


def flying(options, gravity, stages=None, **body):
    """A box high above held soil; (simulation, records of its steps, states of the box after them)."""
    described = plane(box(0.5, 0.4, 0.2, position=(0.0, 0.0, 2.0), **body), STEPS, STEP, gravity=gravity, time=options)
    simulation, motions = build(replace(described, stages=stages or described.stages)), []
    records = [motions.append(simulation.state.bodies[0]) or record for record in simulation.steps()]
    return simulation, records, motions


def errors(simulation, records):
    """Energy that the balance misses after each step, relative to the largest term in it."""
    scale = max(abs(value) for record in records for value in record.energies.values())
    return np.array([record.energies["error"] for record in records]) / scale


@every_scheme
def test_a_lowered_body_hangs_on_its_guides(options):
    """Reaction -m g, work of the drive -m g·v t: what gravity does."""
    velocity, gravity = np.array([0.3, -0.2, -0.5]), np.array([0.0, 0.0, -9.81])
    simulation, records, motions = flying(
        options, tuple(gravity), velocity=tuple(velocity), driven=("x", "y", "z"), held=("rx", "ry", "rz"))
    weight = simulation.masses[0].mass * gravity
    for record, motion in zip(records, motions):
        np.testing.assert_allclose(motion.reaction, [*-weight, 0, 0, 0], atol=1e-9 * np.linalg.norm(weight))
        assert record.energies["drive"] == pytest.approx(-weight @ velocity * record.time, rel=1e-9)
    np.testing.assert_allclose(motions[-1].position - (0.0, 0.0, 2.0), velocity * STEPS * STEP, rtol=0, atol=1e-13)
    assert np.abs(errors(simulation, records)).max() < 1e-12


@every_scheme
def test_a_body_driven_along_a_slope_turns_and_falls(options):
    """x and ry driven, z free: x = v t, spin kept, fall ½ g_z t²; reaction -m g_x, no moment about a principal axis."""
    gravity, velocity, spin = np.array([4.0, 0.0, -7.0]), 0.7, 3.0
    simulation, records, motions = flying(
        options, tuple(gravity), velocity=(velocity, 0.0, 0.0), spin=(0.0, spin, 0.0), driven=("x", "ry"))
    mass, end = simulation.masses[0].mass, STEPS * STEP
    for record, motion in zip(records, motions):
        np.testing.assert_allclose(motion.reaction, [-mass * gravity[0], 0, 0, 0, 0, 0], atol=1e-8 * mass)
        assert record.energies["drive"] == pytest.approx(-mass * gravity[0] * velocity * record.time, rel=1e-9)
        np.testing.assert_allclose(motion.spin, [0.0, spin, 0.0], atol=1e-12)
    fallen = [velocity * end, 0.0, 2.0 + 0.5 * gravity[2] * end**2]
    np.testing.assert_allclose(motions[-1].position, fallen, rtol=0, atol=1e-12)
    assert np.abs(errors(simulation, records)).max() < 1e-12


@every_scheme
def test_a_body_driven_about_no_principal_axis(options):
    """Moment of the guides ω × R J R^T ω, which does no work."""
    spin = np.array([2.0, -3.0, 4.0])
    simulation, records, motions = flying(options, (0.0, 0.0, 0.0), spin=tuple(spin), driven=("rx", "ry", "rz"))
    for record, motion in zip(records, motions):
        inertia = motion.rotation @ simulation.masses[0].inertia @ motion.rotation.T
        moment = np.cross(spin, inertia @ spin)
        np.testing.assert_allclose(motion.reaction[3:], moment, atol=1e-9 * np.linalg.norm(moment))
        np.testing.assert_allclose(motion.rotation @ motion.spin, spin, rtol=1e-12)
    assert np.abs(errors(simulation, records)).max() < 1e-12


@every_scheme
def test_a_stage_that_holds_overrides_the_drive(options):
    """Held, a lowered body stands, its guides carry m g and do no work but that of the jolts, -½ m v² and ½ m v²."""
    speed, gravity = 0.5, 9.81
    stages = Stage("lower", 4), Stage("hold", 4, held=("z",)), Stage("on", 4)
    simulation, records, motions = flying(
        options, (0.0, 0.0, -gravity), stages, velocity=(0.0, 0.0, -speed), driven=("z",))
    mass = simulation.masses[0].mass
    lowered = np.clip(np.arange(1, 13), 0, 4) + np.clip(np.arange(1, 13) - 8, 0, None)
    moving = np.array([4 * [1] + 4 * [0] + 4 * [1]]).ravel()
    drive = -mass * gravity * speed * STEP * lowered + (moving - 1) * 0.5 * mass * speed**2
    np.testing.assert_allclose([m.position[2] for m in motions], 2.0 - speed * STEP * lowered, rtol=0, atol=1e-13)
    np.testing.assert_allclose([m.velocity[2] for m in motions], -speed * moving, atol=1e-15)
    np.testing.assert_allclose([m.reaction[2] for m in motions], mass * gravity, rtol=1e-9)
    np.testing.assert_allclose([r.energies["drive"] for r in records], drive, rtol=1e-9)
    assert np.abs(errors(simulation, records)).max() < 1e-12


@every_scheme
def test_a_body_stopped_in_flight_starts_again_from_rest(options):
    """A stage that holds a thrown and turning body leaves no rate and no acceleration of any kind behind."""
    stages = Stage("fly", 4), Stage("hold", 1, held=("x", "y", "z", "rx", "ry", "rz"))
    simulation, records, motions = flying(
        options, (0.0, 0.0, -9.81), stages, velocity=(1.0, 0.0, 2.0), spin=(2.0, -3.0, 4.0))
    held = motions[-1]
    for rates in (held.velocity, held.spin, held.acceleration, held.spin_rate, held.algorithmic):
        assert rates is None or not rates.any()
    weight = 9.81 * simulation.masses[0].mass
    np.testing.assert_allclose(held.reaction, [0, 0, weight, 0, 0, 0], atol=1e-9 * weight)
    assert abs(records[-1].energies["error"] - records[-2].energies["error"]) < 1e-12 * weight


@every_scheme
@pytest.mark.parametrize("held", [("x", "z"), ("x", "y", "z", "rx", "ry", "rz")])
def test_what_guides_held_back_accelerates_when_they_let_go(options, held):
    """A body held for a step on a slope then falls ½ g t², to round-off from the first step."""
    gravity = np.array([4.0, 0.0, -7.0])
    stages = Stage("hold", 1, held=held), Stage("fly", 3)
    _, _, motions = flying(options, tuple(gravity), stages)
    for n, motion in enumerate(motions[1:], 1):
        np.testing.assert_allclose(motion.position - motions[0].position, 0.5 * gravity * (n * STEP)**2, atol=1e-13)


@every_scheme
def test_a_moment_that_guides_held_back_turns_the_body_when_they_let_go(options):
    """Pulled by a stretched line beside its centre, W ≈ J⁻¹ (r × F) t, half of it after a step from no acceleration."""
    pull = Pull(point=(0.0, 0.1, 0.0), velocity=(1.0, 0.0, 0.0), stiffness=1e4, length=10.0, tension_only=False)
    stages = Stage("hold", 1, held=("x", "y", "z", "rx", "ry", "rz")), Stage("fly", 1, step=1e-4)
    simulation, records, motions = flying(options, (0.0, 0.0, 0.0), stages, pull=pull)
    moment = np.cross([0.0, 0.1, 0.0], [records[0].bodies[0].line_tension, 0.0, 0.0])
    expected = np.linalg.solve(simulation.model.bodies[0].mass.inertia, moment) * 1e-4
    np.testing.assert_allclose(motions[1].spin, expected, atol=0.02 * np.linalg.norm(expected))


@every_scheme
def test_gravity_that_begins_with_a_stage_acts_from_its_start(options):
    stages = Stage("float", 2, gravity=(0.0, 0.0)), Stage("fall", 3)
    _, _, motions = flying(options, (0.0, 0.0, -9.81), stages)
    assert motions[-1].position[2] - motions[0].position[2] == pytest.approx(-0.5 * 9.81 * (3 * STEP)**2, rel=1e-9)


# ------------------------------------------------------------------ a plate pressed into elastic soil

YOUNG, POISSON, PENALTY, DEPTH, HEIGHT, AREA = 1e6, 0.25, 50.0, 0.02, 0.4, 0.64


def pressed(steps, width, contact="faces"):
    """Last record of a frictionless plate that is driven DEPTH into a block on rollers of HEIGHT and AREA."""
    side = Axis(start=-0.4, end=0.4, size=0.2)
    plate = box(width, width, 0.1, size=0.2, rest_on=0.0, velocity=(0.0, 0.0, -DEPTH), driven=("z",),
                held=("x", "y", "rx", "ry", "rz"), penalty=PENALTY, contact=contact)
    described = scene(
        "plate", Grid(side, side, Axis(start=-HEIGHT, end=0.2, size=0.2), Faces()), elastic(YOUNG, POISSON), [plate],
        1.0 / steps, [Stage("press", steps)], soil={"top": 0.0}, time={"inertia": False},
        solver={"linear": "direct", "tolerance": 1e-10})
    return list(build(described).steps())[-1]


def rates(missed):
    return np.log2(np.abs(missed[:-1] / missed[1:]))


def test_soil_and_springs_in_series_store_what_a_plate_over_all_of_it_is_pressed_with():
    """p_f E g = -M ln λ / λ with λ = 1 - (d - g)/H: elastic ½ M (ln λ)² A H, contact ½ p_f E g² A, kinetic none."""
    modulus = YOUNG * (1 - POISSON) / ((1 + POISSON) * (1 - 2 * POISSON))

    def stretch(gap):
        return 1 - (DEPTH - gap) / HEIGHT

    gap = brentq(lambda g: PENALTY * YOUNG * g + modulus * np.log(stretch(g)) / stretch(g), 0.0, DEPTH, xtol=1e-16)
    found = pressed(4, 1.06).energies
    elastic_energy = 0.5 * modulus * np.log(stretch(gap)) ** 2 * AREA * HEIGHT
    assert found["elastic"] == pytest.approx(elastic_energy, rel=1e-7)
    assert found["contact"] == pytest.approx(0.5 * PENALTY * YOUNG * gap**2 * AREA, rel=1e-7)
    assert found["kinetic"] == 0.0
    assert found["drive"] == pytest.approx(found["elastic"] + found["contact"], rel=2e-3)


@pytest.mark.parametrize("contact", ["faces", "corners"])
def test_work_on_a_plate_over_all_of_the_soil_is_of_second_order(contact):
    """Trapezoidal rule of a smooth force: missed 1.4e-3 of the work in 4 steps, 2.2e-5 in 32, rates 2.00."""
    energies = [pressed(steps, 1.06, contact).energies for steps in (4, 8, 16)]
    missed = np.array([e["error"] / e["drive"] for e in energies])
    assert rates(missed) == pytest.approx(2.0, abs=0.005)
    assert abs(missed[-1]) < 1e-4


def test_work_on_a_plate_over_a_part_of_the_soil_is_of_first_order():
    """On corners, of which the plate's edge passes none.

    The basis is renewed each step: missed 1.1e-3 in 4 steps, 4.8e-5 in 64, rates 1.28, 1.16, 1.09, 1.05."""
    energies = [pressed(steps, 0.33, "corners").energies for steps in (4, 8, 16, 32)]
    missed = np.array([e["error"] / e["drive"] for e in energies])
    assert ((rates(missed) > 1.0) & (rates(missed) < 1.4)).all()
    assert abs(missed[-1]) < 1.5e-4
