"""The tumbling body of a study: every scheme has its order, and a wrong attitude is found."""

from dataclasses import replace

import numpy as np
import pytest
from problem_checks import check

from hybrid.body.motion import inertia_residual
from hybrid.runtime.errors import StepError
from hybrid.study.precision.problems import tumbling

CURVES = tumbling.curves(False)


def rates(curve):
    """Of attitude and spin between the third and the fourth setting."""
    coarse, fine = (tumbling.solve(**values).errors for _, values in CURVES[curve][2:4])
    return np.array([np.log2(coarse[name] / fine[name]) for name in tumbling.PROBLEM.errors])


def test_contract():
    check(tumbling.PROBLEM)


@pytest.mark.parametrize("curve", CURVES)
def test_errors_fall_with_the_order_of_the_scheme(curve):
    assert rates(curve) == pytest.approx(1.0 if curve == "Newmark (0.5625, 1)" else 2.0, abs=0.1)


def test_a_wrong_body_is_found(monkeypatch):
    """The reference of a body whose largest moment of inertia is 1 % off."""
    right = tumbling.reference
    monkeypatch.setattr(tumbling, "reference", lambda top, duration: right(
        replace(top, inertia=top.inertia * np.diag([1.0, 1.0, 1.01])), duration))
    assert (rates("default") < 1.0).all()


def test_updates_are_counted():
    """Newton's method is quadratic: two to four updates a step, the last of which is below the tolerance."""
    found = tumbling.solve("energy-momentum", 100)
    assert found.unknowns == 3 and 200 <= found.newton <= 500 and found.seconds > 0


def test_a_failure_is_raised():
    def away(mass, inertia, *step):
        residual, tangent = inertia_residual(mass, inertia, *step)
        return residual, -tangent

    with pytest.raises(StepError, match="no convergence"):
        tumbling.after(tumbling.TUMBLING, 10.0, 5, tumbling.SCHEMES["energy-momentum"], inertia_of=away)
