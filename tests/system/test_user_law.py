"""Laws given from Python: the demo, what is refused at the start, and points that have no stress in a step."""

import shutil
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from demo_scripts import demo

import hybrid
from hybrid.laws.hencky import Hencky
from hybrid.output import checkpoint
from hybrid.runtime.errors import LawError, SceneError, StepError
from hybrid.runtime.ranks import launch
from hybrid.scene import Material
from hybrid.setup.build import build
from hybrid.study.scenes import elastic, soil_scene

DEMO = demo("user_law")


def scene(**material):
    """Three steps of a block of soil that falls onto its rollers."""
    described = soil_scene(gravity=(0.0, 0.0, -9.81), steps=3)
    return replace(described, soil=replace(described.soil, material=Material(**material)))


USER = scene(law="user", density=1800.0)


def test_clay_of_the_demo_has_the_force_of_its_closed_form():
    assert DEMO.check() < 1e-8
    simulation = build(DEMO.oedometer(4), law=DEMO.clay)
    *_, last = simulation.steps()
    points = simulation.state.points
    strain = -np.log(points.deformation[:, 2, 2])
    assert np.ptp(strain) < 1e-8 and points.plastic_strain.min() > 0.03
    assert last.bodies[0].contact_force[2] == pytest.approx(DEMO.closed_form(strain.mean()), rel=1e-5)
    law, sheet = simulation.model.soil.law, simulation.sheet()
    assert law.parameters is None and not (law.hardens or law.undrained)      # whatever it inherits
    assert sheet["modelled"]["soil law"] == "user, HyperbolicClay"
    assert not any("hardening" in text for text in sheet["not modelled"])     # which is not known


def test_a_user_law_equal_to_one_of_the_package_gives_the_same_run():
    own = build(USER, law=lambda points, stress: Hencky(np.full(len(points), 1e6), 0.2))
    theirs = build(scene(density=1800.0, **elastic(1e6, 0.2)))
    for _ in zip(own.steps(), theirs.steps()):
        pass
    np.testing.assert_allclose(own.state.points.position, theirs.state.points.position, rtol=1e-14, atol=1e-15)


def test_the_law_gets_positions_and_initial_stress():
    given = []

    def law(points, stress):
        given.append((points.position.copy(), stress))
        return Hencky(np.full(len(points), 1e6), 0.2)

    described = replace(USER, soil=replace(USER.soil, geostatic=True, k0=0.6))
    points = build(described, law=law).state.points
    (position, stress), = given
    np.testing.assert_array_equal(position, points.position)
    np.testing.assert_allclose(stress[:, 2], 1800 * 9.81 * position[:, 2], rtol=1e-12)
    np.testing.assert_allclose(np.diagonal(points.stress, axis1=1, axis2=2), stress, rtol=1e-12)


@pytest.mark.parametrize("described, law, error, words", [
    (USER, None, SceneError, "belong together"),
    (scene(density=1800.0, **elastic(1e6)), DEMO.clay, SceneError, "but law = 'hencky' and one is given"),
    (USER, lambda points, stress: None, LawError, "NoneType has no young"),
    (USER, lambda points, stress: Hencky(1e6, 0.2), LawError, r"young of a law has shape \(1,\)"),
    (USER, lambda points, stress: Hencky(np.zeros(len(points)), 0.2), LawError, "must be positive"),
])
def test_what_is_refused_at_the_start(described, law, error, words):
    with pytest.raises(error, match=words):
        build(described, law=law)


def test_a_run_takes_a_law_too(tmp_path):
    with pytest.raises(SceneError, match=r"run\(scene, law=...\)"):
        hybrid.run(USER, out=tmp_path, quiet=True)
    simulation = hybrid.run(USER, out=tmp_path, quiet=True,
                            law=lambda points, stress: Hencky(np.full(len(points), 1e6), 0.2))
    assert simulation.state.step == 3


class Brittle(Hencky):
    """Has no stress beyond an elongation or shortening along any axis, at points of odd number."""

    LIMIT = 2e-4

    def respond(self, strain, plastic_strain):
        response = super().respond(strain)
        odd = np.arange(len(strain)) % 2 == 1
        return replace(response, failed=odd & (np.abs(strain).max(axis=1) > self.LIMIT))


def test_points_without_a_stress_reject_the_step_and_are_named():
    """A wrong stress is always reported: the increment is halved, then the run stops and names the points."""
    simulation = build(USER, law=lambda points, stress: Brittle(np.full(len(points), 1e6), 0.2))
    with pytest.raises(StepError, match=r"leaves the soil's law without a stress at points \d+, .* and \d+ more"):
        list(simulation.steps())
    assert np.isfinite(simulation.state.points.stress).all()
    assert np.abs(np.log(np.linalg.eigvalsh(simulation.state.points.b_elastic)) / 2)[1::2].max() <= Brittle.LIMIT


