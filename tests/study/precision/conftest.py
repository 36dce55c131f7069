"""The quick study of each problem, run once for all tests that use it."""

import functools
import json
from importlib import import_module
from types import SimpleNamespace

import pytest

from hybrid.study.precision import report, runner
from hybrid.study.precision.problems import cantilever, platen, sphere

COMPUTES = {cantilever: "bend", platen: "press", sphere: "rides"}   # the errors are computed from its result


def key(args, values):
    return json.dumps([args, values], sort_keys=True)


def keeping(function, kept):
    """The function, storing its results in the dict `kept`."""
    def keep(*args, **values):
        kept[key(args, values)] = result = function(*args, **values)
        return result
    return keep


@pytest.fixture(scope="session")
def quick(tmp_path_factory):
    """records(name): of `hybrid study precision NAME --quick`, without figures; again[problem]: a stand-in for the
    function of COMPUTES that returns the stored results, for tests that evaluate them against another reference."""
    again = {}

    @functools.cache
    def records(name):
        with pytest.MonkeyPatch.context() as patch:
            problem, kept = import_module(f"hybrid.study.precision.problems.{name}"), {}
            if problem in COMPUTES:
                patch.setattr(problem, COMPUTES[problem], keeping(getattr(problem, COMPUTES[problem]), kept))
                again[problem] = lambda *args, **values: kept[key(args, values)]
            patch.setattr(report, "draw", lambda path, out: [])
            return runner.run([name], quick=True, out=tmp_path_factory.mktemp("quick"), log=lambda _: None)
    return SimpleNamespace(records=records, again=again)


@pytest.fixture
def recorded(quick):
    """recorded(problem, curve): its records."""
    def of(problem, curve):
        found = [r for r in quick.records(problem.__name__.rpartition(".")[2]) if r.curve == curve]
        assert found
        return found
    return of


@pytest.fixture
def replayed(quick, recorded, monkeypatch):
    """replayed(problem, curve): RunResults of the quick settings of a curve, evaluated again from the stored
    results."""
    def of(problem, curve):
        values = [record.values for record in recorded(problem, curve)]
        monkeypatch.setattr(problem, COMPUTES[problem], quick.again[problem])
        return [problem.solve(**each) for each in values]
    return of
