"""Monitors: each warning is given once, and its remedies fit the scene."""

from types import SimpleNamespace

import pytest

from hybrid.monitors import MONITORS, Monitors, StepView
from hybrid.monitors.energy_balance import EnergyBalance
from hybrid.monitors.failure_hints import advice, probable_causes
from hybrid.monitors.monitor import Monitor
from hybrid.scene import Solver, Time
from hybrid.setup.build import build
from hybrid.step.equations import begin
from hybrid.step.workspace import Workspace
from hybrid.study.scenes import box, soil_scene


def test_a_warning_is_given_once_for_each_key():
    class Numbers(Monitor):
        def warnings(self, view):
            for number in view:
                yield number, f"number {number}"

    monitor = Numbers(None, None)
    assert monitor.notes((1, 2)) == ("number 1", "number 2") and monitor.given(2) and not monitor.given(3)
    assert monitor.notes((2, 3)) == ("number 3",)
    assert monitor.notes((1, 2, 3)) == ()


def test_a_run_has_every_monitor_and_a_calm_step_no_note():
    simulation = build(soil_scene(steps=1))
    (record,) = simulation.steps()
    assert record.notes == () and len(MONITORS) == 7 == len(set(MONITORS))
    assert len(Monitors(simulation.model, simulation.state)._monitors) == len(MONITORS)


def balance(errors, stored=100.0, bodies=(), inertia=True, damps=False, accuracy=None):
    """Notes of steps with these errors [J] of the balance."""
    monitor = EnergyBalance(None, None)
    view = {"model": SimpleNamespace(bodies=bodies), "scheme": SimpleNamespace(inertia=inertia, damps=damps),
            "report": SimpleNamespace(error=accuracy)}
    return [note for time, error in enumerate(errors) for note in monitor.notes(StepView(
        state=SimpleNamespace(time=time), energy={"kinetic": stored, "elastic": 0.0, "contact": 0.0, "error": error},
        **view))]


def test_energy_within_its_limits_gives_no_note():
    assert balance([0.0, 24.0, -25.0, 0.0]) == [] and balance([0.0, 0.0], stored=0.0) == []


def test_a_gain_and_a_loss_are_reported_once_each():
    gain, loss = balance([0.0, 30.0, 40.0, -20.0, -80.0])
    assert gain.startswith("energy balance: unaccounted gain of 30 J at t = 1 s (30% of the largest") and "25%" in gain
    assert loss.startswith("energy balance: unaccounted loss of 60 J in the step to t = 3 s (60% of") and "50%" in loss
    assert balance([0.0, -80.0], damps=True) == [] == balance([0.0, -80.0], inertia=False)


@pytest.mark.parametrize("scene, present, absent", [
    ({"bodies": (1,)}, ["time.accuracy = 1e-3", "body.penalty", "damps"], ["stage.steps"]),
    ({}, ["a smaller time.step", "damps"], ["body.penalty", "Contact"]),
    ({"accuracy": 1e-5}, ["a smaller time.accuracy"], ["time.accuracy ="]),
    ({"damps": True}, ["a smaller time.step"], ["a scheme that damps"]),
    ({"inertia": False, "bodies": (1,)}, ["stage.steps"], ["time.accuracy", "time.step", "damps"])])
def test_remedies_of_a_gain_fit_the_scene(scene, present, absent):
    text, = balance([0.0, 50.0], **scene)
    assert all(words in text for words in present) and not any(words in text for words in absent)


def started(**more):
    """(Step of a quasi-static scene with a box, its Evaluation at rest, Workspace)."""
    body = box(0.2, 0.2, 0.2, held=("x", "y", "rx", "ry", "rz"), position=(0.4, 0.4, 0.0), **more)
    simulation = build(soil_scene([body], time=Time(step=1.0, inertia=False), gravity=(0.0, 0.0, -9.81)))
    workspace = Workspace(simulation.model)
    step = begin(simulation.model, simulation.state, 1.0, False, workspace)
    return step, step.evaluate(step.at_rest()), workspace


def test_lost_contact_is_named_as_the_cause():
    """Without inertia, and only where no body has contact; round-off of the stiffness is then no cause."""
    step, evaluation, workspace = started(rest_on=0.1)
    causes = probable_causes(step, evaluation)
    assert causes[0].startswith("No corner of the soil touches body any more") and "body.rest_on" in causes[0]
    assert "time.inertia = true" in causes[0] and not any("round-off" in cause for cause in causes)
    outcome = SimpleNamespace(evaluation=evaluation, reason="residual 1.00e+00 after 15 iterations", errors=(1.0, 1.0))
    text = advice(step, outcome, Solver())
    assert text.startswith("No corner") and "Otherwise use a smaller time.step with more stage.steps" in text
    assert "time.accuracy" not in text and text.endswith("where the load exceeds what the soil can carry")
    workspace.destroy()
    step, evaluation, workspace = started(rest_on=-0.004)
    assert not any("No corner" in cause for cause in probable_causes(step, evaluation))
    workspace.destroy()
