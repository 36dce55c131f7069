"""The column of 50 m as a problem of a study."""

import problem_checks
import pytest

from hybrid.errors import HybridError
from hybrid.study.problems import column


def solved(curve):
    return problem_checks.solved(column, curve)


def test_default_converges():
    found = solved("default")
    assert (problem_checks.orders(found, "stress") > 1.5).all() and set(found[0].errors) == set(column.ERRORS)
    assert all(f.newton >= 40 and f.unknowns > 0 and f.seconds > 0 for f in found)


def test_standard_points_do_not():
    assert problem_checks.orders(solved("standard MPM"), "stress").max() < 0.2


def test_a_wrong_answer_is_seen(monkeypatch):
    """Against the height of a column 1 % stiffer nothing converges."""
    stiffer = column.Column(50.0, 1.01e4, 80.0, 10.0, 40).height()
    monkeypatch.setattr(column.Column, "height", lambda self: stiffer)
    found = solved("default")
    assert problem_checks.orders(found, "height")[-1] < 0.5 and found[-1].errors["height"] > 1e-3


def test_no_iterations_fail():
    with pytest.raises(HybridError):
        column.solve(cells=8, solver={"iterations": 1, "tolerance": 1e-12})


def test_labels_and_values():
    problem_checks.check(column)


def test_the_peer_agrees():
    """Two programs, one discretisation: errors the same within a hundredth, iterations within a tenth."""
    theirs = {r.setting: r for r in column.peers() if r.curve == "AMPLE, GIMP"}
    for (setting, _), ours in zip(column.curves(True)["default"], solved("default")):
        assert ours.errors["stress"] == pytest.approx(theirs[setting].errors["stress"], rel=0.01)
        assert ours.newton == pytest.approx(theirs[setting].newton, rel=0.1)
        assert theirs[setting].unknowns == 2 * ours.unknowns and theirs[setting].source
