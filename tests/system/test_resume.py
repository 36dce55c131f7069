"""A run that stops keeps what it has and goes on from there to the same end."""

import json
from dataclasses import replace

import numpy as np
import pytest

import hybrid
from hybrid import Axis, Body, Faces, Grid, Material, Motion, Output, Scene, Soil, Solver, Stage, Time
from hybrid.output import checkpoint
from hybrid.output.history import read_history
from hybrid.runtime.errors import StepError
from hybrid.setup.build import build
from hybrid.step import contacts, iteration, newton


def scene(geometry, steps=6, body={}, **solver):
    axis = Axis(start=0.0, end=0.8, size=0.2)
    return Scene(
        name="pressed", grid=Grid(axis, axis, Axis(start=-0.6, end=0.2, size=0.2), Faces(z_min="fixed")),
        soil=Soil(Material(law="hencky", young=1e6, poisson=0.3, density=1800.0), top=0.0),
        bodies=(Body(**{"geometry": geometry / "sphere.geo", "density": 3000.0, "position": (0.41, 0.39, 0.0),
                        "parameters": {"radius": 0.25, "size": 0.12}, "rest_on": 0.0, "friction": 0.3, **body}),),
        time=Time(step=0.01), stages=(Stage("press", steps),), solver=Solver(tolerance=1e-9, **solver),
        output=Output(every=0, checkpoint=2))


def test_resumed_run_ends_where_the_whole_run_ends(geometry, tmp_path):
    whole = build(scene(geometry))
    list(whole.steps())
    hybrid.run(scene(geometry, steps=3), out=tmp_path, quiet=True)
    resumed = hybrid.run(scene(geometry, steps=6, line_search=False), out=tmp_path, resume=True, quiet=True)
    assert resumed.state.step == 6 and resumed.state.time == pytest.approx(0.06)
    assert np.allclose(resumed.state.bodies[0].position, whole.state.bodies[0].position, rtol=0, atol=1e-9)
    assert np.allclose(resumed.state.points.position, whole.state.points.position, rtol=0, atol=1e-9)
    history = read_history(tmp_path)
    assert history["step"].tolist() == [1, 2, 3, 4, 5, 6]


def sliding(geometry, steps, **solver):
    """The scene with a box that slides."""
    body = {"geometry": geometry / "box.geo", "parameters": {"length": 0.4, "width": 0.3, "height": 0.2, "size": 0.2},
            "velocity": (0.2, 0.1, 0.0), "spin": (0.0, 0.0, 0.5)}
    return scene(geometry, steps, body, **solver)


def saved(folder):
    """Every array of a checkpoint but the name of the run, as bytes."""
    with np.load(folder / "checkpoint.npz") as file:
        return {name: file[name].tobytes() for name in file.files if name != "run"}


def in_one_go_and_in_two(folder, described, stop, end):
    """Last checkpoints of a run of `end` steps and of one that is stopped and resumed, and the state it stopped in."""
    hybrid.run(described(end), out=folder / "whole", quiet=True)
    stopped = hybrid.run(described(stop), out=folder / "parts", quiet=True).state
    hybrid.run(described(end), out=folder / "parts", resume=True, quiet=True)
    whole, parts = saved(folder / "whole"), saved(folder / "parts")
    assert whole.keys() == parts.keys() and len(whole) > 30
    return whole, parts, stopped


@pytest.mark.parametrize("options", [{}, {"linear": "direct"}], ids=["auto", "direct"])
def test_contact_goes_on_to_the_last_bit(geometry, tmp_path, options):
    """Positions, sides and anchors of friction are in the checkpoint: no bit of the end differs."""
    whole, parts, stopped = in_one_go_and_in_two(tmp_path, lambda steps: sliding(geometry, steps, **options), 4, 6)
    (contact,) = stopped.contacts
    touching = contact.touching
    for history in (contact.side[touching], contact.anchor[touching]):
        assert len(history) >= 4 and np.linalg.norm(history, axis=1).all()
    assert [name for name in whole if whole[name] != parts[name]] == []


def test_increments_go_on_to_the_last_bit(geometry, tmp_path, monkeypatch):
    """A hard hit halves increments; the run goes on with the one that it stopped at, 7.5 ms of 10 ms."""
    monkeypatch.setattr(iteration, "MOST", 5)
    monkeypatch.setattr(contacts, "has_convex_contact", lambda *_: False)     # no second attempt
    whole, parts, _ = in_one_go_and_in_two(
        tmp_path, lambda steps: scene(geometry, steps, {"velocity": (0.4, 0.1, -3.0)}, line_search=False), 3, 4)
    history = read_history(tmp_path / "parts")
    assert history["increments"].min() < history["increments"].max() and history["rejections"].sum() > 5
    assert [name for name in whole if whole[name] != parts[name]] == []