@pytest.mark.parametrize("geostatic, error, words", [
    (True, SceneError, "has no finite response of the law there"),
    (False, StepError, "the state at the start leaves the soil's law without a stress"),
])
def test_a_law_without_a_stress_at_the_start_is_refused(geostatic, error, words):
    class Late(Brittle):
        LIMIT = -1.0 if not geostatic else 1e-6

        def respond(self, strain, plastic_strain):
            return super().respond(strain, plastic_strain) if geostatic or self.called() else Hencky.respond(self, strain)

        def called(self):
            self.calls = getattr(self, "calls", 0) + 1
            return self.calls > 1       # a law without a stress at no strain is refused before

    described = replace(USER, soil=replace(USER.soil, geostatic=geostatic, k0=0.5 if geostatic else None))
    with pytest.raises(error, match=words):
        build(described, law=lambda points, stress: Late(np.full(len(points), 1e6), 0.2))


def test_halving_cures_what_fails_at_long_increments():
    """Two refusals are two rejections; the step is then made in shorter increments."""
    class Moody(Hencky):
        refusals = 0

        def respond(self, strain, plastic_strain):
            self.refusals -= 1
            return replace(super().respond(strain), failed=(np.arange(len(strain)) == 7) & (self.refusals >= 0))

    simulation = build(USER, law=lambda points, stress: Moody(np.full(len(points), 1e6), 0.2))
    simulation.model.soil.law.law.refusals = 2
    record = next(simulation.steps())
    assert (record.rejections, record.increments, record.step) == (2, 3, 1)


# ------------------------------------------------------------------ several processes

SHARED = """
import sys
import numpy as np
import hybrid
from hybrid import Axis, Faces, Grid, Material, Output, Scene, Soil, Solver, Stage, Time
from hybrid.laws.von_mises import VonMises
from hybrid.runtime import comm, ranks
from hybrid.step import processes
given, moved, settled = [], [], processes._settled
def clay(points, stress):
    n = len(points)
    given.append(n)
    strength = 60.0 + 40.0 * points.position[:, 0] + 1e-3 * np.abs(stress[:, 2])
    if "by order" in sys.argv:
        strength = 60.0 + 10.0 * np.arange(n)
    return VonMises(np.full(n, 1e5) + 1e4 * points.position[:, 2], 0.3, strength)
def watched(model, state):
    new = settled(model, state)
    moved.append(len(new[1].points) != len(state.points))
    return new
processes._settled = watched
x, z = Axis(start=0.0, end=4.0, size=0.25), Axis(start=0.0, end=1.0, size=0.25)
scene = Scene(name="clay", gravity=(6.0, 0.0, -1.0), time=Time(step=0.04), stages=(Stage("slide", 10),),
              grid=Grid(x, Axis(start=0.0, end=0.5, collapsed=True), z, Faces(z_min="roller")),
              soil=Soil(Material(law="user", density=1000.0), lower=(0.5, 0.0, 0.0), upper=(1.5, 0.5, 0.5), geostatic=False),
              solver=Solver(tolerance=1e-8, linear_tolerance=1e-6), output=Output(every=0, pictures=()))
simulation = hybrid.run(scene, out=sys.argv[1], law=clay, quiet=True)
if ranks.started() > 1:
    assert any(moved) and len(given) > 2 and given[-1] == len(simulation.state.points)
"""


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("mpirun") is None, reason="needs mpirun")
def test_a_law_on_two_processes(tmp_path):
    """Clay that yields and slides from block to block: each process has the law of the points that it has got."""
    script = tmp_path / "script.py"
    script.write_text(SHARED)

    def run(ranks, folder, *more):
        command, environment = launch(ranks, ["-m", "mpi4py", script, tmp_path / folder, *more])
        return subprocess.run(command if ranks > 1 else [sys.executable, *command[6:]], capture_output=True, text=True,
                              timeout=120,
                              env={**environment, "NUMBA_NUM_THREADS": "1"})

    for ranks in (1, 2):
        done = run(ranks, str(ranks))
        assert done.returncode == 0, done.stderr
    one, two = (checkpoint.load(tmp_path / folder / "checkpoint.npz").points for folder in "12")
    assert one.position[:, 0].max() > 1.9 and one.plastic_strain.max() > 1e-4
    for name in ("position", "stress", "plastic_strain"):
        values = getattr(one, name)
        assert np.abs(values - getattr(two, name)).max() < 1e-6 * np.abs(values).max(), name
    refused = run(2, "other", "by order")
    assert refused.returncode != 0 and "VonMises of some of the points is not that of all points there" in refused.stderr
