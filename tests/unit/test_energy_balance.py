"""The monitor of the energy balance: a warning has value, limit and a remedy that fits the scene."""

from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.monitors import StepView
from hybrid.monitors.energy_balance import EnergyBalance


def model(bodies=(), gravity=0.0):
    """Model on cells of 0.1 m."""
    return SimpleNamespace(bodies=bodies, loads=SimpleNamespace(gravity=np.array([0.0, 0.0, -gravity])),
                           soil=SimpleNamespace(grid=SimpleNamespace(smallest_cell=0.1)))


def balance(errors, stored=100.0, bodies=(), inertia=True, damps=False, accuracy=None, plastic=0.0, weight=0.0,
            drive=0.0, pressed=0.0, joints=(), touches=True):
    """Notes of steps with these errors [J] of the balance."""
    heavy = SimpleNamespace(mass=SimpleNamespace(mass=weight / 10.0))
    monitor = EnergyBalance(model((heavy,), 10.0), None)
    view = {"model": SimpleNamespace(bodies=bodies, joints=joints, soil=SimpleNamespace(held=False)),
            "scheme": SimpleNamespace(inertia=inertia, damps=damps, first_order=damps),
            "report": SimpleNamespace(error=accuracy, evaluation=SimpleNamespace(
                pairs=SimpleNamespace(energy=pressed), contacts=Contacts(touches) if bodies else []))}
    kinetic = np.broadcast_to(stored, len(errors))
    rest = {"elastic": 0.0, "contact": 0.0, "plastic": plastic, "drive": drive}
    return [note for time, error in enumerate(errors) for note in monitor.notes(StepView(
        state=SimpleNamespace(time=time), energy={"kinetic": kinetic[time], "error": error, **rest}, **view))]


def test_energy_within_its_limits_gives_no_note():
    assert balance([0.0, 24.0, -25.0, 0.0]) == [] and balance([0.0, 0.0], stored=0.0) == []


def test_a_gain_while_a_motion_begins_counts_only_once_the_energy_has_a_scale():
    """A block starts to slide: what contact stores in the first step is lost in the energy of the third. One that stays
    is reported."""
    sliding = [0.5 * step**2 for step in range(1, 8)]
    assert balance([0.25] * 7, sliding) == []
    text, = balance([0.5 * energy for energy in sliding], sliding)
    assert "gain of 9 J since t = 0 s (50%" in text     # in the first step whose energy grows by less than half
    text, = balance([0.5 * 2.0**step for step in range(7)], [2.0**step for step in range(7)])
    assert "gain of 16 J since t = 0 s" in text         # an energy that goes on doubling excuses nothing


def test_what_lifts_the_bodies_by_less_than_a_hundredth_of_a_cell_is_no_scale():
    """A body of 1 kN comes to rest in springs that take 0.3 J; to lift it by 1 mm takes 1 J."""
    for errors in ([0.2] * 9, [0.0, -0.45, -0.45]):
        assert len(balance(errors, stored=0.5)) == 1 and balance(errors, stored=0.5, weight=1e3) == []
    assert len(balance([0.2] * 9, stored=0.5, weight=1e2)) == 1


def test_what_quasi_static_soil_dissipates_is_part_of_the_scale():
    """Clay that flows stores hardly anything; a gain in a run with inertia is not excused by what impacts dissipate."""
    assert balance([0.0, 30.0], inertia=False, plastic=900.0) == []
    assert len(balance([0.0, *[30.0] * 3], inertia=False)) == len(balance([0.0, 30.0], plastic=900.0)) == 1


def test_a_gain_is_compared_with_the_work_from_outside_as_well():
    """A blade drawn slowly through sand stored 5 J of 2.3 kJ of work, and gained 3.7 J."""
    assert balance([0.0, 30.0], drive=2e3) == [] and len(balance([0.0, 30.0], drive=-1e3)) == 1


