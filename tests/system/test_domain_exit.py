"""A body that leaves the grid: contact ends there, which is reported once, with a remedy."""

import io
import json

import pytest

from hybrid.output.progress import Progress
from hybrid.output.summary import Summary
from hybrid.scene import Axis
from hybrid.setup.build import build
from hybrid.study.scenes import driven, soil_scene, steel


def notes(bodies, steps=6, about="leaves the grid", **scene):
    """Notes [(step, text)] of a run over held soil, but that it was never touched; its grid is 0.8 m wide and ends 0.4 m
    above and below z = 0."""
    records = build(soil_scene(bodies, held=True, steps=steps, **scene)).steps()
    return [(record.step, note) for record in records for note in record.notes if about in note
            and "touches neither" not in note]


def flying(geometry, velocity, **body):
    """A cube of 0.2 m in the middle, 0.1 m above the soil, driven by 0.01 s velocity a step."""
    return driven(0.2, 0.2, 0.2, velocity=velocity, **{"position": (0.4, 0.4, 0.2), **body})


@pytest.mark.parametrize("velocity, axis, side, reached, end", [
    ((8.0, 0.0, 0.0), "x", "end", 0.82, 0.8), ((0.0, -8.0, 0.0), "y", "start", -0.02, 0.0),
    ((0.0, 0.0, -16.0), "z", "start", -0.54, -0.4)])
def test_the_warning_comes_once_with_place_time_and_remedy(geometry, velocity, axis, side, reached, end):
    """0.3 m to the sides at 0.08 m a step, 0.5 m to the bottom at 0.16 m: in the fourth step."""
    ((step, text),) = notes([flying(geometry, velocity, name="cube", penalty=1e-9)])
    assert step == 4
    assert text.startswith(f"cube leaves the grid: at t = 0.04 s its surface reaches {axis} = {reached:g} m, limit "
                           f"{axis} = {end:g} m, where the grid ends.")
    assert f"Move grid.{axis}.{side} outwards" in text


def test_each_body_and_face_has_its_note(geometry):
    found = notes([flying(geometry, (8.0, 8.0, 0.0), name="one"),
                   flying(geometry, (-8.0, 0.0, 0.0), name="two", position=(0.4, 0.4, 0.5))])
    assert [(step, text[:3]) for step, text in found] == [(4, "one"), (4, "one"), (4, "two")]


def test_what_needs_no_note(geometry):
    """Flying up, a platen wider than the grid from the start, a collapsed axis thinner than the body."""
    assert notes([flying(geometry, (0.0, 0.0, 8.0))], about="") == []
    assert notes([steel(2.0, 2.0, 0.1, position=(0.4, 0.4, 0.2), held=("x", "y", "z"))], about="") == []
    assert notes([flying(geometry, (0.0, 0.0, -0.1))], about="", y=Axis(0.35, 0.45, collapsed=True)) == []


def test_terminal_and_summary_carry_the_note(geometry, tmp_path):
    stream = io.StringIO()
    simulation = build(soil_scene([flying(geometry, (8.0, 0.0, 0.0), name="cube")], held=True, steps=5))
    simulation.run([Summary(tmp_path), Progress(stream)])
    before, note, untouched = json.loads((tmp_path / "summary.json").read_text())["notes"]
    assert before.startswith("cube gets to x = 0.9 m") and note.startswith("cube leaves the grid")
    assert "touches neither" in untouched
    assert [line for line in stream.getvalue().splitlines() if line.startswith("cube")] == [before, note, untouched]
