"""Runs failure modes and records the outcome of every run."""

from math import nan
from pathlib import Path
from time import perf_counter

from hybrid.runtime.errors import HybridError
from hybrid.study.failure import outcome, report
from hybrid.study.failure.outcome import Outcome, classify
from hybrid.study.failure.registry import MODES
from hybrid.study.records import chosen, record_runs


def run(names=(), quick=False, out=Path("out/failure"), resume=False, log=print):
    """Run the modes of these names (all if none), write outcomes and figures to the folder `out`; returns outcomes.

    resume: keep the outcomes of the folder and run the settings that are missing. Raises SceneError for an unknown
    name.
    """
    keys = runs(chosen(names, MODES, "failure", "case"), quick)
    return record_runs(keys, measure, outcome, report, out, quick, resume, log)


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
