"""A block that a turntable carries with it by friction."""

from dataclasses import replace

import pytest

from hybrid.scene import Motion, Stage
from hybrid.setup.build import build
from hybrid.step import sticking
from hybrid.study.scenes import box, plane


def carried_round(steps=8):
    """Newton iterations of each step of a block that a turntable carries with it, and the last record."""
    table = box(2.4, 2.4, 0.2, name="table", position=(0.0, 0.0, 0.6), held=("x", "y", "z", "rx", "ry"), friction=0.4)
    block = box(0.3, 0.3, 0.1, name="block", position=(1.0, 0.0, 0.75), friction=0.4)
    turn = Motion(body="table", component="rz", velocity=((0.0, 0.0), (5.0, 2.5)))
    scene = replace(plane(table, 1, 0.01, gravity=(0.0, 0.0, -9.81)), bodies=(table, block),
                    stages=(Stage("turn", steps, motions=(turn,)),))
    records = list(build(scene).steps())
    return [record.iterations for record in records], records[-1]


def test_places_that_slip_to_and_fro_are_held_in_stick(monkeypatch):
    """As those of soil are; else each update carries the block from slip to slip the other way, in ever shorter steps."""
    iterations, last = carried_round()
    assert max(iterations) <= 6 and last.increments == 1
    assert last.bodies[1].position[1] == pytest.approx(0.25 * last.time**2, rel=0.1)
    monkeypatch.setattr(sticking, "_sides", lambda evaluation: [])
    assert sum(carried_round()[0]) > 2.5 * sum(iterations)
