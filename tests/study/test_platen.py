"""The platen of a study: the error is the overlap of the penalty, of first order in 1/p_f and blind to cells."""

import numpy as np
import pytest

from hybrid.errors import StepError
from hybrid.study.problems import platen
from problem_checks import check


def errors(error, *penalties, **values):
    return np.array([platen.solve(penalty=p, **values).errors[error] for p in penalties])


def rate(error):
    return np.log10(np.divide(*errors(error, 100.0, 1000.0)))


def test_contract():
    check(platen)


@pytest.mark.parametrize("error", ["force", "height"])
def test_error_falls_with_the_penalty(error):
    assert rate(error) == pytest.approx(1.0, abs=0.05)


def test_along_default_only_the_penalty_is_seen():
    """Cells change nothing: the cube is pressed evenly. Springs in series say what is left."""
    coarse, fine = (platen.solve(cell=cell).errors for cell in (0.4, 0.2))
    assert coarse["force"] == pytest.approx(fine["force"], rel=1e-4)
    assert coarse["force"] == pytest.approx(1 - platen.in_series(50.0)[0] / platen.IDEAL, rel=1e-4)
    assert max(coarse["springs"], fine["springs"]) < 1e-5


def test_a_wrong_ideal_is_found(monkeypatch):
    monkeypatch.setattr(platen, "IDEAL", 1.05 * platen.IDEAL)
    assert abs(rate("force")) < 0.5


def test_multipliers_have_no_springs():
    found = platen.solve(enforcement="augmented").errors
    assert np.isnan(found["springs"]) and found["force"] < 1e-4


def test_a_failure_is_raised():
    with pytest.raises(StepError):
        platen.solve(solver={"tolerance": 1e-14, "iterations": 1})
