"""Figures and tables of the study of precision: error against wall time, and against Newton iterations times unknowns.

They are made from a file of records only; no run is needed. RECORDED is the file that ships with the program; the
levels and targets of a scene's `accuracy` are fitted to it (`hybrid.study.precision.fit_accuracy`).
"""

import math
from pathlib import Path

from hybrid.output.work_precision import Panel, Series, work_precision
from hybrid.study.precision import pareto
from hybrid.study.precision.record import load
from hybrid.study.precision.registry import PROBLEMS

RECORDED = Path(__file__).with_name("precision.json")
COSTS = {"time": "wall time of the steps [s]", "work": "Newton iterations × unknowns"}


def draw(path, out):
    """Draw the figures of a file of records in the folder `out`, one for each cost; returns their paths."""
    marks, records = load(path)
    return [work_precision(Path(out) / f"{cost}.png", panels(records, cost), text, _mark(marks))
            for cost, text in COSTS.items()]


def panels(records, cost):
    """[Panel of the first error of each problem]."""
    drawn = []
    for name in dict.fromkeys(r.problem for r in records):
        problem, own = PROBLEMS[name], [r for r in records if r.problem == name]
        error = next(iter(problem.errors))
        measured = [r for r in own if r.failed or math.isfinite(r.errors[error])]   # not those of other errors only
        series = [_series(label, [r for r in measured if r.curve == label], error, cost)
                  for label in dict.fromkeys(r.curve for r in measured)]
        best = [(getattr(r, cost), r.errors[error]) for r in pareto.front(own, error, cost)]
        drawn.append(Panel(problem.title, f"error of {error} [-]", series, best))
    return drawn


def _series(label, records, error, cost):
    done = [r for r in records if not r.failed]
    return Series(label, [getattr(r, cost) for r in done], [r.errors[error] for r in done],
                  [r.spread if cost == "time" else 0.0 for r in done], len(records) - len(done),
                  foreign=any(r.source for r in records))


def table(records, cost="time"):
    """Rows of {problem, error, curve, nearest setting, cost}: how close each curve comes to the Pareto front."""
    rows = []
    for name in dict.fromkeys(r.problem for r in records):
        own = [r for r in records if r.problem == name and not r.source]
        for error in PROBLEMS[name].errors:
            for label in dict.fromkeys(r.curve for r in own):
                placed = [(pareto.excess(r, own, error, cost), r) for r in own if r.curve == label]
                times, nearest = min(placed, key=lambda pair: pair[0])
                rows.append({"problem": name, "error of": error, "curve": label, "nearest": nearest.setting,
                             "times the front": times, "failed": sum(r.failed for _, r in placed)})
    return rows


def listing():
    """Rows of {name, title} of all problems."""
    return [{"name": name, "title": problem.title} for name, problem in PROBLEMS.items()]


def line(r):
    """Text of a record: its errors, time and work, or why it failed."""
    run = f"{r.problem}, {r.curve}, {r.setting}: "
    if r.failed:
        return run + f"failed: {r.reason}"
    return run + ", ".join(f"{name} {value:.2e}" for name, value in r.errors.items()) + (
        f"; {r.time:.3g} s ± {100 * r.spread:.0f} %, {r.newton} iterations of {r.unknowns} unknowns")


def _mark(marks):
    machine = marks["machine"]
    return f"{machine.get('cpu')}, {marks['numba_threads']} threads, commit {str(marks['commit'])[:8]}, hybrid " + str(
        marks["versions"].get("hybrid"))