def test_increments_by_accuracy_go_on_to_the_last_bit(geometry, tmp_path):
    def hit(steps):
        described = scene(geometry, steps, {"velocity": (0.4, 0.1, -1.0)})
        return replace(described, time=replace(described.time, accuracy=1e-4))

    whole, parts, _ = in_one_go_and_in_two(tmp_path, hit, 3, 5)
    history = read_history(tmp_path / "parts")
    assert history["increments"].min() > 2 and 0 < history["time_error_m"].max() < 1e-4 * 0.2
    assert [name for name in whole if whole[name] != parts[name]] == []


def test_newtons_method_goes_on_with_shorter_updates(geometry, tmp_path, monkeypatch):
    """In soil that yields, where the increment before the stop needed them; not in the first increment of a run."""
    begins, solve = [], newton.solve

    def watched(step, short, shorten):
        begins.append(shorten)
        return replace(solve(step, short, shorten), backtracked=True)

    def described(steps):
        soil = scene(geometry).soil
        clay = replace(soil.material, law="von-mises", strength=1e5)
        return replace(scene(geometry, steps), soil=replace(soil, material=clay))

    monkeypatch.setattr(newton, "solve", watched)
    hybrid.run(described(2), out=tmp_path, quiet=True)
    first = len(begins)
    hybrid.run(described(3), out=tmp_path, resume=True, quiet=True)
    assert begins[:2] == [False, True] and begins[first] is True


@pytest.fixture(scope="module")
def stopped(geometry, tmp_path_factory):
    """Simulation of one more step, the state that a run stopped in, and the body's velocity a step later."""
    folder = tmp_path_factory.mktemp("stopped")
    state = hybrid.run(sliding(geometry, 4), out=folder, quiet=True).state
    simulation = build(sliding(geometry, 5))
    return simulation, state, one_step_on(simulation, state)


def one_step_on(simulation, state):
    simulation.state = state
    list(simulation.steps())
    return simulation.state.bodies[0].velocity


@pytest.mark.parametrize("forgotten", ["position", "touching", "anchor"])
def test_each_part_of_the_contact_history_matters(stopped, forgotten):
    """The final state differs when one of them is lost. (Sides matter at rims and thin plates only.)"""
    simulation, state, velocity = stopped
    (contact,) = state.contacts
    lost = replace(state, contacts=[replace(contact, **{forgotten: np.zeros_like(getattr(contact, forgotten))})])
    assert np.array_equal(one_step_on(simulation, state), velocity)
    assert np.abs(one_step_on(simulation, lost) - velocity).max() > 1e-9


def test_a_checkpoint_of_another_format_is_refused(geometry, tmp_path):
    hybrid.run(scene(geometry, steps=2), out=tmp_path, quiet=True)
    path = tmp_path / "checkpoint.npz"
    with np.load(path) as file:
        old = {**file, "format": checkpoint.FORMAT - 1}
    np.savez(path, **old)
    with pytest.raises(checkpoint.CheckpointError) as refusal:
        hybrid.run(scene(geometry, steps=4), out=tmp_path, resume=True, quiet=True)
    message = f"{path} has format {checkpoint.FORMAT - 1}, this version reads {checkpoint.FORMAT}: start a new run"
    assert str(refusal.value) == message + ", with --overwrite"


def test_a_failed_run_keeps_its_steps_and_names_the_remedy(geometry, tmp_path, monkeypatch):
    hybrid.run(scene(geometry, steps=3, line_search=False), out=tmp_path, quiet=True)
    monkeypatch.setattr(iteration, "MOST", 0)
    with pytest.raises(StepError, match="time.step") as failure:
        hybrid.run(scene(geometry, steps=6, line_search=False), out=tmp_path, resume=True, quiet=True)
    assert "All accepted steps are kept" in str(failure.value)
    assert read_history(tmp_path)["step"].tolist()[:3] == [1, 2, 3]
    assert (tmp_path / "checkpoint.npz").exists() and '"failed"' in (tmp_path / "summary.json").read_text()


def test_direct_and_automatic_solvers_agree(geometry):
    ends = []
    for linear in ("auto", "direct"):
        simulation = build(scene(geometry, linear=linear))
        list(simulation.steps())
        ends.append(simulation.state.bodies[0].position)
    assert np.allclose(*ends, rtol=0, atol=1e-9)


