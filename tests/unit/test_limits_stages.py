"""Limits of stages: driven bodies that move too far in a step, loads that never reach their last row."""

import re
from dataclasses import replace

import numpy as np
import pytest
from limit_texts import limit_texts

from hybrid.monitors.limits.stages import coarse_swings, early_rows, long_increments, missed_changes, unreached_ends
from hybrid.scene import Load, Material, Motion, Stage, Time
from hybrid.setup.build import build
from hybrid.study.scenes import box, soil_scene


def texts(limit, stage=(), time=(), soil=(), yields=True, **body):
    """Texts of a limit about a box on clay, or elastic soil, with cells of 0.2 m, in ten steps of 0.1 s."""
    cube = box(0.2, 0.2, 0.2, name="cube", position=(0.4, 0.4, 0.1), **body)
    stages = (replace(Stage("go", 10), **dict(stage)),)
    scene = replace(soil_scene([cube], time=Time(**{"step": 0.1, **dict(time)}), **dict(soil)), stages=stages)
    if yields:
        clay = Material(law="von-mises", young=1e6, poisson=0.3, density=1800.0, strength=1e4)
        scene = replace(scene, soil=replace(scene.soil, material=clay))
    return limit_texts(limit, scene)


DOWN = {"driven": ("z",), "velocity": (0.0, 0.0, -2.0)}


def test_a_body_driven_by_a_cell_a_step_is_told_with_the_step_that_is_short_enough():
    (text,) = texts(long_increments, **DOWN)
    assert text.startswith("cube is driven by 1 cells along z in each step of stage 'go', limit 0.5")
    assert "at most 0.05 s" in text
    (text,) = texts(long_increments, yields=False, **DOWN | {"velocity": (0.0, 0.0, -4.0)})
    assert "by 2 cells" in text and "limit 1:" in text


def test_accuracy_is_no_remedy_without_inertia():
    (dynamic,), (static,) = texts(long_increments, **DOWN), texts(long_increments, time={"inertia": False}, **DOWN)
    assert dynamic.endswith("or set time.accuracy") and "accuracy" not in static


@pytest.mark.parametrize("values", [
    {"velocity": (0.0, 0.0, -1.0)}, {"stage": {"step": 0.04}}, {"stage": {"held": ("z",)}}, {"time": {"accuracy": 1e-3}},
    {"soil": {"held": True}}, {"yields": False}, {"driven": ()},
    {"stage": {"motions": (Motion(component="z", velocity=-0.5),)}}])
def test_shorter_strides_and_those_that_do_no_harm_are_not(values):
    assert not texts(long_increments, **DOWN | values)


@pytest.mark.parametrize("motion", [
    {"velocity": ((0.0, 0.0), (0.5, 2.0), (1.0, 0.0))}, {"displacement": ((0.0, 0.0), (0.2, 0.4), (5.0, 0.4))}])
def test_tables_of_motions_count_with_their_fastest_step(motion):
    (text,) = texts(long_increments, {"motions": (Motion(component="x", **motion),)})
    assert "by 1 cells along x" in text


@pytest.mark.parametrize("end, told", [(1.004, 0), (1.006, 0), (1.011, 1), (1.4, 1)])
def test_a_table_may_end_half_a_step_after_its_stage(end, told):
    """Of 1 s in steps of 0.1 s: not by more than a hundredth of the stage."""
    load = Load(force=((0.0, 0.0, 0.0, 0.0), (end - 0.3, 0.0, 0.0, 0.0), (end, 500.0, 0.0, 0.0)))
    assert len(texts(unreached_ends, {"loads": (load,)})) == told


def test_a_load_that_ends_after_its_stage_is_told_with_what_it_reaches():
    load = Load(force=((0.0, 0.0, 0.0, 0.0), (10.0, 500.0, 0.0, 0.0)))
    (text,) = texts(unreached_ends, {"loads": (load,)})
    assert re.search(r"stage\.0\.load\.0\.force ends at 10 s, and its stage 'go' at 1 s: it reaches \(50, 0, 0\) N, "
                     r"not its last row, \(500, 0, 0\) N\..*stage\.0\.steps to 100", text)


@pytest.mark.parametrize("load", [
    Load(force=(1.0, 2.0, 3.0)), Load(moment=((0.0, 0.0, 0.0, 0.0), (1.0, 0.0, 1.0, 0.0))),
    Load(force=((0.0, 1.0, 0.0, 0.0), (0.5, 2.0, 0.0, 0.0), (9.0, 2.0, 0.0, 0.0)))])
def test_loads_that_reach_their_last_value_are_not(load):
    assert not texts(unreached_ends, {"loads": (load,)})


