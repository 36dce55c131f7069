"""The cantilever as a problem of a study."""

import re

import problem_checks

from hybrid.study.precision.problems import cantilever


def test_defaults_fail(recorded):
    """Without the ghost penalty and with a line search it stops at its second step."""
    assert all(re.match("step [12] failed", r.reason) for r in recorded(cantilever, "default"))


def test_gimp_converges(recorded):
    found = recorded(cantilever, "GIMP, ghost")
    assert (problem_checks.orders(found, "tip") > 0.8).all()
    assert set(found[0].errors) == set(cantilever.PROBLEM.errors) and found[-1].unknowns > found[0].unknowns > 0


def test_standard_points_do_not(recorded):
    assert problem_checks.orders(recorded(cantilever, "standard MPM"), "shortening").max() < 0.5


def test_a_wrong_answer_is_seen(monkeypatch, replayed):
    """Nothing converges to the elastica."""
    elastica = cantilever.elastica()
    monkeypatch.setattr(cantilever, "hencky_beam", lambda: elastica)
    found = replayed(cantilever, "GIMP, ghost")
    assert problem_checks.orders(found, "tip")[-1] < 0.5 and found[-1].errors["tip"] > 0.02


def test_labels_and_values():
    problem_checks.check(cantilever.PROBLEM)
