"""Acceptance, rejection and halving of increments; what a failure leaves behind; runs side by side."""

import re
from copy import deepcopy
from dataclasses import fields, replace
from types import SimpleNamespace

import numpy as np
import pytest

from hybrid import simulation as simulation_module
from hybrid.bench.scenes import block
from hybrid.body import rigid
from hybrid.linalg import system_cache as cache_module
from hybrid.runtime.errors import StepError
from hybrid.scene import Axis, Body, Faces, Grid, Material, Pull, Scene, Soil, Solver, Stage, Time
from hybrid.setup.build import build
from hybrid.soil.model import Refusal
from hybrid.step import contacts, first_guess, iteration, newton
from hybrid.step.equations import begin
from hybrid.step.increments import Control, outer_step
from hybrid.step.workspace import Workspace

LENGTH = 0.01


def scene(geometry, **soil):
    """A sphere that hits sand hard; the first contact is in the first step. By the published method, whose contact is
    soft enough for one increment and yet needs more iterations than some tests allow."""
    side = Axis(start=-0.4, end=0.4, size=0.2)
    return Scene(
        name="hit", method="published", grid=Grid(side, side, Axis(start=-0.4, end=0.4, size=0.2), Faces(z_min="fixed")),
        soil=Soil(Material(law="drucker-prager", young=1e6, poisson=0.3, density=1800.0, friction_angle=30.0,
                           dilation_angle=5.0, cohesion=1e3), top=0.0, **soil),
        bodies=(Body(geometry=geometry / "sphere.geo", density=3000.0,
                     parameters={"radius": 0.2, "size": 0.12}, position=(0.03, -0.02, 0.2),
                     velocity=(0.4, 0.1, -3.0), spin=(0.0, 3.0, 0.0), friction=0.3,
                     pull=Pull(point=(0.0, 0.0, 0.0), velocity=(0.5, 0.0, 0.0), stiffness=1e4, length=1.0)),),
        time=Time(step=LENGTH), stages=(Stage("one", 2),),
        solver=Solver(linear="direct", tolerance=1e-6, line_search=False))


def ready(described):
    """Simulation with its pull lines laid out."""
    simulation = build(described)
    simulation.state.bodies = [
        rigid.lay_out_line(b, s) for b, s in zip(simulation.model.bodies, simulation.state.bodies)]
    return simulation


def arrays(thing, prefix=""):
    """Every array reachable from a dataclass, by path."""
    if isinstance(thing, np.ndarray):
        yield prefix, thing
    elif isinstance(thing, (list, tuple)):
        for n, item in enumerate(thing):
            yield from arrays(item, f"{prefix}[{n}]")
    elif hasattr(thing, "__dataclass_fields__"):
        for field in fields(thing):
            yield from arrays(getattr(thing, field.name), f"{prefix}.{field.name}")


def assert_untouched(state, copy):
    found, wanted = dict(arrays(state)), dict(arrays(copy))
    assert found.keys() == wanted.keys() and len(found) > 15
    for path in found:
        assert found[path].tobytes() == wanted[path].tobytes(), path
    assert (state.time, state.step, state.work) == (copy.time, copy.step, copy.work)


def one_step(simulation, control, state=None, **solver):
    """(new State, Report) of an outer step; solver: settings that are different."""
    state = simulation.state if state is None else state
    model = replace(simulation.model, solver=replace(simulation.model.solver, **solver))
    return outer_step(model, Workspace(model), state, LENGTH, True, control)


def test_an_easy_step_is_one_increment(geometry):
    simulation = ready(scene(geometry))
    state, report = one_step(simulation, Control(LENGTH, LENGTH / 64))
    assert (report.increments, report.rejections, report.dt) == (1, 0, LENGTH)
    assert state.step == 1 and state.time == LENGTH and report.evaluation.error <= 1e-6
    assert len(report.evaluation.contacts[0]) >= 4      # the hit was in it


def test_accept_returns_the_complete_new_state(geometry):
    """Each increment advances the time; at the end of the outer step the state has exactly its time, and the next
    step number."""
    simulation = ready(scene(geometry))
    state = replace(simulation.state, time=1 / 3, step=4)
    step = begin(simulation.model, state, LENGTH / 2, True, Workspace(simulation.model))
    evaluation = newton.solve(step).evaluation
    part, whole = step.accept(evaluation), step.accept(evaluation, end=0.34)
    assert (part.time, part.step) == (1 / 3 + LENGTH / 2, 4) and (whole.time, whole.step) == (0.34, 5)
    for path, array in dict(arrays(part)).items():
        assert np.array_equal(array, dict(arrays(whole))[path]), path
    assert part.work == whole.work and (state.time, state.step) == (1 / 3, 4)


