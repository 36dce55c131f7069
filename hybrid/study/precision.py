"""Speed against accuracy: error against wall time, and against Newton iterations times unknowns, of every problem.

The records are all there is to the figures: `draw` needs no run, only their file. RECORDED is the file that ships with
the program; its fronts are what a scene's `accuracy` is read from.
"""

import math
from functools import partial
from pathlib import Path

from hybrid.bench.peer import version
from hybrid.bench.stamp import stamp
from hybrid.output.work_precision import Panel, Series, work_precision
from hybrid.runtime.errors import SceneError
from hybrid.study import front, record, sweep
from hybrid.study.record import load

PROBLEMS = ("column", "manufactured", "cantilever", "sphere", "platen", "tumbling", "footing", "anchor")
RECORDED = Path(__file__).with_name("precision.json")
COSTS = {"time": "wall time of the steps [s]", "work": "Newton iterations × unknowns"}
REPEATS = 3


def run(names=(), quick=False, out=Path("out/precision"), resume=False, tell=print, peer=None):
    """Run the problems of these names (all if none), write records and figures to the folder `out`; returns records.

    quick: a few settings, once, with what loading compiled code takes; resume: leave out what the folder's records have
    already; peer: a Python with Kratos MPM, to run beside. Raises SceneError for an unknown name, HybridError where the
    peer has no Kratos MPM.
    """
    names = list(names) or list(PROBLEMS)
    if unknown := [name for name in names if name not in PROBLEMS]:
        raise SceneError(f"study precision {unknown[0]}: no such problem; there are {', '.join(PROBLEMS)}")
    source = peer and f"Kratos MPM {version(peer)}"
    path, marks = Path(out) / "records.json", {"quick": quick, **stamp()}
    records = load(path)[1] if resume and path.is_file() else []
    known, repeats = {r.key for r in records}, 1 if quick else REPEATS

    def measure(run, **how):
        records.append(sweep.measure(*run, repeats, **how))
        record.save(path, marks, records)
        tell(_told(records[-1]))

    for name in names:
        module = sweep.problem(name)
        records += [known_peer for known_peer in getattr(module, "peers", list)() if known_peer.key not in known]
        for run in sweep.peer_runs([name], quick) if peer else ():
            if run[:3] not in known:
                measure(run, solve=partial(module.peer_solve, peer), source=source)
        todo = [run for run in sweep.runs([name], quick) if run[:3] not in known]
        if todo and not quick:      # whose seconds nobody compares
            sweep.warm(module, todo[0][3])
        for run in todo:
            measure(run)
    record.save(path, marks, records)
    for told in draw(path, out):
        tell(told)
    return records


def draw(path, out):
    """Figures of a file of records in the folder `out`, one for each cost; returns their paths."""
    marks, records = load(path)
    return [work_precision(Path(out) / f"{cost}.png", panels(records, cost), text, _mark(marks))
            for cost, text in COSTS.items()]


def panels(records, cost):
    """Panel of the first error of each problem."""
    found = []
    for name in dict.fromkeys(r.problem for r in records):
        module, own = sweep.problem(name), [r for r in records if r.problem == name]
        error = next(iter(module.ERRORS))
        measured = [r for r in own if r.failed or math.isfinite(r.errors[error])]   # of other errors: not here
        series = [_series(label, [r for r in measured if r.curve == label], error, cost)
                  for label in dict.fromkeys(r.curve for r in measured)]
        best = [(getattr(r, cost), r.errors[error]) for r in front.front(own, error, cost)]
        found.append(Panel(module.TITLE, f"error of {error} [-]", series, best))
    return found


def _series(label, records, error, cost):
    done = [r for r in records if not r.failed]
    return Series(label, [getattr(r, cost) for r in done], [r.errors[error] for r in done],
                  [r.spread if cost == "time" else 0.0 for r in done], len(records) - len(done),
                  foreign=any(r.source for r in records))


def table(records, cost="time"):
    """Rows of {problem, error, curve, its place}: how far each curve's nearest setting is from the front."""
    rows = []
    for name in dict.fromkeys(r.problem for r in records):
        own = [r for r in records if r.problem == name and not r.source]
        for error in sweep.problem(name).ERRORS:
            for label in dict.fromkeys(r.curve for r in own):
                placed = [(front.excess(r, own, error, cost), r) for r in own if r.curve == label]
                times, nearest = min(placed, key=lambda pair: pair[0])
                rows.append({"problem": name, "error of": error, "curve": label, "nearest": nearest.setting,
                             "times the front": times, "failed": sum(r.failed for _, r in placed)})
    return rows


def _told(r):
    what = f"{r.problem}, {r.curve}, {r.setting}: "
    if r.failed:
        return what + f"failed: {r.reason}"
    return what + ", ".join(f"{name} {value:.2e}" for name, value in r.errors.items()) + (
        f"; {r.time:.3g} s ± {100 * r.spread:.0f} %, {r.newton} iterations of {r.unknowns} unknowns")


def _mark(marks):
    machine = marks["machine"]
    return f"{machine.get('cpu')}, {marks['numba_threads']} threads, commit {str(marks['commit'])[:8]}, hybrid " + str(
        marks["versions"].get("hybrid"))
