"""The monitor of impacts between bodies: what is lost over some steps is reported, and what is held back for a while is not."""

from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.monitors import StepView
from hybrid.monitors.body_impact import QUIET, BodyImpact


def notes(errors, struck=(), near=(), touching=0, pairs=1, accuracy=None, **scheme):
    """Of steps with these errors [J] of a body of 2 kg with 10 m/s, 100 J; struck, near: steps at whose ends bodies press, or are near one
    another; touching: number of contacts with the soil."""
    body = SimpleNamespace(mass=SimpleNamespace(mass=2.0, inertia=np.eye(3)))
    motion = SimpleNamespace(velocity=np.array([10.0, 0.0, 0.0]), spin=np.zeros(3), rotation=np.eye(3))
    monitor, found = BodyImpact(None, None), []
    for step, error in enumerate(errors):
        of_pairs = SimpleNamespace(energy=1.0 * (step in struck), contacts=(None,) * (step in struck or step in near))
        report = SimpleNamespace(error=accuracy, evaluation=SimpleNamespace(contacts=(range(touching),), pairs=of_pairs))
        found += monitor.notes(StepView(
            model=SimpleNamespace(bodies=(body,), pairs=(None,) * pairs), state=SimpleNamespace(time=float(step), bodies=(motion,)),
            scheme=SimpleNamespace(**{"inertia": True, "first_order": False} | scheme), report=report, energy={"error": error}))
    return found


AFTER = [-13.0] * (QUIET + 1)


def test_an_impact_within_a_step_or_over_some_is_reported_once():
    for errors, struck in (([0.0, 0.0, *AFTER, *AFTER], ()), ([0.0, -4.0, -9.0, *AFTER], (1, 2))):
        text, = notes(errors, struck, near=(0, 1, 2))
        assert "13 J of the 100 J" in text and "(13%, limit 12%)" in text and "smaller time.step" in text and "time.accuracy = 1e-4" in text
    assert "a smaller time.accuracy" in notes([0.0, 0.0, *AFTER], near=(0, 1, 2), accuracy=1e-6)[0]


def test_energy_that_the_scheme_holds_back_is_not_lost():
    assert notes([0.0, -40.0, -30.0, *[-8.0] * 8], struck=(1,)) == []
    assert notes([0.0, *[-40.0] * 10], struck=range(11)) == []      # still pressed together


def test_losses_of_two_impacts_add_up_while_bodies_stay_near_and_not_when_they_were_apart():
    first, second = [0.0, *[-8.0] * 8], [-16.0] * 8
    assert len(notes(first + second, near=range(17))) == 1
    assert notes(first + second, near=(1, 9)) == []


@pytest.mark.parametrize("other", [{"touching": 3}, {"pairs": 0}, {"first_order": True}, {"inertia": False}])
def test_other_losses_are_no_impact_of_bodies(other):
    """On soil, without bodies that may touch, by schemes that are meant to damp, without inertia."""
    assert notes([0.0, 0.0, *AFTER], near=(1,), **other) == []