@pytest.mark.parametrize("iterations", [2, 3])
def test_a_hard_step_is_rejected_and_halved(geometry, iterations, monkeypatch):
    """Too few iterations allowed: shorter increments need fewer, and the outer step still ends on time."""
    monkeypatch.setattr(iteration, "MOST", iterations)
    monkeypatch.setattr(contacts, "has_convex_contact", lambda *_: False)     # no second attempt
    monkeypatch.setattr(newton, "RELAXED", 1.0)
    simulation = ready(scene(geometry))
    before = deepcopy(simulation.state)
    state, report = one_step(simulation, Control(LENGTH, LENGTH / 64))
    halvings = round(np.log2(LENGTH / report.dt))
    assert halvings >= 1 and report.dt == pytest.approx(LENGTH / 2**halvings)
    assert report.rejections >= halvings and report.increments > halvings and report.iterations > iterations
    assert state.time == LENGTH and state.step == 1 and report.evaluation.error <= 1e-6
    assert_untouched(simulation.state, before)


def test_increments_grow_again(geometry):
    simulation = build(replace(scene(geometry), bodies=()))
    control = Control(LENGTH / 8, LENGTH / 64)
    state, report = one_step(simulation, control)
    assert report.increments == 4      # an eighth, a quarter, a half, the rest
    assert report.dt == pytest.approx(LENGTH / 8)
    assert control.dt == LENGTH and report.rejections == 0
    assert one_step(simulation, control, state)[1].increments == 1


@pytest.mark.parametrize("most, floor, start", [(1, 1, 0.0), (2, 4, 0.0025)])
def test_the_floor_stops_the_run_with_value_limit_and_remedy(geometry, most, floor, start, monkeypatch):
    """At once, or after a part of the outer step was accepted: what was committed stays as it was."""
    monkeypatch.setattr(iteration, "MOST", most)
    monkeypatch.setattr(contacts, "has_convex_contact", lambda *_: False)     # no second attempt
    monkeypatch.setattr(newton, "RELAXED", 1.0)
    simulation = ready(scene(geometry))
    before = deepcopy(simulation.state)
    with pytest.raises(StepError) as caught:
        one_step(simulation, Control(LENGTH, LENGTH / floor))
    message = str(caught.value)
    assert f"step 1 failed at t = {start:g} s with an increment of {LENGTH / floor:g} s" in message     # where
    norms = r"\(soil [\d.e+-]+ N, .* N m\)"
    assert re.search(rf"residual \d\.\d\de-\d\d after {most} iterations, tolerance 1e-06 {norms}", message)
    assert f"below the limit of {LENGTH / floor:g} s (time.smallest)" in message                  # the limit
    assert "a smaller time.step" in message and "a lower body.penalty" in message             # the remedy
    assert_untouched(simulation.state, before)


def test_a_failed_run_keeps_the_last_accepted_step(geometry):
    """The second step of a run fails; the first is kept, and observers get the reason."""
    described = scene(geometry)
    simulation = build(replace(described, time=Time(step=LENGTH, smallest=LENGTH)))
    ends = []

    class Observer:
        def start(self, simulation):
            pass

        def accepted(self, record, simulation):
            simulation.model.bodies[0].contact_pressure[:] *= 1e9      # beyond what Newton can do
            self.kept = deepcopy(simulation.state)

        def finish(self, summary, simulation):
            ends.append(dict(summary))

    watcher = Observer()
    with pytest.raises(StepError):
        simulation.run([watcher])
    assert simulation.state.step == 1
    assert_untouched(simulation.state, watcher.kept)
    assert ends[0]["outcome"] == "failed" and "step 2 failed" in ends[0]["reason"]


def test_soil_turned_inside_out_is_a_rejection(geometry):
    """A first guess that inverts points is no crash but a reason, and halving cures it."""
    simulation = build(replace(scene(geometry), bodies=()))
    points = simulation.state.points
    points.velocity[:, 2] = -60.0 * (points.position[:, 2] + 0.4) / 0.4
    step = begin(simulation.model, simulation.state, 10 * LENGTH, False, Workspace(simulation.model))
    outcome = newton.solve(step)
    assert not outcome.converged and "inside out" in outcome.reason
    state, report = one_step(simulation, Control(LENGTH, LENGTH / 64))
    assert state.step == 1


@pytest.mark.parametrize("held", [False, True])
def test_committed_and_trial_arrays_are_never_the_same(geometry, held):
    simulation = ready(scene(geometry, held=held))
    state, workspace = simulation.state, Workspace(simulation.model)
    for _ in range(2):
        before = deepcopy(state)
        step = begin(simulation.model, state, LENGTH, True, workspace)
        outcome = newton.solve(step)
        assert outcome.converged
        committed, found = dict(arrays(state)), outcome.evaluation
        trial = dict(arrays(
            (found.unknowns, found.soil_trial, found.contacts, [terms.trial for terms in found.bodies], found.rates)))
        if not held:
            trial |= {name: getattr(found.soil_trial.strain, name)
                      for name in ("increment", "inverse", "strain", "directions")}
        accepted = step.accept(outcome.evaluation)
        if held:      # points that cannot move are handed on as they are
            committed = {path: a for path, a in committed.items() if not path.startswith(".points")}
        for new in (trial, dict(arrays(accepted))):
            for path, array in new.items():
                for old in committed:
                    assert not np.shares_memory(array, committed[old]), (path, old)
        if not held:
            points = dict(arrays(accepted.points))
            for path, array in points.items():
                for name, other in trial.items():
                    assert not np.shares_memory(array, other), (path, name)     # buffers are written again
        assert accepted.work is not state.work
        assert_untouched(state, before)
        state = accepted


