"""Runs cases of failure and judges what comes of them.

A case is a module of `hybrid.study.failures` whose docstring says what fails and why, with

    TITLE            how it fails, in a few words
    PARAMETERS       names, with units, of the one or two parameters that drive it through the failure
    MEASURE          what the error is measured in, in words; RIGHT, WRONG: up to which it is right, degraded
    METHODS          {label: values of `solve`}: the plain method first, then remedies
    DEFAULT          label of what a scene gets that does not ask; it never fails silently
    SAYS             regular expression that what is said of the failure matches: the number and the remedy in it
    settings(quick)  [(value, ...), ...], the parameters' values as figures show them, mild ones first
    solve(*setting, **values)    Seen; raises HybridError where the run stops by itself
"""

from importlib import import_module
from math import nan
from time import perf_counter

from hybrid.runtime.errors import HybridError
from hybrid.setup.build import build
from hybrid.study.outcome import Outcome, judged


def case(name):
    """Module of a case."""
    return import_module(f"hybrid.study.failures.{name}")


def runs(names, quick=False):
    """(case, method, setting) of all runs, in order."""
    return [(name, method, tuple(setting)) for name in names
            for method in case(name).METHODS for setting in case(name).settings(quick)]


def observe(name, method, setting):
    """Outcome of a run."""
    module, begun = case(name), perf_counter()
    try:
        seen = module.solve(*setting, **module.METHODS[method])
        kind, message = judged(seen, module.RIGHT, module.WRONG)
        error = float(seen.error)
    except HybridError as failure:
        kind, message, error = "said", str(failure), nan
    return Outcome(name, method, setting, kind, error, message, round(perf_counter() - begun, 2))


def watched(scene, **given):
    """(Simulation after all its steps, its records, what it told: warnings of its sheet and notes of its steps).

    given: what `build` takes besides.
    """
    simulation = build(scene, **given)
    records = list(simulation.steps())
    return simulation, records, told(simulation, records)


def told(simulation, records):
    """What a run said by itself: the warnings of its sheet and the notes of its steps."""
    notes = tuple(note for record in records for note in record.notes)
    warned = tuple(simulation.sheet().get("warnings", ()))
    return warned + tuple(note for note in notes if note not in warned)
