"""Every scheme in coupled runs: a spinning box lands on soil; stages, checkpoints, turns that are too long."""

from dataclasses import replace

import numpy as np
import pytest

import hybrid
from hybrid.body.attitude import exp_so3
from hybrid.output import checkpoint
from hybrid.runtime.errors import StepError
from hybrid.scene import Axis, Body, Faces, Grid, Material, Output, Scene, Soil, Solver, Stage, Time
from hybrid.setup.build import build
from hybrid.soil import transfer
from hybrid.step import newton, rejection
from hybrid.step.energy import balance_error, energies
from hybrid.step.equations import begin
from hybrid.step.rejection import rotation_too_large
from hybrid.step.workspace import Workspace
from hybrid.study import scenes

DT = 0.002
SCHEMES = {**scenes.SCHEMES, "alpha 0": {"scheme": "generalised-alpha", "spectral_radius": 0.0}}


def landing(geometry, stages=(Stage("fall", 12),), **time):
    """A box that spins about no principal axis flies into a free block of elastic soil."""
    side = Axis(start=-0.6, end=0.6, size=0.2)
    return Scene(
        name="landing", grid=Grid(side, side, Axis(start=-0.8, end=0.8, size=0.2), Faces(*["free"] * 6)),
        soil=Soil(Material(law="hencky", young=1e6, poisson=0.3, density=1800.0), lower=(-0.4, -0.4, -0.4),
                  upper=(0.4, 0.4, 0.2), geostatic=False),
        bodies=(Body(geometry=geometry / "box.geo", density=3000.0, position=(0.03, -0.02, 0.335),
                     parameters={"length": 0.4, "width": 0.3, "height": 0.2, "size": 0.2},
                     velocity=(0.3, 0.1, -2.0), spin=(2.0, -3.0, 1.0), friction=0.3),),
        gravity=(0.0, 0.0, 0.0), time=Time(step=DT, **time), stages=stages,
        solver=Solver(linear="direct", tolerance=1e-8), output=Output(every=0, checkpoint=2))


def momentum(simulation):
    points, body = simulation.state.points, simulation.state.bodies[0]
    return simulation.model.soil.constants.mass @ points.velocity + simulation.masses[0].mass * body.velocity


@pytest.mark.parametrize("name", SCHEMES)
def test_a_body_lands_on_soil(geometry, name):
    """Linear momentum is kept; energy is lost to friction, transfer and damping, and never gained."""
    simulation = build(landing(geometry, **SCHEMES[name]))
    before, start, contacts = momentum(simulation), energies(simulation.model, simulation.state), 0
    for record in simulation.steps():
        assert record.rejections == 0
        contacts = max(contacts, record.contacts)
        assert balance_error(record.energies, start) < 0.02 * start["kinetic"]
    assert contacts >= 8 and simulation.state.bodies[0].velocity[2] > -1.5
    assert np.linalg.norm(momentum(simulation) - before) < 1e-6 * np.linalg.norm(before)
    auxiliary = simulation.model.scheme.auxiliary
    assert auxiliary == (simulation.state.points.algorithmic is not None)
    assert auxiliary == (simulation.state.bodies[0].algorithmic is not None)


def test_schemes_of_second_order_land_alike(geometry):
    ends = {name: build(landing(geometry, (Stage("fall", 10),), **SCHEMES[name]))
            for name in ("newmark", "alpha", "energy-momentum")}
    for simulation in ends.values():
        list(simulation.steps())
    rotation, fallen = ({name: of(s.state.bodies[0]) for name, s in ends.items()}
                        for of in (lambda b: b.rotation, lambda b: b.position))
    for name in ("alpha", "energy-momentum"):
        assert np.abs(rotation[name] - rotation["newmark"]).max() < 2e-3
        assert np.abs(fallen[name] - fallen["newmark"]).max() < 2e-4


