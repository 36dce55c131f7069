"""The cantilever as a problem of a study."""

import problem_checks
import pytest

from hybrid.runtime.errors import StepError
from hybrid.study.precision.problems import cantilever


def test_without_the_ghost_penalty_it_fails_on_coarse_cells():
    with pytest.raises(StepError, match=r"step \d+ failed|would leave the grid"):
        cantilever.solve(1.0, soil={"ghost": 0.0})


def test_gimp_converges(recorded):
    found = recorded(cantilever, "no line search")
    assert (problem_checks.orders(found, "tip") > 0.8).all()
    assert set(found[0].errors) == set(cantilever.PROBLEM.errors) and found[-1].unknowns > found[0].unknowns > 0


def test_standard_points_do_not(recorded):
    assert problem_checks.orders(recorded(cantilever, "standard MPM"), "shortening").max() < 0.5


def test_a_wrong_answer_is_seen(monkeypatch, replayed):
    """Nothing converges to the elastica."""
    elastica = cantilever.elastica()
    monkeypatch.setattr(cantilever, "hencky_beam", lambda: elastica)
    found = replayed(cantilever, "no line search")
    assert problem_checks.orders(found, "tip")[-1] < 0.5 and found[-1].errors["tip"] > 0.02


def test_labels_and_values():
    problem_checks.check(cantilever.PROBLEM)
