"""The shaken wave as a problem of a study."""

import problem_checks
import pytest

from hybrid.runtime.errors import HybridError
from hybrid.step import iteration
from hybrid.study.precision.problems import manufactured


def test_default_is_of_second_order(recorded):
    found = recorded(manufactured, "default")
    assert problem_checks.orders(found, "displacement")[-1] == pytest.approx(2.0, abs=0.15)
    assert problem_checks.orders(found, "stress")[-1] > 1.7
    errors = set(manufactured.PROBLEM.errors)
    assert all(set(f.errors) == errors and f.newton and f.unknowns and f.time > 0 for f in found)


def test_standard_points_have_no_order(recorded):
    assert problem_checks.orders(recorded(manufactured, "standard MPM"), "displacement")[-1] < 0


def test_a_wrong_answer_is_seen(monkeypatch):
    """With the body force of soil a tenth stiffer nothing converges."""
    def force(self, t, X):
        return self.motion(t, X)[2] - 1.1 * self.divergence(t, X) / manufactured.DENSITY

    monkeypatch.setattr(manufactured.Wave, "force", force)
    found = problem_checks.solved(manufactured, "default", last=2)
    assert problem_checks.orders(found, "displacement")[-1] < 0.7 and found[-1].errors["displacement"] > 0.02


def test_the_error_distinguishes_schemes():
    """On one grid in 32 steps the dissipative pair of first order is three times as wrong and more."""
    pairs = [manufactured.solve(cells=32, steps=32, scheme=scheme)
             for scheme in ({"scheme": "newmark"}, {"beta": 0.5625, "gamma": 1.0})]
    assert pairs[1].errors["displacement"] > 3 * pairs[0].errors["displacement"]


def test_no_iterations_fail(monkeypatch):
    monkeypatch.setattr(iteration, "MOST", 1)
    with pytest.raises(HybridError):
        manufactured.solve(cells=8, steps=4, solver={"tolerance": 1e-14})


def test_labels_and_values():
    problem_checks.check(manufactured.PROBLEM)
