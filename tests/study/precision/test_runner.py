"""The runner of the study of precision, by a problem whose errors and costs are known, and the quick study."""

from dataclasses import replace

import pytest

from hybrid.runtime.errors import SceneError, StepError
from hybrid.study.precision import record, report, runner
from hybrid.study.precision.problem import Problem
from hybrid.study.precision.record import Record, RunResult


def solve(size, order=2, fails=False):
    if fails:
        raise StepError("too long a step")
    return RunResult({"force": size**order, "moment": 2 * size}, 3, round(1 / size), 1e-3 / size**3)


TOY = Problem(
    title="toy", errors={"force": "|F/F0 - 1|", "moment": "|M/M0 - 1|"}, solve=solve,
    curves=lambda quick: {
        "default": [(f"h = {h} m", {"size": h}) for h in (0.5, 0.25, 0.125)[:2 if quick else 3]],
        "first order": [(f"h = {h} m", {"size": h, "order": 1}) for h in (0.5, 0.25)],
        "brittle": [("h = 0.1 m", {"size": 0.1, "fails": True})]},
    peers=lambda: [Record("column", "peer", "h = 0.5 m", {}, {"force": 0.2}, (9.0,), 2, 2, source="another program")])


@pytest.fixture
def toy(monkeypatch):
    """The toy in place of the column."""
    monkeypatch.setitem(runner.PROBLEMS, "column", TOY)


@pytest.fixture
def undrawn(monkeypatch):
    """A study without figures; gives the function that draws them."""
    draw = report.draw
    monkeypatch.setattr(report, "draw", lambda path, out: [])
    return draw


def test_a_study_keeps_every_run_and_every_failure(toy, undrawn, tmp_path):
    lines = []
    records = runner.run(["column"], out=tmp_path, log=lines.append)
    assert [r.curve for r in records] == ["peer", *["default"] * 3, *["first order"] * 2, "brittle"]
    assert records[-1].failed and "too long a step" in records[-1].reason and "too long a step" in lines[-1]
    assert len(records[1].seconds) == runner.REPEATS and records[1].work == 6
    marks, read = record.load(tmp_path / "records.json")
    assert read == records and {"commit", "machine", "versions"} <= set(marks)


def test_a_resumed_study_runs_only_missing_settings(toy, undrawn, tmp_path, monkeypatch):
    runner.run(["column"], quick=True, out=tmp_path, log=lambda _: None)
    calls = []
    monkeypatch.setitem(runner.PROBLEMS, "column", replace(
        TOY, solve=lambda **values: calls.append(values) or solve(**values)))
    records = runner.run(["column"], out=tmp_path, resume=True, log=lambda _: None)
    assert calls[1:] == [{"size": 0.125}] * runner.REPEATS and len(records) == 7


def test_long_runs_are_not_repeated(monkeypatch):
    def slow(size):
        return RunResult({"force": size}, 1, 1, 2 * runner.LONG)

    monkeypatch.setitem(runner.PROBLEMS, "column", replace(TOY, solve=slow))
    assert len(runner.measure("column", "default", "h", {"size": 1.0}, 3).seconds) == 1


def test_figures_need_records_only(toy, undrawn, tmp_path, monkeypatch):
    runner.run(["column"], quick=True, out=tmp_path, log=lambda _: None)
    monkeypatch.setitem(runner.PROBLEMS, "column", replace(TOY, solve=None))
    drawn = undrawn(tmp_path / "records.json", tmp_path)
    assert len(drawn) == 3 and all(path.stat().st_size > 10_000 for path in drawn)


def test_unknown_problem():
    with pytest.raises(SceneError, match="study precision colum: no such problem; there are column"):
        runner.run(["colum"])


@pytest.mark.parametrize("others", [{"anchor", "sphere"}, pytest.param({"anchor"}, marks=pytest.mark.slow)])
def test_the_quick_study_of_every_problem(quick, others):
    """All problems with quick settings but `others`, which take long, complete them; each has a panel per cost."""
    names = set(runner.PROBLEMS) - others
    assert all(bool(problem.curves(True)) == (name != "anchor") for name, problem in runner.PROBLEMS.items())
    records = [r for name in names for r in quick.records(name)]
    assert {r.problem for r in records} == names
    assert not [r.key for r in records if r.failed]
    for cost in report.COSTS:
        panels = report.panels(records, cost)
        assert len(panels) == len(names) and all(panel.front for panel in panels)
    nearest = {}
    for row in report.table(records):
        nearest.setdefault((row["problem"], row["error of"]), []).append(row["times the front"])
    del nearest["footing", "Nc, φ = 0"]      # not among the quick settings
    assert {min(times) for times in nearest.values()} == {1.0}
