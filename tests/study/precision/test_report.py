"""What the report makes of the records that ship, and what the page states of them."""

from pathlib import Path

from hybrid.study.precision import pareto, record, report
from hybrid.study.precision.record import Record

PAGE = Path(__file__).parents[3] / "demos/precision/README.md"


def test_the_page_states_the_place_of_the_defaults():
    """Its table has the cost of the default settings over that of the front, from the smallest to the largest ratio."""
    all_records = record.load(report.RECORDED)[1]
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    for letter, (name, problem) in zip("abcdefgh", report.PROBLEMS.items()):
        own = report.competing([r for r in all_records if r.problem == name], problem)
        for error in problem.errors:
            spans = []
            for cost in report.COSTS:
                times = [pareto.excess(r, own, error, cost) for r in own if r.curve.partition(",")[0] == "default"]
                done = [f"{float(f'{x:.2g}'):g}" for x in times if x < float("inf")]
                ends = dict.fromkeys((min(done, key=float), max(done, key=float))) if done else ("no run",)
                spans.append(" to ".join(ends))
            row = f"| ({letter}) {error} | {' | '.join(spans)} |"
            assert any(line.startswith(row) for line in lines), (error, spans)


def test_a_panel_has_six_curves_at_most_and_every_curve_a_panel():
    records = record.load(report.RECORDED)[1]
    first, second = report.panels(records, "time"), report.panels(records, "time", shown=False)
    for problem, *both in zip(report.PROBLEMS.values(), first, second):
        labels = [[series.label for series in panel.series] for panel in both]
        assert all(len(of_one) <= 6 and "default" in of_one for of_one in labels)
        assert set(problem.shown) <= set(labels[0]) and set(labels[0]) & set(labels[1]) == {"default"}


def test_every_record_that_ships_is_of_a_problem_and_a_curve():
    records = record.load(report.RECORDED)[1]
    assert {r.problem for r in records} == set(report.PROBLEMS)
    for name, problem in report.PROBLEMS.items():
        curves = {**problem.curves(False), **problem.peer_curves(False)}
        known = {(curve, setting) for curve, settings in curves.items() for setting, _ in settings}
        known |= {(r.curve, r.setting) for r in problem.peers()}
        assert {(r.curve, r.setting) for r in records if r.problem == name} <= known


def test_a_line_gives_errors_and_cost_or_the_reason_of_a_failure():
    done = Record("column", "default", "h", {}, {"stress": 0.01}, (2.0, 3.0, 4.0), 5, 6)
    assert report.line(done) == "column, default, h: stress 1.00e-02; 2 s + 100 %, 5 iterations of 6 unknowns"
    assert report.line(Record("column", "default", "h", reason="no convergence")).endswith("h: failed: no convergence")


def test_the_listing_has_every_name():
    assert [row["name"] for row in report.listing()] == list(report.PROBLEMS)
