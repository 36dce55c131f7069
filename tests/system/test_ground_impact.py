"""A ball that falls on held ground: its bounces cost energy in long steps, which is reported, with the sum at the end, and
hardly any in short ones."""

import io
import json
from dataclasses import replace

import numpy as np
import pytest

from hybrid.output.progress import Progress
from hybrid.output.summary import Summary
from hybrid.scene import Axis, Time
from hybrid.scheme import Scheme
from hybrid.setup.build import build
from hybrid.step import increments
from hybrid.study.scenes import box, plane, soil_scene, sphere


def dropped(step, steps):
    """A ball of 47 kg, 0.05 m above the ground."""
    return build(plane(sphere(0.21, 0.06, name="ball", rest_on=0.05), steps, step, stiffness=2e9, gravity=(0.0, 0.0, -9.81)))


def test_bounces_in_long_steps_are_told_with_their_sum_at_the_end(tmp_path):
    simulation, stream = dropped(2e-3, 200), io.StringIO()
    simulation.run([Summary(tmp_path), Progress(stream)])
    summary = json.loads((tmp_path / "summary.json").read_text())
    lines = [line for line in stream.getvalue().splitlines() if "impact on held ground" in line]
    note, = [note for note in summary["notes"] if "impact on held ground" in note]
    assert len(lines) == 2 and lines[1] == f"at the end: {note}" and lines[0] != note
    lost = [float(line.split("(")[1].split("%")[0]) for line in lines]
    assert 12 < lost[0] < lost[1] <= 100


@pytest.mark.parametrize("step, steps, told", [(2e-3, 120, True), (2e-4, 100, False)])
def test_a_bounce_on_elastic_soil_is_told_where_its_steps_are_too_long(step, steps, told):
    """A quarter of a steel ball on rock: 40 % of its energy are lost in steps of 2 ms, 2 % in 0.2 ms."""
    side = Axis(start=0.0, end=0.8, size=0.2)
    ball = sphere(0.3, 0.1, density=7800.0, held=("x", "y", "rx", "ry", "rz"),
                  rest_on=0.2 if told else 0.005, velocity=(0.0, 0.0, 0.0 if told else -2.0))
    described = soil_scene([ball], x=side, y=side, z=(-0.8, 0.2), young=1e10, poisson=0.2, steps=steps,
                           time=Time(step=step), gravity=(0.0, 0.0, -9.81))
    notes = [note for record in build(described).steps() for note in record.notes if "impact on elastic soil" in note]
    assert len(notes) == told


def test_bounces_in_short_steps_are_not():
    simulation = dropped(2e-4, 625)
    kinetic = [0.5 * simulation.masses[0].mass * record.bodies[0].velocity[2] ** 2
               for record in simulation.steps() if not record.notes]
    assert len(kinetic) == 625 and not simulation.later_notes
    assert kinetic[-1] < max(kinetic) and max(kinetic) == pytest.approx(simulation.masses[0].mass * 9.81 * 0.05, rel=0.02)


def leaves(start, long=10.0, others=()):
    """Speed with which a box of 720 kg bounces off held ground that it reaches with 1 m/s, a share `start` of a step after
    the start, in steps `long` times the time of contact; others: bodies beside it."""
    step = long * np.pi * np.sqrt(720.0 / (1e6 * 1.2**2))
    thrown = box(1.2, 1.2, 0.5, rest_on=start * step, velocity=(0.0, 0.0, -1.0), penalty=1.0)
    described = plane(thrown, 7, step, stiffness=1e6, cells=(4, 4))
    simulation = build(replace(described, bodies=(*described.bodies, *others)))
    *_, last = simulation.steps()
    return last.bodies[0].velocity[2]


@pytest.mark.parametrize("start", [0.1, 0.5, 0.9])
def test_no_body_leaves_the_ground_faster_than_it_came(start, monkeypatch):
    """In steps longer than the contact, of which that of the impact is halved: half of the impulse counts with the length
    of the increment after it, and all of it is given over some increments."""
    assert 0.5 < leaves(start) <= 1.0
    monkeypatch.setattr(increments, "in_impact", lambda step, evaluation: False)
    assert leaves(start) > 1.05
    monkeypatch.setattr(Scheme, "following", lambda scheme, second, algorithmic, ratio: algorithmic)
    assert leaves(start) > 1.5


def test_a_fast_body_does_not_hide_an_impulse_on_a_slow_one():
    bullet = box(0.1, 0.1, 0.1, name="bullet", position=(0.0, 0.0, 50.0), velocity=(0.0, 0.0, 500.0))
    assert 0.5 < leaves(0.5, others=(bullet,)) <= 1.0
