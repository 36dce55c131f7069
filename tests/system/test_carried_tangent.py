"""The tangent of a step serves in the next ones of a block of sand that falls: a third of the assemblies, the same motion;
a run goes on bit for bit from each step after which it is assembled afresh."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import hybrid.simulation
from hybrid.bench.scenes import block
from hybrid.linalg.system_cache import CarriedTangent, Systems
from hybrid.runtime.timing import PHASES
from hybrid.scene import Solver, Stage
from hybrid.setup.build import build
from hybrid.soil.model import Refusal
from hybrid.step import sticking
from hybrid.step.equations import Step, begin
from hybrid.step.iteration import Safeguards, Updates
from hybrid.step.workspace import Workspace

STEPS, CELLS = 14, (8, 8, 4)


def falling(checkpoint=5, stages=(Stage("fall", STEPS),)):
    """Simulation of a block of sand, in whose first steps points begin to yield."""
    scene = block(CELLS, 1 / CELLS[0], steps=STEPS)
    return build(replace(scene, stages=stages, output=replace(scene.output, checkpoint=checkpoint)))


@pytest.fixture
def assembled(monkeypatch):
    """Numbers of the steps in which a tangent was assembled, in order."""
    steps, assemble = [], Step.assemble

    def counted(step, *given):
        steps.append(step.state.step + 1)
        assemble(step, *given)

    monkeypatch.setattr(Step, "assemble", counted)
    return steps


def without(monkeypatch):
    """Carry no tangent from now on."""
    monkeypatch.setattr(CarriedTangent, "take", lambda carried, length: False)


def test_few_steps_assemble_a_tangent_and_the_motion_is_the_same(assembled, monkeypatch):
    carried = falling()
    iterations = sum(record.iterations for record in carried.steps())
    few = assembled.copy()
    without(monkeypatch)
    fresh = falling()
    each = sum(record.iterations for record in fresh.steps())
    assert 3 * len(few) < 1.2 * (len(assembled) - len(few)) and iterations <= each + 3
    sunk = fresh.initial_position - fresh.state.points.position
    error = np.abs(carried.state.points.position - fresh.state.points.position).max()
    assert error < 2 * fresh.scene.solver.tolerance * np.abs(sunk).max()


@pytest.mark.parametrize("checkpoint, due", [(5, (1, 6, 11)), (4, (1, 5, 9, 13)), (0, (1, 11))])
def test_a_tangent_is_assembled_after_each_checkpoint_that_is_due(assembled, checkpoint, due):
    list(falling(checkpoint).steps())
    assert set(due) <= set(assembled) and len(set(assembled)) < STEPS


@pytest.mark.parametrize("stopped, exact", [(5, True), (7, False)])
def test_a_run_goes_on_to_the_last_bit_from_a_checkpoint_that_is_due(stopped, exact):
    whole, first, rest = falling(), falling(), falling()
    list(whole.steps())
    for record in first.steps():
        if record.step == stopped:
            break
    rest.resume(first.state, first.increment, first.backtrack, first.solver_memory)
    list(rest.steps())
    one, other = whole.state.points.position, rest.state.points.position
    assert (one == other).all() == exact
    np.testing.assert_allclose(one, other, rtol=0, atol=1e-6)


def test_each_step_has_the_time_of_each_phase(assembled):
    records = list(falling().steps())
    without = [record.seconds for record in records if record.step not in assembled]
    assert without and all(set(record.seconds) == set(PHASES) for record in records)
    assert all(seconds["assemble"] == seconds["factor"] == 0.0 < seconds["solve"] for seconds in without)


def test_another_stage_begins_with_a_tangent_of_its_own(assembled):
    list(falling(stages=(Stage("fall", 2), Stage("damp", 2, beta=0.5, gamma=0.9))).steps())
    assert 3 in assembled


def test_an_update_that_leads_astray_is_not_taken(monkeypatch):
    """Here a carried tangent has a thousandth of its stiffness: the first update is a thousand times too long."""
    fresh = falling()
    list(fresh.steps())
    begin = Systems.get
    spoilt = []

    def softened(systems, *given):
        pattern, system = begin(systems, *given)
        if systems.carried._length is not None:
            system.values *= 1e-3
            system.factor()
            spoilt.append(True)
        return pattern, system

    monkeypatch.setattr(Systems, "get", softened)
    simulation = falling()
    records = list(simulation.steps())
    assert len(spoilt) >= 2 and not any(record.rejections for record in records)
    np.testing.assert_allclose(simulation.state.points.position, fresh.state.points.position, rtol=0, atol=1e-6)
    monkeypatch.setattr("hybrid.step.iteration.SLOW", np.inf)      # and would lead far away
    assert sum(r.iterations for r in falling().steps()) > 1.3 * sum(r.iterations for r in records)


def safeguards(monkeypatch, updates=Updates(5), stick=None, unknowns=1):
    """Safeguards of a stand-in for a step of 0.1 s with a carried tangent; `assembled` of the step: its assemblies."""
    carried, assembled = CarriedTangent(), []
    carried.keep(0.1)
    law, scheme = SimpleNamespace(plastic=False), SimpleNamespace(inertia=True)
    step = SimpleNamespace(carried=carried, dt=0.1, assembled=assembled, soil=None,
                           model=SimpleNamespace(solver=Solver(), scheme=scheme, soil=SimpleNamespace(law=law)),
                           system=SimpleNamespace(soil_unknowns=unknowns, solve=lambda *given: (None, None, 1)),
                           assemble=lambda *given: assembled.append(True))
    monkeypatch.setattr(sticking, "drifting", lambda *given: stick)
    monkeypatch.setattr(sticking, "held_in_stick", lambda step, evaluation, points: evaluation)
    return Safeguards(step, updates)


def at(error):
    return SimpleNamespace(error=error, soil=None, body=None)


@pytest.mark.parametrize("how, fresh", [
    ({}, False), ({"stick": "points"}, True), ({"updates": Updates(5, backtrack=True)}, True), ({"unknowns": 0}, True)])
def test_which_first_updates_take_a_carried_tangent(monkeypatch, how, fresh):
    """Not one with points held in stick, with backtracking, or of bodies alone; and no second one."""
    found = safeguards(monkeypatch, **how)
    found.solve(at(1.0))
    assert bool(found.step.assembled) == fresh == (not found.carried)
    assert not found.misled(at(1.0), at(0.1))
    found.step.assembled.clear()
    found.solve(at(0.1))
    assert found.step.assembled


@pytest.mark.parametrize("left, updates, keeps", [(0.29, 3, True), (0.31, 3, False), (0.29, 4, False)])
def test_which_tangents_are_carried_on(monkeypatch, left, updates, keeps):
    found = safeguards(monkeypatch)
    found.solve(at(1.0))
    found.misled(at(1.0), at(left))
    found.keep_tangent(updates)
    assert found.step.carried.take(0.1) == keeps


def test_tangents_whose_updates_leave_too_much_for_a_second_one_fail(monkeypatch):
    """In elastic soil 0.15 of the residual: 0.2 is taken, and counts as a failure."""
    found = safeguards(monkeypatch)
    for carries in (True, False):
        found.first = None
        found.solve(at(1.0))
        assert found.carried and not found.misled(at(1.0), at(0.2))
        found.keep_tangent(2)
        assert found.step.carried.take(0.1) == carries
        found.step.carried.keep(0.1)


def test_a_refused_update_with_a_carried_tangent_is_not_the_end(monkeypatch):
    found = safeguards(monkeypatch)
    found.solve(at(1.0))
    assert found.misled(at(1.0), Refusal("turns soil inside out"))
    fresh = safeguards(monkeypatch, stick="points")
    fresh.solve(at(1.0))
    assert not fresh.misled(at(1.0), at(0.9))


def test_another_assembly_drops_it():
    """As that of `first_guess.followed` does, whose contact holds on to the soil."""
    simulation = falling()
    workspace = Workspace(simulation.model)
    step = begin(simulation.model, simulation.state, 0.01, False, workspace)
    step.carried.keep(0.01)
    step.assemble(step.evaluate(step.at_rest()))
    assert not step.carried.take(0.01)
    workspace.destroy()


def test_a_tangent_is_carried_until_two_have_failed():
    carried = CarriedTangent()
    assert not carried.take(0.1)
    carried.keep(0.1)
    assert not carried.take(0.05) and not carried.take(0.1)     # of another length, and then dropped
    for carries in (True, True, False):
        carried.keep(0.1)
        assert carried.take(0.1 * (1 + 1e-12)) == carries
        carried.fail()
    assert hybrid.simulation.AFRESH == 10
