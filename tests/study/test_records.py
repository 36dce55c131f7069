"""Records, fronts and figures of a study, by a problem whose errors and costs are known."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from hybrid.runtime.errors import SceneError, StepError
from hybrid.study import front, precision, record, sweep
from hybrid.study.record import Found, Record

PAGE = Path(__file__).parents[2] / "demos/precision/README.md"


def solve(size, order=2, fails=False):
    if fails:
        raise StepError("too long a step")
    return Found({"force": size**order, "moment": 2 * size}, 3, round(1 / size), 1e-3 / size**3)


TOY = SimpleNamespace(
    TITLE="toy", ERRORS={"force": "|F/F0 - 1|", "moment": "|M/M0 - 1|"}, solve=solve,
    curves=lambda quick: {
        "default": [(f"h = {h} m", {"size": h}) for h in (0.5, 0.25, 0.125)[:2 if quick else 3]],
        "first order": [(f"h = {h} m", {"size": h, "order": 1}) for h in (0.5, 0.25)],
        "brittle": [("h = 0.1 m", {"size": 0.1, "fails": True})]},
    peers=lambda: [Record("column", "peer", "h = 0.5 m", {}, {"force": 0.2}, (9.0,), 2, 2, source="another program")])


@pytest.fixture
def toy(monkeypatch):
    monkeypatch.setattr(sweep, "problem", lambda name: TOY)


@pytest.fixture
def undrawn(monkeypatch):
    """A study without figures, for tests of all else; gives what draws them."""
    draw = precision.draw
    monkeypatch.setattr(precision, "draw", lambda path, out: [])
    return draw


def test_a_study_keeps_every_run_and_every_failure(toy, undrawn, tmp_path):
    told = []
    records = precision.run(["column"], out=tmp_path, tell=told.append)
    assert [r.curve for r in records] == ["peer", *["default"] * 3, *["first order"] * 2, "brittle"]
    assert records[-1].failed and "too long a step" in records[-1].reason and "too long a step" in told[-1]
    assert len(records[1].seconds) == precision.REPEATS and records[1].work == 6
    marks, read = record.load(tmp_path / "records.json")
    assert read == records and {"commit", "machine", "versions"} <= set(marks)


def test_what_was_measured_is_not_measured_again(toy, undrawn, tmp_path, monkeypatch):
    precision.run(["column"], quick=True, out=tmp_path, tell=lambda _: None)
    calls = []
    monkeypatch.setattr(TOY, "solve", lambda **values: calls.append(values) or solve(**values))
    records = precision.run(["column"], out=tmp_path, resume=True, tell=lambda _: None)
    assert calls[1:] == [{"size": 0.125}] * precision.REPEATS and len(records) == 7


def test_figures_need_records_only(toy, undrawn, tmp_path, monkeypatch):
    precision.run(["column"], quick=True, out=tmp_path, tell=lambda _: None)
    monkeypatch.setattr(TOY, "solve", None)
    drawn = undrawn(tmp_path / "records.json", tmp_path)
    assert len(drawn) == 2 and all(path.stat().st_size > 10_000 for path in drawn)


def records():
    return [Record("p", "a", "1", {}, {"e": 0.1}, (1.0,), 1, 1), Record("p", "a", "2", {}, {"e": 0.01}, (4.0,), 1, 2),
            Record("p", "b", "1", {}, {"e": 0.05}, (8.0,), 1, 9), Record("p", "b", "2", {}, {"e": 0.001}, (9.0,), 1, 10),
            Record("p", "c", "1", {}, reason="no"), Record("p", "d", "1", {}, {"e": float("nan")}, (0.1,), 1, 1)]


def test_front_and_the_way_to_it():
    found = front.front(records(), "e")
    assert [(r.curve, r.setting) for r in found] == [("a", "1"), ("a", "2"), ("b", "2")]
    assert front.excess(records()[2], records(), "e") == 2.0 and front.excess(records()[1], records(), "e") == 1.0
    assert front.excess(records()[4], records(), "e") == front.excess(records()[5], records(), "e") == float("inf")
    assert front.cheapest(records(), "e", 0.02).setting == "2" and front.cheapest(records(), "e", 1e-9) is None


def test_time_is_the_median_and_spread_half_the_range_over_it():
    r = Record("p", "a", "1", {}, {"e": 0.1}, (1.0, 4.0, 2.0), 1, 1)
    assert (r.time, r.spread) == (2.0, 0.75) and records()[0].spread == 0.0


def test_unknown_problem():
    with pytest.raises(SceneError, match="study precision colum: no such problem; there are column"):
        precision.run(["colum"])


def test_the_quick_study_of_every_problem(quick):
    """All that have a quick form get through, but for what fails on purpose, and have a panel for each cost."""
    records = [r for name in precision.PROBLEMS if sweep.runs([name], True) for r in quick.records(name)]
    assert set(precision.PROBLEMS) - {r.problem for r in records} == {"anchor"}     # takes too long
    assert {(r.problem, r.curve) for r in records if r.failed} == {("cantilever", "default")}
    for cost in precision.COSTS:
        panels = precision.panels(records, cost)
        assert len(panels) == 7 and all(panel.front for panel in panels)
    nearest = {}
    for row in precision.table(records):
        nearest.setdefault((row["problem"], row["error of"]), []).append(row["times the front"])
    del nearest["footing", "Nc, φ = 0"]      # not among its quick settings
    assert {min(times) for times in nearest.values()} == {1.0}


def test_the_page_says_where_the_defaults_stand():
    """Its table has how many times the cost of the front the default settings take, from the best to the worst one."""
    all_records = record.load(precision.RECORDED)[1]
    told = PAGE.read_text(encoding="utf-8").splitlines()
    for letter, name in zip("abcdefgh", precision.PROBLEMS):
        own = [r for r in all_records if r.problem == name and not r.source]
        for error in sweep.problem(name).ERRORS:
            spans = []
            for cost in precision.COSTS:
                times = [front.excess(r, own, error, cost) for r in own if r.curve.partition(",")[0] == "default"]
                done = [f"{float(f'{x:.2g}'):g}" for x in times if x < float("inf")]
                spans.append(" to ".join(dict.fromkeys((min(done, key=float), max(done, key=float)))) if done else "no run")
            assert any(line.startswith(f"| ({letter}) {error} | {' | '.join(spans)} |") for line in told), (error, spans)
