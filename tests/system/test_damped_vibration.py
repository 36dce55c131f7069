"""A column of soil under sudden gravity swings; the default scheme damps it unless steps are short."""

import re
from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.monitors import StepView
from hybrid.monitors.damped_vibration import WORKS, DampedVibration, lost_by
from hybrid.scene import Axis, Faces, Grid, Material, Motion, Scene, Soil, Stage, Time
from hybrid.scheme import Scheme
from hybrid.setup.build import build
from hybrid.study.scenes import NO_OUTPUT, box

PERIOD = 0.0975     # [s]


def notes(steps_in_a_period, periods=3.0, **time):
    """About damping, of a column that swings for some periods."""
    side = Axis(0.0, 0.25, 0.25)
    scene = Scene(name="column", grid=Grid(side, side, Axis(0.0, 2.25, 0.25), Faces(z_min="fixed")),
                  soil=Soil(Material(law="hencky", young=1e7, poisson=0.3, density=2000.0), top=2.0, geostatic=False),
                  time=Time(PERIOD / steps_in_a_period, **time), output=NO_OUTPUT,
                  stages=(Stage("swing", round(periods * steps_in_a_period)),))
    return [text for record in build(scene).steps() for text in record.notes if "damps a vibration" in text]


def test_what_the_default_scheme_takes_from_a_vibration_is_told_once():
    text, = notes(16)
    assert "17 steps in a period" in text and "12% of its swing in each, limit 10%" in text


@pytest.mark.parametrize("steps, lost", [(9, 34), (6, 56)])
def test_a_vibration_that_few_steps_resolve_is_told_too(steps, lost):
    text, = notes(steps, periods=6.0)
    assert int(re.search(r"it loses (\d+)% of its swing", text)[1]) == pytest.approx(lost, abs=8)


@pytest.mark.parametrize("steps, time", [
    (24, {}), (16, {"spectral_radius": 0.8}), (16, {"scheme": "newmark"}), (1.5, {}), (16, {"beta": 0.5625, "gamma": 1.0})],
    ids=["short steps", "hardly damped", "undamped", "not resolved", "meant to"])
def test_others_are_not(steps, time):
    assert not notes(steps, **time)


@pytest.mark.parametrize("steps, lost", [(6.8, 0.67), (12, 0.25), (16, 0.12), (32, 0.02)])
def test_what_the_scheme_takes_is_that_of_an_oscillator(steps, lost):
    """As the column loses; undamped schemes take nothing."""
    assert lost_by(Scheme.generalised_alpha(0.0), steps) == pytest.approx(lost, rel=0.2)
    assert lost_by(Scheme.newmark(0.25, 0.5), steps) == pytest.approx(0.0, abs=1e-12)


def test_a_block_that_bounces_is_not():
    """Contact that opens and closes takes what it loses."""
    block = box(0.5, 0.5, 0.25, position=(0.25, 0.25, 0.0), rest_on=1.05, held=("x", "y", "rx", "ry", "rz"))
    side = Axis(0.0, 0.5, 0.25)
    scene = Scene(name="bounce", grid=Grid(side, side, Axis(0.0, 1.5, 0.25), Faces(z_min="fixed")), bodies=(block,),
                  soil=Soil(Material(law="hencky", young=5e6, poisson=0.3, density=2000.0), top=1.0), time=Time(0.004),
                  stages=(Stage("fall", 150),), output=NO_OUTPUT)
    assert not [text for record in build(scene).steps() for text in record.notes if "damps a vibration" in text]


def test_a_vibration_that_is_forced_is_not():
    """A block that is driven up and down on elastic soil."""
    side = Axis(0.0, 0.5, 0.25)
    block = box(0.5, 0.5, 0.25, position=(0.25, 0.25, 0.0), rest_on=1.0, held=("x", "y", "rx", "ry", "rz"), tension="full")
    times = np.arange(0.0, 6.01, 0.05)
    shake = Motion(component="z", displacement=tuple(zip(times, 1e-3 * np.sin(2 * np.pi * times))))
    scene = Scene(name="shaker", grid=Grid(side, side, Axis(0.0, 1.5, 0.25), Faces(z_min="fixed")), bodies=(block,),
                  soil=Soil(Material(law="hencky", young=1e6, poisson=0.3, density=2000.0), top=1.0), time=Time(0.05),
                  stages=(Stage("shake", 120, motions=(shake,)),), output=NO_OUTPUT)
    assert not [text for record in build(scene).steps() for text in record.notes if "damps a vibration" in text]


def test_soil_that_does_not_swing_is_not():
    """At rest from the start."""
    side = Axis(0.0, 0.5, 0.25)
    scene = Scene(name="rest", grid=Grid(side, side, Axis(0.0, 1.25, 0.25), Faces(z_min="fixed")),
                  soil=Soil(Material(law="hencky", young=1e7, poisson=0.3, density=2000.0), top=1.0), time=Time(0.006),
                  stages=(Stage("rest", 60),), output=NO_OUTPUT)
    notes = [text for record in build(scene).steps() for text in record.notes]
    assert all("between rollers" in text for text in notes)


def made_up(loss=0.11, spent=0.0, elastic=0.0, touching=(1,) * 60, peaks=(4, 12, 20, 28, 36)):
    """Notes of steps with maxima of the kinetic energy, 1 J, at `peaks`; from one to the next the balance lacks `loss` [J],
    and `spent` [J] are dissipated in a step; touching: bodies that touch the soil."""
    soil = SimpleNamespace(held=False)
    monitor, found = DampedVibration(None, None), []
    for n in range(40):
        kinetic = np.exp(-0.5 * min(abs(n - p) for p in peaks))
        energy = {"kinetic": kinetic, "error": -loss * sum(p <= n for p in peaks), **dict.fromkeys(WORKS, 0.0),
                  "elastic": elastic,
                  "plastic": spent * n}
        report = SimpleNamespace(evaluation=SimpleNamespace(contacts=[[0]] * touching[n]))
        view = StepView(SimpleNamespace(soil=soil), SimpleNamespace(step=n, time=0.1 * n), Scheme.generalised_alpha(0.0),
                        report, energy)
        found += monitor.notes(view)
    return found


@pytest.mark.parametrize("steps", [
    {"loss": 0.3}, {"loss": 0.05}, {"spent": 0.1}, {"touching": (1, 1, 1, 1, 1, 1, 1, 1, 1, 0) * 4},
    {"peaks": (4, 10, 26, 32, 38)}, {"elastic": 2e5}],
    ids=["more than the scheme takes", "less", "soil that yields", "bounces", "not regular", "faint"])
def test_each_sign_of_something_else_is_heeded(steps):
    assert len(made_up()) == 1 and not made_up(**steps)
