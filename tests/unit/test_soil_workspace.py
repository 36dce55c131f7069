"""Trial values of the soil: how long they are valid, the reason of a refusal, and what the workspace keeps."""

from dataclasses import FrozenInstanceError, replace
from weakref import ref

import numpy as np
import pytest

from hybrid.scene import Solver
from hybrid.setup.build import build
from hybrid.soil.buffers import resized
from hybrid.soil.model import INSIDE_OUT, NO_STRESS, Refusal
from hybrid.soil.workspace import SoilWorkspace, keeps_tangents
from hybrid.step import newton
from hybrid.step.equations import begin
from hybrid.step.workspace import Workspace
from hybrid.study.scenes import soil_scene

ARRAYS = ("increment", "inverse", "strain", "directions")


@pytest.fixture(scope="module")
def simulation():
    return build(soil_scene(gravity=(0.0, 0.0, -9.81)))


@pytest.fixture
def begun(simulation):
    """(Soil, its SoilStep, function of a seed that gives nodal increments)."""
    soil, state = simulation.model.soil, simulation.state

    def shaken(seed, size=1e-3):
        moved = size * np.random.default_rng(seed).standard_normal((soil.grid.node_count, 3))
        return np.where(soil.grid.fixed, 0.0, moved)

    return soil, soil.begin(state.points, simulation.model.gravity), shaken


def test_a_trial_is_valid_until_the_next_evaluation(begun):
    soil, step, shaken = begun
    first = soil.evaluate(step, shaken(1))
    assert first.strain.valid
    second = soil.evaluate(step, shaken(2))
    assert second.strain.valid and not first.strain.valid
    for name in ARRAYS:
        with pytest.raises(AssertionError, match="pass the trial as `keep`"):
            getattr(first.strain, name)
    with pytest.raises(AssertionError, match="pass the trial as `keep`"):
        soil.plastic_work(step, first)
    with pytest.raises(AssertionError):
        soil.evaluate(step, shaken(3), keep=first)


def test_a_trial_that_is_kept_survives_others(begun):
    soil, step, shaken = begun
    best = soil.evaluate(step, shaken(1))
    before = {name: getattr(best.strain, name).copy() for name in ARRAYS}
    others = [soil.evaluate(step, shaken(seed), keep=best) for seed in (2, 3)]
    assert best.strain.valid and others[1].strain.valid and not others[0].strain.valid
    for name in ARRAYS:
        assert np.array_equal(getattr(best.strain, name), before[name])
        assert not np.shares_memory(getattr(best.strain, name), getattr(others[1].strain, name))
    again = soil.evaluate(step, shaken(1), keep=others[1])
    assert not best.strain.valid and np.array_equal(again.strain.strain, before["strain"])


def test_an_assembly_of_a_stale_evaluation_is_an_error(simulation):
    step = begin(simulation.model, simulation.state, 0.01, False, Workspace(simulation.model))
    stale = step.evaluate(step.predictor())
    kept = step.evaluate(step.at_rest())
    with pytest.raises(AssertionError, match="overwritten"):
        step.assemble(stale)
    step.evaluate(step.predictor(), keep=kept)
    step.assemble(kept)


def test_refusals_carry_their_reason(begun):
    soil, step, shaken = begun
    refusal = soil.evaluate(step, shaken(1, size=1.0))
    assert isinstance(refusal, Refusal) and refusal.reason == INSIDE_OUT and len(refusal.points)

    class Failing:
        def __getattr__(self, name):
            return getattr(soil.law, name)

        def respond(self, strain, plastic_strain=None):
            failed = np.arange(len(strain)) == 5
            return replace(soil.law.respond(strain, plastic_strain), failed=failed)

    refusal = replace(soil, law=Failing()).evaluate(step, shaken(1))
    assert refusal.reason == NO_STRESS and list(refusal.points) == [5]


def test_the_reason_of_a_refusal_is_that_of_the_outcome(simulation):
    points = replace(simulation.state.points, velocity=np.full_like(simulation.state.points.velocity, 0.0))
    points.velocity[:, 2] = -300.0 * (points.position[:, 2] - points.position[:, 2].min())
    step = begin(simulation.model, replace(simulation.state, points=points), 0.1, False, Workspace(simulation.model))
    refusal = step.evaluate(step.predictor())
    assert newton.solve(step).reason == f"the first guess {refusal.reason}"


def test_the_model_is_immutable(simulation):
    model = simulation.model
    for thing, name in ((model, "scheme"), (model.soil, "grid"), (model.soil, "fbar"), (model.solver, "tolerance")):
        with pytest.raises(FrozenInstanceError):
            setattr(thing, name, None)


def test_settings_have_one_home():
    """The scene's own settings reach the step, and soil without options has the defaults of a scene."""
    given = Solver(tolerance=3e-5, linear_tolerance=0.05)
    model = build(soil_scene(solver=given)).model
    assert model.solver is given or model.solver == given
    described = soil_scene().soil
    soil = type(model.soil)(model.soil.grid, model.soil.constants, model.soil.law)
    for name in ("basis", "domain", "held", "stray", "transfer"):
        assert getattr(soil, name) == getattr(type(described), name)


@pytest.mark.parametrize("tolerance, fbar, keeps", [(1e-2, False, True), (0.0, False, False), (1e-2, True, True)])
def test_where_tangents_are_kept(tolerance, fbar, keeps):
    solver = Solver(tangent_tolerance=tolerance)
    soil = build(soil_scene(solver=solver, fbar=fbar)).model.soil
    assert keeps_tangents(soil, solver) == keeps == (SoilWorkspace(soil, solver).kept is not None)
    assert SoilWorkspace(soil).kept is None     # the full tangent, without settings of a solver


def test_kept_tangents_do_not_keep_their_step(simulation):
    """The arrays of a past increment are freed before those of the next one are allocated."""
    workspace = Workspace(simulation.model)
    assert workspace.soil.kept is not None
    step = begin(simulation.model, simulation.state, 0.01, False, workspace)
    step.assemble(step.evaluate(step.predictor()))
    soil = ref(step.soil)
    del step
    assert soil() is None


def test_buffers_stay_while_the_soil_does(simulation):
    workspace, model = Workspace(simulation.model), simulation.model
    buffers = workspace.soil
    workspace.renew(model.for_stage(held=("x",)))
    assert workspace.soil is buffers
    workspace.renew(model.with_soil(replace(model.soil)))
    assert workspace.soil is not buffers


def test_buffers_keep_their_memory_until_more_points_come_than_they_have_room_for():
    first = resized(np.empty((0, 3)), 16)
    fewer, again, more = resized(first, 9), resized(resized(first, 9), 18), resized(first, 40)
    assert np.shares_memory(first, fewer) and np.shares_memory(first, again) and not np.shares_memory(first, more)
    assert [len(one) for one in (first, fewer, again, more)] == [16, 9, 18, 40] and more.shape[1:] == (3,)


def test_trials_after_points_have_moved_are_those_of_new_buffers(begun):
    """Of as many points, of fewer and of more again; trials of before are no longer valid."""
    soil, step, shaken = begun
    fresh, before = SoilWorkspace(soil), soil.evaluate(step, shaken(1))
    expected = soil.evaluate(replace(step, workspace=fresh), shaken(1)).force
    step.workspace.trial_strain.resize(3)
    step.workspace.follow_points(soil)
    assert not before.strain.valid
    np.testing.assert_array_equal(soil.evaluate(step, shaken(1)).force, expected)
