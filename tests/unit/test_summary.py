"""Progress line and summary.json: how far a run is, and what it took."""

import io
import json

import numpy as np
import pytest
from fake_run import FakeSimulation

from hybrid.output import history, progress, summary


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_progress_is_one_line_on_a_terminal_and_silent_elsewhere():
    screen, pipe, closing = Terminal(), io.StringIO(), io.StringIO()
    FakeSimulation().run(
        [progress.Progress(screen), progress.Progress(pipe), progress.Progress(closing, announce=True)]
    )
    assert screen.getvalue().count("\n") == 1 and "drag 4/4" in screen.getvalue()
    assert pipe.getvalue() == ""
    assert closing.getvalue().startswith("fake: completed, 6 steps in 0:00")
    simulation = FakeSimulation()
    simulation.state = simulation.state_at(6)
    line = progress.describe(simulation.record(), 4, 75)
    assert len(line) <= 100 and line == (
        "drag 4/4  1:15 left  t 0.240 s  dt 0.04 s  3 iterations  residual 1.0e-07  17 contacts  tension 6 kN")
    assert progress.clock(3671) == "1:01:11"


def test_summary_adds_up_over_a_resumed_run(tmp_path):
    observers = [history.History(tmp_path), summary.Summary(tmp_path)]
    FakeSimulation().run(observers, until=4, outcome="interrupted")
    resumed = FakeSimulation()
    resumed.state = resumed.state_at(4)
    resumed.versions = {"gmsh": "4.8"}
    resumed.run([history.History(tmp_path), summary.Summary(tmp_path)])
    content = json.loads((tmp_path / "summary.json").read_text())
    assert content["outcome"] == "completed" and content["step"] == 6 and content["resumed_from_step"] == 4
    assert content["totals"]["steps"] == 6 and content["totals"]["iterations"] == 18
    assert content["totals"]["seconds"] == pytest.approx({"contact_search": 0.6, "solve": 1.8})
    assert content["sizes"] == {"points": 200, "unknowns": 1234}
    assert content["versions"]["numpy"] == np.__version__ and content["versions"]["gmsh"] == "4.8"
    assert content["machine"]["cpus"] >= 1
