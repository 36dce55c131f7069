"""Waves that come back from the sides of the soil while a body swings."""

import numpy as np
import pytest
from limit_texts import limit_texts

from hybrid.monitors.limits import LIMITS, waves
from hybrid.scene import Axis, Load, Motion, Stage, Time
from hybrid.study.scenes import box, collapsed, soil_scene


def texts(periods=4.0, wide=3.0, height=0.0, load=True, steps=100, time=(), **soil):
    """Of a strip of 0.4 m on ground 2 · `wide` m wide, in which a compression wave goes 23.6 m/s, shaken for a second."""
    times = np.linspace(0.0, 1.0, 201)
    swing = 10.0 * np.sin(2.0 * np.pi * periods * times)
    force = tuple((float(t), 0.0, 0.0, float(f)) for t, f in zip(times, swing))
    rate = tuple((float(t), float(f)) for t, f in zip(times, 1e-3 * swing))
    strip = box(0.4, 1.0, 0.2, name="strip", position=(0.0, 0.5, 0.1 + height))
    stage = Stage("shake", steps, loads=(Load(force=force),)) if load else Stage(
        "shake", steps, motions=(Motion(component="z", velocity=rate),))
    scene = soil_scene([strip], x=Axis(-wide, wide, 0.2), y=collapsed(), z=Axis(-2.0, 0.4, 0.2), young=1e6, poisson=0.0,
                       time=Time(1.0 / steps, **dict(time)), gravity=(0.0, 0.0, -9.81), **soil)
    return limit_texts(waves.returning_waves, scene.__class__(**{**vars(scene), "stages": (stage,)}))


@pytest.mark.parametrize("load", [True, False])
def test_a_body_that_swings_until_its_waves_are_back_is_told_when_they_are(load):
    text, = texts(load=load)
    assert text.startswith("strip swings for 1 s, and its waves come back from the end of the soil at x = -3 m after 0.24 s")
    assert "give the soil 11.8 m on each side" in text


@pytest.mark.parametrize("given", [{"periods": 0.5}, {"wide": 13.0}, {"height": 3.0}, {"wide": 0.2},
                                   {"wide": 0.8, "periods": 3.0},
                                   {"time": {"inertia": False}}, {"held": True}])
def test_others_are_not(given):
    """A load that does not swing; ends far away; a body in the air; a column; slow beside the way; no inertia; held
    ground."""
    assert not texts(**given)


def test_check_and_runs_ask_for_it():
    assert waves.returning_waves in LIMITS
