"""The platen of a study: the error is the overlap of the penalty, of first order in 1/p_f and blind to cells."""

import numpy as np
import pytest
from problem_checks import check

from hybrid.runtime.errors import StepError
from hybrid.step import iteration
from hybrid.study.precision.problems import platen


def rate(found, error):
    """Power of the penalty factor that an error of two runs, with 50 and 1000 /m, falls with."""
    return np.log(found[0].errors[error] / found[1].errors[error]) / np.log(20)


def test_contract():
    check(platen.PROBLEM)


@pytest.mark.parametrize("error", ["force", "height"])
def test_error_falls_with_the_penalty(error, recorded):
    assert rate(recorded(platen, "penalty"), error) == pytest.approx(1.0, abs=0.05)


def test_along_default_only_the_penalty_is_seen(recorded):
    """The cube is pressed evenly, and p_f = 2000/h: springs in series say what is left."""
    coarse, fine = (r.errors for r in recorded(platen, "default"))
    for cell, found in ((0.4, coarse), (0.2, fine)):
        assert found["force"] == pytest.approx(1 - platen.in_series(2000 / cell)[0] / platen.IDEAL, rel=1e-3)
    assert max(coarse["springs"], fine["springs"]) < 1e-5


def test_a_wrong_ideal_is_found(monkeypatch, replayed):
    monkeypatch.setattr(platen, "IDEAL", 1.05 * platen.IDEAL)
    assert abs(rate(replayed(platen, "penalty"), "force")) < 0.5


def test_a_failure_is_raised(monkeypatch):
    monkeypatch.setattr(iteration, "MOST", 1)
    with pytest.raises(StepError):
        platen.solve(solver={"tolerance": 1e-14})
