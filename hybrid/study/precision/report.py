"""Figures and tables of the study of precision: error against time, and against Newton iterations times unknowns.

The curves that a problem has `shown` are in the figures time.png and work.png, all others in more.png, beside the
default. The front is that of all settings of a problem, except those that a scene chooses itself (`Problem.chosen`).
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
COSTS = {"time": "processor time of the steps [s]", "work": "Newton iterations × unknowns"}


def draw(path, out):
    """Draw the figures of a file of records in the folder `out`; returns their paths."""
    marks, records = load(path)
    figures = {"time": ("time", True), "work": ("work", True), "more": ("time", False)}
    return [work_precision(Path(out) / f"{name}.png", panels(records, cost, shown), COSTS[cost], _mark(marks))
            for name, (cost, shown) in figures.items()]


def panels(records, cost, shown=True):
    """[Panel of the first error of each problem]: the curves that it has `shown`, or the default and all others."""
    drawn = []
    for name in dict.fromkeys(r.problem for r in records):
        problem, own = PROBLEMS[name], [r for r in records if r.problem == name]
        error = next(iter(problem.errors))
        measured = [r for r in own if r.failed or math.isfinite(r.errors[error])]   # not those of other errors only
        labels = [label for label in dict.fromkeys(r.curve for r in measured)
                  if label == "default" or (label in problem.shown) == shown]
        series = [_series(label, [r for r in measured if r.curve == label], error, cost) for label in labels]
        best = [(getattr(r, cost), r.errors[error]) for r in pareto.front(competing(own, problem), error, cost)]
        drawn.append(Panel(problem.title, f"error of {error} [-]", series, best))
    return drawn


def competing(records, problem):
    """Records of a problem without those of other programs and of curves over what a scene chooses itself."""
    return [r for r in records if not r.source and r.curve not in problem.chosen]


def _series(label, records, error, cost):
    done = [r for r in records if not r.failed]
    return Series(label, [getattr(r, cost) for r in done], [r.errors[error] for r in done],
                  [r.spread if cost == "time" else 0.0 for r in done], len(records) - len(done),
                  foreign=any(r.source for r in records))


def table(records, cost="time"):
    """Rows of {problem, error, curve, nearest setting, cost}: how close each curve comes to the Pareto front."""
    rows = []
    for name in dict.fromkeys(r.problem for r in records):
        own = competing([r for r in records if r.problem == name], PROBLEMS[name])
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
        f"; {r.time:.3g} s + {100 * r.spread:.0f} %, {r.newton} iterations of {r.unknowns} unknowns")


def _mark(marks):
    machine = marks["machine"]
    return f"{machine.get('cpu')}, {marks['numba_threads']} threads, commit {str(marks['commit'])[:8]}, hybrid " + str(
        marks["versions"].get("hybrid"))