def test_a_flying_body_of_a_scene_keeps_its_angular_momentum(geometry):
    """From the first step on: it is built with the spin rate of free rotation."""
    described = landing(geometry, (Stage("fly", 20),), scheme="energy-momentum")
    body = replace(described.bodies[0], position=(0.0, 0.0, 0.45), velocity=(0.0, 0.0, 0.0))
    simulation = build(replace(described, bodies=(body,), solver=Solver(linear="direct", tolerance=1e-12)))
    inertia = simulation.masses[0].inertia
    kept = []
    for _ in simulation.steps():
        motion = simulation.state.bodies[0]
        kept.append(np.append(motion.rotation @ inertia @ motion.spin, motion.spin @ inertia @ motion.spin))
    first = simulation.initial_bodies[0].spin
    np.testing.assert_allclose(kept, [np.append(inertia @ first, first @ inertia @ first)] * 20, rtol=1e-10)
    assert np.linalg.norm(simulation.initial_bodies[0].spin_rate) > 1.0


def test_newmark_projects_no_more_than_before(geometry, monkeypatch):
    fields, project = [], transfer.points_to_grid
    runs = [build(landing(geometry, (Stage("fall", 2),), **options))
            for options in (SCHEMES["newmark"], SCHEMES["alpha"])]
    monkeypatch.setattr(transfer, "points_to_grid",
                        lambda *given, **more: fields.append(len(given) - 5) or project(*given, **more))
    for run in runs:
        list(run.steps())
    assert fields == [2, 2, 2, 3]      # the first step of generalised alpha has no algorithmic acceleration yet


def test_a_stage_of_newmark_drops_the_algorithmic_acceleration(geometry):
    stages = (Stage("a", 2), Stage("settle", 2, beta=0.5625, gamma=1.0), Stage("b", 2))
    simulation = build(landing(geometry, stages, scheme="generalised-alpha"))
    carried = []
    for record in simulation.steps():
        assert record.rejections == 0
        state = simulation.state
        carried.append((state.points.algorithmic is not None, state.bodies[0].algorithmic is not None))
    assert carried == [(True, True)] * 2 + [(False, False)] * 2 + [(True, True)] * 2
    assert simulation.sheet()["modelled"]["time integration"] == (
        "generalised-alpha, spectral radius 0, of bodies in flight 0.5; settle: Newmark, beta = 0.5625, gamma = 1")


def test_a_resumed_run_has_its_algorithmic_acceleration(geometry, tmp_path):
    def fall(steps):
        return landing(geometry, (Stage("fall", steps),), scheme="generalised-alpha")

    whole = hybrid.run(fall(6), tmp_path / "whole", quiet=True)
    for steps in (3, 6):
        described = fall(steps)
        resumed = hybrid.run(described, tmp_path / "parts", resume=steps == 6, quiet=True)
    back = checkpoint.load(tmp_path / "parts/checkpoint.npz", resumed.scene)
    for end in (resumed.state, back):
        for found, wanted in ((end.points, whole.state.points), (end.bodies[0], whole.state.bodies[0])):
            for field in ("position", "velocity", "acceleration", "algorithmic"):
                np.testing.assert_allclose(
                    getattr(found, field), getattr(wanted, field), rtol=0, atol=1e-9, err_msg=field)


@pytest.mark.parametrize("name", ["newmark", "alpha", "energy-momentum"])
def test_committed_and_trial_rates_are_never_the_same(geometry, name):
    simulation = build(landing(geometry, **SCHEMES[name]))
    state, workspace = simulation.state, Workspace(simulation.model)
    for _ in range(2):
        step = begin(simulation.model, state, DT, False, workspace)
        outcome = newton.solve(step)
        new = step.accept(outcome.evaluation)
        for old, now in ((state.points, new.points), (state.bodies[0], new.bodies[0])):
            for one in filter(lambda v: isinstance(v, np.ndarray), vars(old).values()):
                for other in filter(lambda v: isinstance(v, np.ndarray), vars(now).values()):
                    assert not np.shares_memory(one, other)
        state = new


@pytest.mark.parametrize("name, missed", [("newmark", 0.006), ("dissipative", 0.12), ("alpha", 0.006),
                                          ("energy-momentum", 0.006)])
