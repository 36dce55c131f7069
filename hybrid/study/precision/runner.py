"""Runs the curves of problems and records every run, failed ones too."""

from functools import partial
from pathlib import Path

from hybrid.bench.peer import version
from hybrid.runtime.errors import HybridError
from hybrid.study.precision import record, report
from hybrid.study.precision.record import Record
from hybrid.study.precision.registry import PROBLEMS
from hybrid.study.records import begin, chosen

REPEATS = 3     # runs of each setting; the least of their times counts
LONG = 5.0      # [s] a run that takes longer is not repeated


def run(names=(), quick=False, out=Path("out/precision"), resume=False, log=print, peer=None):
    """Run the problems of these names (all if none), write records and figures to the folder `out`; returns records.

    quick: a few settings, each run once, their times including the loading of compiled code; resume: keep the records
    of the folder and run the settings that are missing; peer: path of a Python with Kratos MPM, to be run as well.
    Raises SceneError for an unknown name, HybridError if that Python has no Kratos MPM.
    """
    names = chosen(names, PROBLEMS, "precision", "problem")
    source = peer and f"Kratos MPM {version(peer)}"
    path, marks, records = begin(out, quick, resume, record.load)
    known, repeats = {r.key for r in records}, 1 if quick else REPEATS

    def add(run, **how):
        records.append(measure(*run, repeats, **how))
        record.save(path, marks, records)
        log(report.line(records[-1]))

    for name in names:
        problem = PROBLEMS[name]
        records += [measured for measured in problem.peers() if measured.key not in known]
        for run in runs(name, problem.peer_curves(quick)) if peer else ():
            if run[:3] not in known:
                add(run, solve=partial(problem.peer_solve, peer), source=source)
        missing = [run for run in runs(name, problem.curves(quick)) if run[:3] not in known]
        if missing and not quick:      # the times of a quick study are not compared
            warm(problem, missing[0][3])
        for run in missing:
            add(run)
    record.save(path, marks, records)
    for figure in report.draw(path, out):
        log(figure)
    return records


def runs(name, curves):
    """[(problem, curve, setting, values), ...] of all settings of the curves of a problem."""
    return [(name, curve, setting, values) for curve, settings in curves.items() for setting, values in settings]


def warm(problem, values):
    """Run once, so that no record's time includes compilation. If this run fails, its record will give the reason."""
    try:
        problem.solve(**values)
    except HybridError:
        pass


def measure(name, curve, setting, values, repeats, solve=None, source=""):
    """Record of a run, repeated unless it takes LONG.

    solve: a peer's function, instead of the problem's own; source: name of that peer.
    """
    solve, results = solve or PROBLEMS[name].solve, []
    try:
        while len(results) < (1 if results and results[0].seconds > LONG else repeats):
            results.append(solve(**values))
    except HybridError as error:
        return Record(name, curve, setting, values, reason=str(error), source=source)
    first = results[0]
    return Record(name, curve, setting, values, first.errors, tuple(result.seconds for result in results), first.newton,
                  first.unknowns, source=source)