def test_a_gain_without_inertia_has_to_last():
    """Where guides take hold of a body, what they do and what friction takes are not of the same step."""
    assert balance([0.0, 30.0, 30.0, 20.0, 30.0, 30.0], inertia=False) == []


def test_a_gain_of_round_off_where_nothing_has_happened_is_none():
    assert balance([0.0, 0.0, *[2.6e-22] * 5], stored=2.6e-22) == []


def test_a_loss_is_never_more_than_all_of_the_energy():
    """What gravity brings within a step is not in the energy before it."""
    text, = balance([0.0, -130.0])
    assert "loss of 130 J" in text and "(100% of" in text


def test_a_first_step_that_holds_the_impact_loses_no_more_than_all():
    body = SimpleNamespace(mass=SimpleNamespace(mass=2.0, inertia=np.eye(3)))
    motion = SimpleNamespace(velocity=np.array([0.0, 0.0, -10.0]), spin=np.zeros(3), rotation=np.eye(3))
    monitor = EnergyBalance(model((body,)), SimpleNamespace(bodies=(motion,)))
    described = SimpleNamespace(bodies=(body,), joints=(), soil=SimpleNamespace(held=True))
    view = StepView(described, SimpleNamespace(time=0.1),
                    SimpleNamespace(inertia=True, damps=True, first_order=False),
                    SimpleNamespace(error=None, evaluation=SimpleNamespace(pairs=None, contacts=[])),
                    {"kinetic": 1.0, "elastic": 0.0, "contact": 0.0, "error": -60.0})
    text, = monitor.notes(view)
    assert "loss of 60 J" in text and "(100% of" in text and "the motion of the bodies; use" in text


def test_a_gain_and_a_loss_are_reported_once_each():
    gain, loss = balance([0.0, 30.0, 40.0, -20.0, -80.0])
    assert gain.startswith("energy balance: unaccounted gain of 30 J since t = 1 s (30% of the largest") and "25%" in gain
    assert loss.startswith("energy balance: unaccounted loss of 60 J in the step to t = 3 s (60% of") and "50%" in loss
    assert balance([0.0, -80.0], damps=True) == [] == balance([0.0, -80.0], inertia=False)
    assert balance([0.0, -80.0], pressed=1.0) == []     # by bodies that still press one another


class Contacts:
    """Contact of a body, which has some where `touches`; "once": where it is asked for the first time."""

    def __init__(self, touches):
        self.touches = touches

    def __iter__(self):
        yield [1] if self.touches else []
        self.touches = self.touches and self.touches != "once"


FREE, DRIVEN = SimpleNamespace(guides=()), SimpleNamespace(guides=(1,))


@pytest.mark.parametrize("scene, present, absent", [
    ({"bodies": (FREE,)}, ["time.accuracy = 1e-3", "body.penalty", "damps"], ["stage.steps"]),
    ({"bodies": (FREE,), "touches": "once"}, ["body.penalty", "Contact"], []),
    ({"bodies": (FREE,), "touches": False}, ["motion of the bodies"], ["body.penalty", "Contact"]),
    ({"bodies": (FREE, DRIVEN), "joints": (1,)}, ["a driven velocity that grows"], []),
    ({"bodies": (FREE, FREE), "joints": (1,)}, ["a smaller time.step"], ["a driven velocity"]),
    ({"bodies": (FREE, DRIVEN)}, ["a smaller time.step"], ["a driven velocity"]),
    ({}, ["a smaller time.step", "damps"], ["body.penalty", "Contact"]),
    ({"accuracy": 1e-5}, ["a smaller time.accuracy"], ["time.accuracy ="]),
    ({"damps": True}, ["a smaller time.step"], ["time.scheme"]),
    ({"inertia": False, "bodies": (1,)}, ["stage.steps"], ["time.accuracy", "time.step", "damps"])])
def test_remedies_of_a_gain_fit_the_scene(scene, present, absent):
    text, = balance([0.0, *[50.0] * 3], **scene)
    assert all(words in text for words in present) and not any(words in text for words in absent)
