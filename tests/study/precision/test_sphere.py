"""The rolling sphere of a study: errors of corners fall with their spacing, contact on faces is right on any."""

import numpy as np
import pytest
from problem_checks import check

from hybrid.runtime.errors import StepError
from hybrid.step import iteration
from hybrid.study.precision.problems import sphere
from hybrid.study.precision.settings import PUBLISHED


def rates(found):
    coarse, fine = (f.errors for f in found)
    return {name: np.log2(coarse[name] / fine[name]) for name in sphere.PROBLEM.errors}


def test_contract():
    check(sphere.PROBLEM, sphere.rides)


@pytest.mark.slow
def test_errors_fall_with_the_spacing_of_corners(recorded):
    """Measured against a smooth sphere: orders 3.1 of the distance and 1.2 of the spin."""
    assert all(rate > 1.0 for rate in rates(recorded(sphere, PUBLISHED)).values())


@pytest.mark.slow
def test_contact_on_faces_needs_no_fine_spacing(recorded):
    """Measured: 0.02 % of the distance and 0.1 % of the spin at the paper's spacing."""
    assert all(error < 0.003 for error in recorded(sphere, "default")[0].errors.values())


def test_a_wrong_law_is_found(monkeypatch, replayed):
    """A sphere that has no inertia of turning goes 40 % farther when it rolls."""
    right = sphere.law
    monkeypatch.setattr(sphere, "law", lambda mu, time: (1.4 * right(mu, time)[0], 0.6 * right(mu, time)[1]))
    assert all(abs(rate) < 0.3 for rate in rates(replayed(sphere, PUBLISHED)).values())


def test_what_is_counted(quick, recorded):
    counted = recorded(sphere, "default")[0]
    size, rides = quick.again[sphere](**counted.values)
    assert counted.newton == sum(ride.newton for ride in rides)
    assert size == 6 and len(rides) == 4 and [ride.mu for ride in rides] == [0.2, 0.2, 0.4, 0.4]
    assert all(ride.newton >= 100 and ride.seconds > 0 and ride.time == pytest.approx(1.0) for ride in rides)


def test_a_failure_is_raised(monkeypatch):
    monkeypatch.setattr(iteration, "MOST", 1)
    with pytest.raises(StepError):
        sphere.solve(changes=["time.smallest=0.01"])
