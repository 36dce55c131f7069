"""Runs failure modes and records the outcome of every run."""

from math import nan
from pathlib import Path
from time import perf_counter

from hybrid.bench.stamp import stamp
from hybrid.runtime.errors import HybridError, SceneError
from hybrid.study.failure import outcome, report
from hybrid.study.failure.outcome import Outcome, classify, load
from hybrid.study.failure.registry import MODES


def run(names=(), quick=False, out=Path("out/failure"), resume=False, log=print):
    """Run the modes of these names (all if none), write outcomes and figures to the folder `out`; returns outcomes.

    resume: keep the outcomes of the folder and run the settings that are missing. Raises SceneError for an unknown
    name.
    """
    names = list(names) or list(MODES)
    if unknown := [name for name in names if name not in MODES]:
        raise SceneError(f"study failure {unknown[0]}: no such case; there are {', '.join(MODES)}")
    path, marks = Path(out) / "records.json", {"quick": quick, **stamp()}
    outcomes = load(path)[1] if resume and path.is_file() else []
    known = {o.key for o in outcomes}
    for key in runs(names, quick):
        if key not in known:
            outcomes.append(measure(*key))
            outcome.save(path, marks, outcomes)
            log(report.line(outcomes[-1]))
    for figure in report.draw(path, out):
        log(figure)
    return outcomes


def runs(names, quick=False):
    """[(name of the mode, method, setting), ...] of all runs, in order."""
    return [(name, method, setting) for name in names
            for method in MODES[name].methods for setting in MODES[name].settings(quick)]


def measure(name, method, setting):
    """Outcome of a run."""
    mode, begin = MODES[name], perf_counter()
    try:
        observation = mode.observe(method, setting)
        kind, message = classify(observation, mode.right, mode.wrong)
        error = float(observation.error)
    except HybridError as failure:
        kind, message, error = "reported", str(failure), nan
    return Outcome(name, method, setting, kind, error, message, round(perf_counter() - begin, 2))
