"""An impact within one step of undamped Newmark gains energy without a cause: reported once, with remedies."""

import pytest

from hybrid.scene import Solver, Time
from hybrid.setup.build import build
from hybrid.study.scenes import box, plane, soil_scene, steel


def thrown(step, penalty=None, **time):
    """Records of 0.12 s of a plate of 40 mm thrown at elastic soil at 5 m/s."""
    plate = steel(0.5, 0.5, 0.04, rest_on=0.01, position=(0.4, 0.4, 0.0), velocity=(0.0, 0.0, -5.0), size=0.25,
                  penalty=penalty)
    return list(build(soil_scene([plate], z=(-0.8, 0.6), young=5e6, poisson=0.2, time=Time(step=step, **time),
                                 steps=round(0.12 / step), solver=Solver(tolerance=1e-4))).steps())


def notes(records):
    return [note for record in records for note in record.notes if "unaccounted gain" in note]


def test_an_impact_in_one_step_gains_energy_and_is_reported():
    """Thrown back at 4.4 m/s, faster than an elastic impact in this soil allows; 0.45 kJ too many. Only once, though the
    energy stays."""
    records = thrown(0.03, scheme="newmark")
    assert records[-1].bodies[0].velocity[2] > 4.0 and records[-1].energies["error"] > 400.0
    text, = notes(records)
    assert "t = 0.03 s" in text and "limit 25%" in text and "smaller time.step" in text


@pytest.mark.parametrize("time", [
    {"step": 0.001, "scheme": "newmark", "penalty": 50.0}, {"step": 0.03}, {"step": 0.03, "beta": 0.5625, "gamma": 1.0}])
def test_each_remedy_stops_the_gain(time):
    """A step that resolves the contact; a scheme that damps. Both lose energy instead, at most what came in."""
    records = thrown(**time)
    assert records[-1].bodies[0].velocity[2] < 5.0 and not notes(records)


def test_a_body_that_starts_in_the_soil_a_little_brings_the_energy_of_its_springs():
    """½ p_f E A δ² at the start, so that the balance closes."""
    body = box(1.0, 1.0, 0.25, rest_on=-1e-3, penalty=1.0)
    records = list(build(plane(body, 3, 0.002, cells=(8, 8), gravity=(0.0, 0.0, -9.81),
                         time={"scheme": "newmark"})).steps())
    assert abs(records[-1].energies["error"]) < 0.02 * 0.5 * 1e6 * 1e-3**2 and not notes(records)


@pytest.mark.parametrize("time, reported", [({"scheme": "newmark"}, True), ({"beta": 0.5625, "gamma": 1.0}, False)])
def test_an_impact_in_one_step_that_loses_energy_is_reported_unless_the_scheme_damps(time, reported):
    """A box that comes to a plane in the middle of a step ten times as long as its contact keeps half of its speed."""
    body = box(1.2, 1.2, 0.5, rest_on=0.2, velocity=(0.0, 0.0, -1.0), penalty=1.0, contact="corners")
    records = list(build(plane(body, 6, 0.7, time=time)).steps())
    texts = [note for record in records for note in record.notes if "unaccounted loss" in note]
    assert records[-1].bodies[0].velocity[2] < 0.8 and len(texts) == reported
    assert all("t = 0.7 s" in text and "limit 50%" in text and "time.accuracy = 1e-3" in text for text in texts)
