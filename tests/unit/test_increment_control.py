"""Lengths of increments: after trials that converge easily or hardly, are rejected, or are not accurate."""

from types import SimpleNamespace

import pytest

from hybrid.step import increments
from hybrid.step.error_estimate import GROW, SAFETY, SHRINK, LocalError, even, following, shorter
from hybrid.step.increments import EASY, Control

LENGTH, ACCURACY = 1.0, 1e-3


def test_lengths_by_the_ratio_of_errors():
    """Δt ρ^(-1/2) with a margin, within limits; only where it may grow does it grow."""
    assert shorter(2.0, 4.0) == pytest.approx(SAFETY) and shorter(1.0, 1e6) == SHRINK
    assert following(1.0, 0.25, True) == pytest.approx(2 * SAFETY) and following(1.0, 0.25, False) == 1.0
    assert following(1.0, 1e-9, True) == following(1.0, 0.0, True) == GROW
    assert following(1.0, 1.0, True) == following(1.0, 1.0, False) == SAFETY


def test_no_tiny_increment_is_left_at_the_end():
    assert even(0.3, 1.0) == 0.25 and even(0.5, 1.0) == 0.5 and even(0.5 * (1 - 1e-12), 1.0) == 0.5
    assert even(2.0, 1.0) == 1.0


def judged(control, dt, iterations=EASY, converged=True, backtracked=False):
    """Whether a trial of `dt` is accepted."""
    return control.judge(SimpleNamespace(dt=dt, bodies=()), SimpleNamespace(
        converged=converged, iterations=iterations, evaluation=None, judged=False, backtracked=backtracked))[0]


def test_convergence_halves_and_doubles():
    control = Control(LENGTH, 0.01)
    control.begin(LENGTH)
    assert not judged(control, 1.0, converged=False) and control.dt == control.increment(1.0) == 0.5
    assert judged(control, 0.5, EASY + 1) and control.dt == 0.5
    assert judged(control, 0.5) and judged(control, 1.0) and control.dt == LENGTH      # no longer than the outer step


def test_shorter_updates_are_remembered_until_an_increment_does_without():
    control = Control(LENGTH, 0.01)
    control.begin(LENGTH)
    for backtracked in (False, True, False):
        for converged in (False, True):
            judged(control, 0.5, converged=converged, backtracked=backtracked)
            assert control.backtrack == (converged and backtracked)     # where these fail, too, all ways are tried again


def test_accuracy_sets_the_next_increment_and_a_rejected_trial_stops_its_growth(monkeypatch):
    """Errors that go with Δt³, of which an increment may add its share Δt/T of the accuracy."""
    factor = 16 * ACCURACY
    monkeypatch.setattr(increments, "local_error", lambda step, _: LocalError(factor * step.dt**3, "a body"))
    control = Control(LENGTH, 1e-3, ACCURACY)
    control.begin(LENGTH)
    assert not judged(control, 1.0) and control.dt == pytest.approx(SAFETY / 4)
    assert judged(control, 0.1) and control.dt == pytest.approx(0.1)                   # 0.225 if it might grow
    assert judged(control, 0.1) and control.dt == pytest.approx(0.1 * GROW)
    assert judged(control, 0.1, EASY + 1) and control.dt == pytest.approx(0.1)         # hard for Newton's method
    assert judged(control, 0.24) and control.dt == pytest.approx(SAFETY / 4)
