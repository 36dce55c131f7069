"""The cantilever as a problem of a study."""

import problem_checks
import pytest

from hybrid.errors import HybridError
from hybrid.study.problems import cantilever


def solved(curve):
    return problem_checks.solved(cantilever, curve)


def test_defaults_fail():
    """Without the ghost penalty and with a line search it stops at its second step."""
    for _, values in cantilever.curves(True)["default"]:
        with pytest.raises(HybridError, match="step [12] failed"):
            cantilever.solve(**values)


def test_gimp_converges():
    found = solved("GIMP, ghost")
    assert (problem_checks.orders(found, "tip") > 0.8).all()
    assert set(found[0].errors) == set(cantilever.ERRORS) and found[-1].unknowns > found[0].unknowns > 0


def test_standard_points_do_not():
    assert problem_checks.orders(solved("standard MPM"), "shortening").max() < 0.5


def test_a_wrong_answer_is_seen(monkeypatch):
    """Nothing converges to the elastica."""
    elastica = cantilever.elastica()
    monkeypatch.setattr(cantilever, "hencky_beam", lambda: elastica)
    settings = dict(cantilever.curves(True)["GIMP, ghost"])
    found = [cantilever.solve(**settings[f"h = {size} m"]) for size in (0.5, 0.25)]
    assert problem_checks.orders(found, "tip")[0] < 0.5 and found[-1].errors["tip"] > 0.02


def test_labels_and_values():
    problem_checks.check(cantilever)
