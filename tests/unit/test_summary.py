"""Progress line and summary.json: how far a run is, and what it took."""

import io
import json
from dataclasses import replace

import numpy as np
import pytest
from fake_run import FakeSimulation

from hybrid.body import mesh
from hybrid.output import history, progress, summary


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_progress_is_one_line_on_a_terminal():
    screen = Terminal()
    FakeSimulation().run([progress.Progress(screen)])
    assert screen.getvalue().count("\n") == 1 and "drag 4/4" in screen.getvalue()
    assert screen.getvalue().endswith("fake: completed, 6 steps in 0:00\n")


def test_the_end_of_a_run_has_the_last_value_of_notes_that_change(tmp_path):
    class Noted(FakeSimulation):
        def record(self):
            return replace(super().record(), notes=("impact: 16%", "other") if self.state.step == 2 else ())

    screen = io.StringIO()
    simulation = Noted()
    simulation.later_notes = {"impact: 16%": "impact: 22%"}
    simulation.run([progress.Progress(screen), summary.Summary(tmp_path)])
    assert json.loads((tmp_path / summary.NAME).read_text())["notes"] == ["impact: 22%", "other"]
    assert screen.getvalue().splitlines()[-2] == "at the end: impact: 22%"


@pytest.mark.parametrize("interval, share, lines", [(1e9, 0.05, 5), (1e9, 0.5, 1), (0.0, 1.0, 5), (1e9, 1.0, 0)])
def test_a_file_gets_a_line_now_and_then_and_where_the_results_are(monkeypatch, interval, share, lines):
    """By time or by the share of six steps, the last of which has the closing line."""
    monkeypatch.setattr(progress, "INTERVAL", interval)
    monkeypatch.setattr(progress, "SHARE", share)
    pipe = io.StringIO()
    FakeSimulation().run([progress.Progress(pipe, "out/fake")])
    *found, last = pipe.getvalue().splitlines()
    assert len(found) == lines and last == "fake: completed, 6 steps in 0:00; results in out/fake"
    assert all("left  t 0." in line and "\x1b" not in line for line in found)


class Gone(io.StringIO):
    """A stream whose reader is gone."""

    def write(self, text):
        raise BrokenPipeError


@pytest.mark.parametrize("stream", [Gone(), None])
def test_a_run_goes_on_without_anybody_to_read(stream, monkeypatch):
    monkeypatch.setattr("sys.stderr", stream)
    simulation = FakeSimulation()
    simulation.run([progress.Progress()])
    assert simulation.state.step == 6


def test_the_line_of_progress():
    simulation = FakeSimulation()
    simulation.state = simulation.state_at(6)
    line = progress.describe(simulation.record(), 4, 75)
    assert len(line) <= 100 and line == (
        "drag 4/4  1:15 left  t 0.24 s  dt 0.04 s  3 iterations  residual 1.0e-07  17 contacts  tension 6 kN")
    assert progress.clock(3671) == "1:01:11"


def test_summary_adds_up_over_a_resumed_run(tmp_path, monkeypatch):
    observers = [history.History(tmp_path), summary.Summary(tmp_path)]
    FakeSimulation().run(observers, until=4, outcome="interrupted")
    resumed = FakeSimulation()
    resumed.state = resumed.state_at(4)
    monkeypatch.setitem(mesh.versions, "gmsh", "4.8")     # as if one had been made
    resumed.run([history.History(tmp_path), summary.Summary(tmp_path)])
    content = json.loads((tmp_path / "summary.json").read_text())
    assert content["outcome"] == "completed" and content["step"] == 6 and content["resumed_from_step"] == 4
    assert content["totals"]["steps"] == 6 and content["totals"]["iterations"] == 18
    assert content["totals"]["seconds"] == pytest.approx({"contact_search": 0.6, "solve": 1.8})
    assert content["sizes"] == {"points": 200, "unknowns": 1234}
    assert content["versions"]["numpy"] == np.__version__ and content["versions"]["gmsh"] == "4.8"
    assert content["machine"]["cpus"] >= 1
