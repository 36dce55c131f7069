"""The runner and the report of the study of failure, by a mode whose outcomes are known."""

import pytest

from hybrid.runtime.errors import SceneError, StepError
from hybrid.study.failure import outcome, report, runner
from hybrid.study.failure.mode import Mode, matching
from hybrid.study.failure.outcome import Observation


def solve(load, stops=False):
    """Wrong beyond 1, and reports it from 2 on."""
    if stops and load > 1:
        raise StepError("step 3 failed: lower the load")
    return Observation(load / 10, ("load too large; lower the load", "some other note") if load >= 2 else ())


TOY = Mode(title="toy", parameters=("load [N]",), measure="error", right=0.05, wrong=0.1,
           methods={"plain": {}, "stops": {"stops": True}}, default="stops", message="lower the load",
           full=(0.5, 1.0, 1.5, 3.0), quick=(0.5, 3.0), solve=solve)


@pytest.fixture
def toy(monkeypatch):
    """The toy in place of the cell crossing."""
    monkeypatch.setitem(runner.MODES, "crossing", TOY)


def test_outcomes_are_classified_kept_and_drawn(toy, tmp_path):
    lines = []
    found = runner.run(["crossing"], out=tmp_path, log=lines.append)
    assert [o.kind for o in found] == [
        "right", "degraded", "silent", "reported", "right", "degraded", "reported", "reported"]
    assert found[3].message == "load too large; lower the load" and found[-1].message.startswith("step 3 failed")
    marks, read = outcome.load(tmp_path / "records.json")
    assert [o.key for o in read] == [o.key for o in found] and {"commit", "machine"} <= set(marks)
    assert (tmp_path / "atlas.png").stat().st_size > 5_000 and not (tmp_path / "maps.png").exists()
    assert lines[0] == "crossing, plain, 0.5: right, error 0.05" and len(lines) == len(found) + 1
    assert report.table(found)[0] == {"case": "crossing", "method": "plain", "right": 1, "degraded": 1, "reported": 1,
                                      "silent": 1}


def test_a_resumed_study_runs_only_missing_settings(toy, tmp_path, monkeypatch):
    monkeypatch.setattr(report, "draw", lambda path, out: [])
    assert len(runner.run(["crossing"], quick=True, out=tmp_path, log=lambda _: None)) == 4
    lines = []
    assert len(runner.run(["crossing"], out=tmp_path, resume=True, log=lines.append)) == 8
    assert len(lines) == 4


def test_unknown_mode():
    with pytest.raises(SceneError, match="study failure crosing: no such case; there are crossing"):
        runner.run(["crosing"])


def test_only_messages_of_the_failure_count():
    assert TOY.observe("plain", (3.0,)).messages == ("load too large; lower the load",)
    assert matching(None, ("any",)) == () and TOY.settings(quick=True) == [(0.5,), (3.0,)]


def test_nothing_left_to_measure_is_a_failure():
    assert outcome.classify(Observation(float("inf")), 1.0, 2.0) == ("silent", "")
    assert outcome.classify(Observation(float("nan"), ("a", "b")), 1.0, 2.0) == ("reported", "a; b")


def test_the_listing_has_every_name():
    assert [row["name"] for row in report.listing()] == list(report.MODES)