@pytest.mark.parametrize("motion, words", [
    (Motion(component="x", displacement=((0.0, 0.1), (100.0, 0.2))),
     r"displacement ends at 100 s, and its stage 'go' at 1 s: it reaches 0.001 m, not its last row, 0.1 m\. "
     r".*steps to 1000, or end"),
    (Motion(component="rx", velocity=((0.0, 0.0), (2.0, 1.0))),
     "velocity ends at 2 s, .* it reaches 0.5 rad/s, not its last row, 1 rad/s"),
    (Motion(component="x", displacement=((1.0, 0.0), (2.0, 0.2))),
     "it reaches 0 m, .* begin at 0, and not at 1 s, when the stage is over"),
])
def test_a_motion_that_ends_or_begins_after_its_stage_is_reported(motion, words):
    (text,) = texts(unreached_ends, {"motions": (motion,)})
    assert text.startswith("stage.0.motion.0.") and re.search(words, text), text


@pytest.mark.parametrize("rows, noted", [
    (((-0.5, 0.0), (1.0, 0.3)), True), (((-0.5, 0.0), (0.0, 0.0), (1.0, 0.3)), False), (((0.0, 0.0), (1.0, 0.3)), False)])
def test_rows_before_the_start_of_a_stage_are_reported(rows, noted):
    found = texts(early_rows, {"motions": (Motion(component="x", displacement=rows),)})
    assert bool(found) == noted
    assert not noted or "begins at -0.5 s, limit 0" in found[0] and "where it has 0.1 m already" in found[0]


@pytest.mark.parametrize("rows, given, told", [
    (((0.0, 0.0), (0.22, 0.0), (0.25, 50.0), (0.28, 0.0)), {}, "an impulse, in N s, of 0 there, and of 1.5 by its rows"),
    (((0.0, 0.0), (0.19, 0.0), (0.2, 50.0), (0.21, 0.0)), {}, "of 5 there, and of 0.5 by"),
    (((0.0, 50.0), (0.02, 0.0)), {}, "of 2.5 there, and of 0.5 by"),
    (((0.0, 0.0), (0.22, 0.0), (0.25, 50.0), (0.28, 0.0)), {"inertia": False}, "a peak, in N, of 0 there, and of 50 by"),
    (((0.0, 0.0), (0.5, 50.0), (1.0, 50.0)), {}, ""), (((0.0, 50.0), (1.0, 50.0)), {}, ""),
    (((0.0, 0.0), (0.25, 50.0), (1.0, 50.0)), {}, ""), (((0.0, 0.0), (0.25, 50.0), (1.0, 50.0)), {"inertia": False}, "")])
def test_loads_that_change_between_the_ends_of_steps_are_told(rows, given, told):
    """In ten steps of 0.1 s: pulses, a blast; not ramps."""
    found = texts(missed_changes, {"loads": (Load(force=tuple((t, f, 0.0, 0.0) for t, f in rows)),)}, time=given)
    assert len(found) == bool(told) and all(told in text for text in found)


@pytest.mark.parametrize("motion", [
    Motion(component="x", displacement=((0.0, 0.0), (1.0, 0.2))),
    Motion(component="x", velocity=((0.0, 0.1), (9.0, 0.1))), Motion(held=("x",)),
    Motion(component="x", displacement=((0.0, 0.3), (0.5, 0.2), (9.0, 0.2)))])
def test_motions_that_reach_their_last_value_are_not(motion):
    assert not texts(unreached_ends, {"motions": (motion,)})


def test_the_energy_of_soil_that_is_inside_out_gives_no_warning_of_numpy(recwarn):
    """The refusal of the next step tells of it; 50 Pa for 50 MPa did this."""
    simulation = build(soil_scene())
    points = replace(simulation.state.points, b_elastic=np.zeros_like(simulation.state.points.b_elastic))
    simulation.model.soil.stored_energy(points)
    assert not [warning for warning in recwarn if issubclass(warning.category, RuntimeWarning)]


@pytest.mark.parametrize("steps, told", [(16, "12.8%"), (24, "6.0%"), (32, "3.4%"), (40, "")])
def test_loads_that_swing_in_few_steps_are_told_by_how_much_heavier_masses_are(steps, told):
    """16 steps in a period: a free block moves by 12 % too little in 15.7 of them."""
    times = np.linspace(0.0, 10.0 * steps * 0.1 / 4, 2000)
    force = tuple((float(t), 1e3 * float(np.sin(2.0 * np.pi * t / (0.1 * steps))), 0.0, 0.0) for t in times)
    stage = {"loads": (Load(force=force),), "steps": int(2.5 * steps)}
    found = texts(coarse_swings, stage)
    assert len(found) == bool(told) and all(told in text and "spectral_radius" in text for text in found)
    assert not texts(coarse_swings, stage, time={"inertia": False})
    assert not texts(coarse_swings, {**stage, "loads": (Load(force=((0.0, 0.0, 0.0, 0.0), (1.0, 1e3, 0.0, 0.0))),)})


def test_a_swing_with_a_step_just_on_its_mean_counts_once():
    """A triangle of 32 steps in a period, from zero to zero."""
    turns = [(0.0, 0.0, 0.0, 0.0), *((3.2 * k + t, s * 1e3, 0.0, 0.0) for k in range(5) for t, s in ((0.8, 1), (2.4, -1)))]
    stage = {"loads": (Load(force=(*turns, (16.0, 0.0, 0.0, 0.0))),), "steps": 160}
    assert not texts(coarse_swings, stage)