def test_a_sphere_rolls_on_faces(name, missed):
    """With friction, on a held plane that gravity leans by g_x: way v t + 5/14 g_x t².

    Way: -0.4 % of it, -0.7 % when dissipative. Energy that the balance misses, of the kinetic: 0.42 % from points that
    meet the body within a step; dissipative Newmark damps the bouncing, -8.2 %. The soft springs let the sphere sink by
    δ = 20 mm (k π r δ² = m g). Points at depths from 0 to δ move at speeds that differ by δ/r of the sphere's, so some
    slip, all of them by that share at most: below μ m g δ/r of the way, measured 1.2 to 1.5 J of 4.6 J."""
    ball = scenes.sphere(0.25, 0.08, growth=0.0, position=(-0.3, 0.0125, 0.0), rest_on=0.0, velocity=(1.0, 0.0, 0.0),
                         spin=(0.0, 4.0, 0.0), friction=0.4, penalty=1.0, tangential=2.0)
    simulation = build(scenes.plane(
        ball, 20, 0.01, cells=(8, 4), stiffness=2e6, gravity=(1.0, 0.0, -9.81), time=scenes.SCHEMES[name]))
    for record in simulation.steps():
        (contact,) = simulation.evaluation.contacts
        assert len(contact) > 0 and record.rejections == 0 and record.iterations <= 3
    way = simulation.state.bodies[0].position[0] - simulation.initial_bodies[0].position[0]
    assert way == pytest.approx(0.2 + 5 / 14 * 0.2**2, rel=0.012)
    assert abs(record.energies["error"]) < missed * record.energies["kinetic"]
    weight = 9.81 * simulation.masses[0].mass
    sunk = np.sqrt(weight / (2e6 * np.pi * 0.25))
    assert 0 < record.energies["friction"] < 0.4 * weight * sunk / 0.25 * way


# ------------------------------------------------------------------ turns that are too long


def spinning(geometry, spin, smallest=None, **time):
    """A sphere that spins over held soil and touches nothing, one step of 0.04 s."""
    side = Axis(start=-0.4, end=0.4, size=0.4)
    return build(Scene(
        name="spinning", grid=Grid(side, side, Axis(start=-1.4, end=-1.0, size=0.4)),
        soil=Soil(Material(law="hencky", young=1e6, poisson=0.3, density=1800.0), held=True),
        bodies=(Body(geometry=geometry / "sphere.geo", density=3000.0, parameters={"radius": 0.2, "size": 0.12},
                     spin=(0.0, spin, 0.0)),),
        gravity=(0.0, 0.0, 0.0), time=Time(step=0.04, smallest=smallest, **time), stages=(Stage("spin", 1),)))


@pytest.mark.parametrize("options", SCHEMES.values(), ids=SCHEMES)
def test_a_step_that_turns_a_body_too_far_is_halved(geometry, options):
    """90 rad/s in 0.04 s is 3.6 rad, more than half a turn."""
    simulation = spinning(geometry, 90.0, **options)
    (record,) = simulation.steps()
    assert (record.rejections, record.increments) == (1, 2)
    motion = simulation.state.bodies[0]
    assert motion.spin[1] == pytest.approx(90.0, rel=1e-2)
    (record,) = spinning(geometry, 45.0, **options).steps()
    assert record.rejections == 0


def test_the_rotation_is_reported_when_the_step_may_not_be_halved(geometry):
    reason = r"body rotates by 3.6 rad in 0.04 s, limit 2 rad; .*time.smallest.*smaller time.step"
    with pytest.raises(StepError, match=reason):
        list(spinning(geometry, 90.0, smallest=0.04).steps())


def test_without_the_limit_the_failure_does_not_name_the_cause(geometry, monkeypatch):
    """No logarithm is as long as the turn, so Newton's method has no solution to find."""
    monkeypatch.setattr(rejection, "LARGEST_ROTATION", np.inf)
    with pytest.raises(StepError, match=r"residual .* after \d+ iterations"):
        list(spinning(geometry, 90.0, smallest=0.04).steps())


def test_a_converged_step_is_checked_too(geometry):
    """The first guess may be short and the solution long; without inertia only the turn found counts."""
    for inertia in (True, False):
        simulation = spinning(geometry, 0.0, inertia=inertia)
        step = begin(simulation.model, simulation.state, 0.04, False, Workspace(simulation.model))
        guess = step.predictor()
        assert rotation_too_large(step) == "" == rotation_too_large(step, guess)
        poses = [(position, exp_so3([0.0, angle, 0.0]) @ rotation)
                 for position, rotation in guess.poses for angle in (0.9, 2.1)]
        short, long = (rotation_too_large(step, replace(guess, poses=(pose,))) for pose in poses)
        assert short == "" and "body rotates by" in long
