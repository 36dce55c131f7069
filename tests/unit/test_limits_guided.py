"""Loads on held components and motions out of a plane of symmetry, which nothing shows in a result, are reported before the
run."""

import re
from dataclasses import replace

import pytest
from limit_texts import limit_texts

from hybrid.monitors.limits.guided import driven_into_held_ground, moving_halves, swallowed_loads, swallowed_pulls
from hybrid.scene import Axis, Load, Motion, Pull, Stage
from hybrid.setup.build import build
from hybrid.study.scenes import box, collapsed, soil_scene


def texts(limit, load=None, motion=None, y=None, stage=(), **body):
    """Texts about a cube of 0.2 m whose middle is in the end of a grid at x = 0."""
    cube = box(0.2, 0.2, 0.2, name="cube", **{"position": (0.0, 0.4, 0.0), "rest_on": 0.0} | body)
    stages = (replace(Stage("go", 2, loads=(load,) if load else (), motions=(motion,) if motion else ()), **dict(stage)),)
    return limit_texts(limit, replace(soil_scene([cube], **({"y": y} if y else {})), stages=stages))


@pytest.mark.parametrize("load, words", [
    (Load(force=((0.0, 0.0, 0.0, 0.0), (1.0, 5e3, 0.0, -15e3))),
     "fx = 5 kN acts on x, held, as the model is symmetric about x = 0 m"),
    (Load(moment=(0.0, -40.0, 0.0)), "my = -40 N m acts on ry, held, as the model is symmetric"),
    (Load(force=(0.0, 0.0, -100.0), point=(0.05, 0.0, 0.0)),
     "the moment my = 5 N m of the force at its point acts on ry, held, as"),
])
def test_loads_that_a_plane_of_symmetry_carries_are_reported(load, words):
    text, = texts(swallowed_loads, load)
    assert text.startswith(f"stage.0.load.0 on cube: {words}") and "the body does not feel it" in text
    assert "Model the whole body" in text


@pytest.mark.parametrize("load", [
    Load(force=(0.0, 20.0, -100.0)), Load(moment=(40.0, 0.0, 0.0)), Load(force=(0.0, 0.0, -100.0), point=(0.0, 0.05, 0.1)),
    Load(force=(0.01, 0.0, -100.0), point=(0.001, 0.0, 0.0))])
def test_loads_in_the_plane_are_not(load):
    assert not texts(swallowed_loads, load)


@pytest.mark.parametrize("point, reported", [(None, False), ((0.0, 0.0, 0.0), False), ((0.09, 0.0, 0.0), True)])
def test_half_of_a_load_on_a_half_body_may_act_in_the_plane_or_at_its_centre(point, reported):
    assert bool(texts(swallowed_loads, Load(force=(0.0, 0.0, -100.0), point=point), symmetry="x")) == reported


@pytest.mark.parametrize("values, words", [
    ({"held": ("z",)}, "acts on z, held: .* Release it"), ({"driven": ("z",), "velocity": (0.0, 0.0, -0.1)},
                                                           "acts on z, driven: .* do not drive it"),
    ({"stage": {"held": ("z",)}}, "acts on z, held:"), ({"motion": Motion(component="z", velocity=-0.1)},
                                                        "acts on z, driven:"),
    ({"y": collapsed(0.2), "position": (0.3, 0.1, 0.0), "load": Load(force=(0.0, 5.0, -5.0))},
     "acts on y, held across the collapsed axis y"),
])
def test_loads_on_components_that_are_held_or_driven_are_reported(values, words):
    text, = texts(swallowed_loads, **{"load": Load(force=(0.0, 0.0, -5.0)), "position": (0.4, 0.4, 0.0)} | values)
    assert re.search(words, text), text


def test_a_pull_line_across_the_plane_is_told_and_one_in_it_is_not():
    across, along = (Pull((0.0, 0.0, 0.0), travel, 1e6, 10.0) for travel in ((1.0, 1.0, 0.0), (0.0, 1.0, 0.0)))
    text, = texts(swallowed_pulls, pull=across)
    assert text.startswith("body.0.pull of cube leads along x, held, as the model is symmetric about x = 0 m")
    assert not texts(swallowed_pulls, pull=along)


def test_a_half_that_moves_out_of_its_plane_is_reported():
    text, = texts(moving_halves, motion=Motion(component="x", velocity=0.1))
    assert text.startswith("cube lies across x = 0 m, the end of the grid") and "moves in x" in text
    assert "Extend the grid" in text
    assert "moves in ry" in texts(moving_halves, spin=(0.0, 1.0, 0.0))[0]
    assert not texts(moving_halves, motion=Motion(component="z", velocity=-0.1))
    assert not texts(moving_halves, motion=Motion(component="x", velocity=0.1), position=(0.4, 0.4, 0.0))


def test_half_models_of_a_body_on_an_axis_at_the_other_end_are_seen_too():
    cube = box(0.2, 0.2, 0.2, name="cube", position=(0.8, 0.4, 0.0), rest_on=0.0, velocity=(0.1, 0.0, 0.0))
    simulation = build(soil_scene([cube], x=Axis(0.0, 0.8, 0.2)))
    assert "x = 0.8 m" in list(moving_halves(simulation.scene, simulation.model))[0]


@pytest.mark.parametrize("velocity, held, ground, count", [
    (-0.01, True, {}, 1), (-0.01, False, {}, 0), (0.01, True, {}, 0), (0.0, True, {}, 0),
    (-0.01, True, {"top": 0.2, "ground": ((0.0, -0.2), (0.8, -0.2))}, 0),
    (-0.01, True, {"top": 0.2, "ground": ((0.0, 0.0), (0.8, 0.0))}, 1)])
def test_a_body_driven_into_ground_that_does_not_deform_is_reported(velocity, held, ground, count):
    """Not one that is driven through the air above it."""
    cube = box(0.2, 0.2, 0.2, name="cube", position=(0.4, 0.4, 0.1), driven=("z",), velocity=(0.0, 0.0, velocity))
    described = soil_scene([cube], held=held)
    simulation = build(replace(described, soil=replace(described.soil, **ground)))
    found = list(driven_into_held_ground(simulation.scene, simulation.model))
    assert len(found) == count and all("cube is driven" in text for text in found)
