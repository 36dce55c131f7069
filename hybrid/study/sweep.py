"""Runs the curves of problems and records what comes out, failures too.

A problem is a module of `hybrid.study.problems` with

    TITLE, ERRORS             its name in words; {error: what it is, with unit}
    curves(quick)             {curve: [(setting, values), ...]}, values as JSON knows them
    solve(**values)           Found of one run; raises HybridError where it fails
    LIKE, like(values)        where scenes may resemble it: a length of it in words, and what a scene takes over from a
                              run of these values (`hybrid.study.methods.alike`), None where that is not to be had
    SURE                      of such a problem, an error of its first kind below which differences are chance
    peers()                   records of other programs, if there are any
    peer_curves(quick)        if Kratos can do it too: as `curves`, and
    peer_solve(python, **values)    Found of one of its runs
"""

from importlib import import_module

from hybrid.runtime.errors import HybridError
from hybrid.study.record import Record

LONG = 5.0  # [s] a run that takes longer is not repeated


def problem(name):
    """Module of a problem."""
    return import_module(f"hybrid.study.problems.{name}")


def runs(names, quick=False):
    """(problem, curve, setting, values) of all runs, in order."""
    return [(name, *run) for name in names for run in _flat(problem(name).curves(quick))]


def peer_runs(names, quick=False):
    """The same of the runs of a peer."""
    return [(name, *run) for name in names for run in _flat(getattr(problem(name), "peer_curves", lambda _: {})(quick))]


def _flat(curves):
    return [(curve, setting, values) for curve, settings in curves.items() for setting, values in settings]


def warm(module, values):
    """Compile what a problem needs, so that no record measures that. What fails here will be told by its record."""
    try:
        module.solve(**values)
    except HybridError:
        pass


def measure(name, curve, setting, values, repeats, solve=None, source=""):
    """Record of a run, repeated unless it is long; solve: other than the problem's own, of a `source`."""
    solve, found = solve or problem(name).solve, []
    try:
        while len(found) < (1 if found and found[0].seconds > LONG else repeats):
            found.append(solve(**values))
    except HybridError as error:
        return Record(name, curve, setting, values, reason=str(error), source=source)
    first = found[0]
    return Record(name, curve, setting, values, first.errors, tuple(f.seconds for f in found), first.newton,
                  first.unknowns, source=source)