def test_runs_of_every_kind_side_by_side(geometry):
    """Soil alone, a body on held soil, both, Krylov and direct: no run leaves settings to the next."""
    both = scene(geometry)
    kinds = {"soil": replace(both, bodies=()), "held": scene(geometry, held=True), "both": both}
    found = {}
    for linear in ("direct", "auto", "direct", "auto"):
        for name, described in kinds.items():
            simulation = build(replace(described, solver=Solver(linear=linear, tolerance=1e-9)))
            for record in simulation.steps():
                assert record.rejections == 0
            body = simulation.state.bodies[0].position if simulation.state.bodies else 0.0
            found.setdefault(name, []).append(simulation.state.points.position.sum() + np.sum(body))
    for name, values in found.items():
        np.testing.assert_allclose(values, values[0], rtol=1e-9, err_msg=name)


def test_a_failure_keeps_its_kind_and_limits_are_looked_at_once(geometry, monkeypatch):
    class Special(StepError):
        """One that its catcher knows."""

    def fail(*_):
        raise Special("it failed")

    asked = []
    monkeypatch.setattr(simulation_module, "limit_warnings", lambda *_: asked.append(1) or ("a limit exceeded",))
    monkeypatch.setattr(simulation_module, "outer_step", fail)
    simulation = build(scene(geometry))
    for _ in range(2):
        assert simulation.sheet()["warnings"] == ["a limit exceeded"]
        with pytest.raises(Special, match=r"^it failed\. a limit exceeded$"):
            list(simulation.steps())
    assert len(asked) == 1


def test_matrices_of_a_stage_go_before_those_of_the_next_come(geometry, monkeypatch):
    """PETSc keeps what Python has let go of until it is destroyed."""
    alive, most = [], []

    class Counted(cache_module.BlockSystem):
        def __init__(self, *given):
            alive.append(self)
            most.append(len(alive))
            super().__init__(*given)

        def destroy(self):
            alive.remove(self)
            super().destroy()

    monkeypatch.setattr(cache_module, "BlockSystem", Counted)
    stages = tuple(Stage(name, 1) for name in "abc")
    assert len(list(build(replace(scene(geometry), stages=stages)).steps())) == 3
    assert len(most) >= 4 and max(most) == 1 and not alive
    next(steps := build(scene(geometry)).steps())
    steps.close()       # as where the caller has seen enough, or a step fails
    assert not alive


def test_soil_that_would_open_starts_from_rest(monkeypatch):
    """A block of sand that its own weight throws up: where everything keeps its velocity, half of it and more opens."""
    def fallen():
        described = block((4, 4, 13), 0.5 / 13, steps=4)
        simulation = build(replace(described, time=replace(described.time, scheme="newmark"),
                                   solver=replace(described.solver, tolerance=1e-5)))
        return max(record.iterations for record in simulation.steps()), simulation.state.points

    monkeypatch.setattr(iteration, "SLOW", np.inf)     # the first guess alone
    most, points = fallen()
    monkeypatch.setattr(first_guess, "OPENED", 2.0)
    without, same = fallen()
    assert most <= 4 and without >= 7
    np.testing.assert_allclose(points.position, same.position, rtol=0, atol=1e-9)   # another way to one solution


class Guess:
    """Stands for a step of which the two first guesses open these shares of the soil; None: they are refused."""

    def __init__(self, moving, still, inertia=True):
        self.made, self.model = [], SimpleNamespace(scheme=SimpleNamespace(inertia=inertia))
        self._share = {"moving": moving, "still": still}
        self.predictor, self.driven = lambda: "moving", lambda: "still"
        self.apex_fraction = lambda evaluation: self._share[evaluation.unknowns]

    def evaluate(self, unknowns, keep=None):
        """Without `keep` the trial strains of the last evaluation are overwritten."""
        for earlier in self.made:
            earlier.valid &= earlier is keep
        if self._share[unknowns] is None:
            return Refusal("turns soil inside out")
        self.made.append(SimpleNamespace(unknowns=unknowns, valid=True))
        return self.made[-1]


@pytest.mark.parametrize("moving, still, inertia, start", [
    (0.05, 0.0, True, "moving"), (0.5, 0.0, True, "still"), (0.5, 0.48, True, "moving"), (0.5, None, True, "moving"),
    (0.5, 0.0, False, "moving")])
def test_where_newtons_method_starts(moving, still, inertia, start):
    """Soil in free flight is open anyway and keeps its velocity."""
    step = Guess(moving, still, inertia)
    evaluation = first_guess.first_evaluation(step)
    assert evaluation.unknowns == start and evaluation.valid and len(step.made) <= 2


def test_there_may_be_no_start():
    assert first_guess.first_evaluation(Guess(None, 0.0)) == Refusal("turns soil inside out")