@pytest.mark.parametrize("fails", [False, True])
def test_an_observer_that_fails_at_the_end_keeps_no_other_from_it(geometry, fails, monkeypatch):
    """Nor does it hide why the run failed."""
    outcomes = []

    class Observer:
        def __init__(self, fails):
            self.fails = fails

        def start(self, simulation):
            """Nothing to prepare."""

        def accepted(self, record, simulation):
            """Nothing to note."""

        def finish(self, summary, simulation):
            if self.fails:
                raise ValueError("no room left")
            outcomes.append(summary["outcome"])

    described = scene(geometry, steps=1, body={"velocity": (0.4, 0.1, -3.0)})
    if fails:
        monkeypatch.setattr(iteration, "MOST", 1)
        described = replace(described, time=Time(step=0.01, smallest=0.01))
    simulation = build(described)
    with pytest.raises(StepError if fails else ValueError, match="step 1 failed" if fails else "no room left"):
        simulation.run([Observer(True), Observer(False)])
    assert outcomes == ["failed" if fails else "completed"]


def test_bonds_that_have_broken_stay_broken_in_a_resumed_run(geometry, tmp_path):
    """A block that rests on clay is lifted to beyond its tension, comes back and is lifted again; it stops in between."""
    axis, speed = Axis(start=0.0, end=0.4, size=0.2), ((0.0, 2e-3), (3.0, 2e-3), (3.1, -2e-3), (6.0, -2e-3), (6.1, 2e-3))
    material = Material(law="von-mises", young=1e6, poisson=0.3, density=1000.0, strength=1e6)

    def described(steps):
        return Scene(
            name="lifted", grid=Grid(axis, axis, Axis(start=-0.4, end=0.2, size=0.2), Faces(z_min="fixed")),
            soil=Soil(material, top=0.0, geostatic=False), gravity=(0.0, 0.0, 0.0), time=Time(1.0, inertia=False),
            bodies=(Body(geometry / "box.geo", 1000.0, parameters={"length": 1.0, "width": 1.0, "height": 0.2, "size": 0.5},
                         position=(0.2, 0.2, 0.0), rest_on=0.0, held=("x", "y", "rx", "ry", "rz"), tension=5e3),),
            stages=(Stage("lift", steps, motions=(Motion(component="z", velocity=speed),)),), output=Output(every=0))

    whole, parts, stopped = in_one_go_and_in_two(tmp_path, described, 4, 8)
    assert stopped.contacts[0].opened.any()
    assert [name for name in whole if whole[name] != parts[name] and not name.startswith("extra/")] == []
    forces = read_history(tmp_path / "whole")["body_contact_fz_N"]
    # 0.1 % of the bonds lie over one another at the edges of the box
    assert forces.min() == pytest.approx(-5e3 * 0.16, rel=2e-3) and forces[-1] == 0.0


def test_a_resumed_run_keeps_its_notes(geometry, tmp_path):
    """Those given before it, and what monitors had summed up: most of an impact is lost in the first steps."""
    def described(steps):
        falling = {"position": (0.41, 0.39, 0.26), "rest_on": None, "velocity": (0.0, 0.0, -3.0)}
        clay = Material(law="von-mises", young=1e6, poisson=0.3, density=1800.0, strength=4e3)
        return replace(scene(geometry, steps, falling), soil=Soil(clay, top=0.0), time=Time(step=0.01))

    def notes(part):
        return json.loads((tmp_path / part / "summary.json").read_text())["notes"]

    hybrid.run(described(9), out=tmp_path / "whole", quiet=True)
    hybrid.run(described(6), out=tmp_path / "parts", quiet=True)
    before = notes("parts")
    hybrid.run(described(9), out=tmp_path / "parts", resume=True, quiet=True)
    assert before and notes("parts") == notes("whole")
    assert sum("impact" in text for text in notes("whole")) == 1


def test_a_body_that_touches_something_later_is_not_said_to_have_touched_nothing(geometry, tmp_path):
    """A note about a whole run belongs to its end; a text that cannot be read counts as none."""
    def described(steps):
        driven = {"position": (0.41, 0.39, 0.3), "rest_on": 0.03, "velocity": (0.0, 0.0, -1.0), "driven": ("z",)}
        return scene(geometry, steps, driven)

    def notes():
        given = json.loads((tmp_path / "summary.json").read_text())["notes"]
        return [text for text in given if "at the end of any step" in text]

    hybrid.run(described(2), out=tmp_path, quiet=True)
    assert len(notes()) == 1
    resumed = hybrid.run(described(6), out=tmp_path, resume=True, quiet=True)
    assert resumed.state.step == 6 and not notes()
    for odd in ("nan", "(", "3", "__import__('os')"):
        again = build(described(6))
        again.resume(resumed.state, remembered=odd)
        assert again.notes == []
