"""A ball that falls on held ground: its bounces cost energy in long steps, which is reported, with the sum at the end, and
hardly any in short ones."""

import io
import json

import pytest

from hybrid.output.progress import Progress
from hybrid.output.summary import Summary
from hybrid.setup.build import build
from hybrid.study.scenes import plane, sphere


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


def test_bounces_in_short_steps_are_not():
    simulation = dropped(2e-4, 625)
    kinetic = [0.5 * simulation.masses[0].mass * record.bodies[0].velocity[2] ** 2
               for record in simulation.steps() if not record.notes]
    assert len(kinetic) == 625 and not simulation.later_notes
    assert kinetic[-1] < max(kinetic) and max(kinetic) == pytest.approx(simulation.masses[0].mass * 9.81 * 0.05, rel=0.02)
