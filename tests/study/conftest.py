"""The quick study of each problem, run once for all tests that need it."""

import functools
import json
from types import SimpleNamespace

import pytest

from hybrid.study import precision, sweep
from hybrid.study.problems import cantilever, platen, sphere

COMPUTES = {cantilever: "bend", platen: "press", sphere: "rides"}   # its errors are made of that


def key(args, values):
    return json.dumps([args, values], sort_keys=True)


def keeping(function, kept):
    """The function, keeping what it returns."""
    def keep(*args, **values):
        kept[key(args, values)] = found = function(*args, **values)
        return found
    return keep


@pytest.fixture(scope="session")
def quick(tmp_path_factory):
    """records(name): of `hybrid study precision NAME --quick`, nothing being drawn; again[problem]: what one of COMPUTES
    returned for the same values, to see what the problem makes of that against another answer."""
    again = {}

    @functools.cache
    def records(name):
        with pytest.MonkeyPatch.context() as patch:
            problem, kept = sweep.problem(name), {}
            if problem in COMPUTES:
                patch.setattr(problem, COMPUTES[problem], keeping(getattr(problem, COMPUTES[problem]), kept))
                again[problem] = lambda *args, **values: kept[key(args, values)]
            patch.setattr(precision, "draw", lambda path, out: [])
            return precision.run([name], quick=True, out=tmp_path_factory.mktemp("quick"), tell=lambda _: None)
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
    """replayed(problem, curve): Found of the quick settings of a curve, made anew of what was computed."""
    def of(problem, curve):
        values = [record.values for record in recorded(problem, curve)]
        monkeypatch.setattr(problem, COMPUTES[problem], quick.again[problem])
        return [problem.solve(**each) for each in values]
    return of
