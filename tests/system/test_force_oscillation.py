"""A contact force that oscillates is reported once; not with a scheme that damps, nor without inertia."""

from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.monitors import StepView, force_oscillation
from hybrid.monitors.force_oscillation import ForceOscillation
from hybrid.study.failure.registry import MODES


@pytest.mark.parametrize("method, count", [
    ("Newmark", 1), ("generalised-alpha, ρ∞ = 0", 0), ("Newmark (0.5625, 1)", 0)])
def test_a_plate_on_a_column(method, count):
    found = MODES["force_oscillation"].observe(method, (2.0,))
    assert len(found.messages) == count and (found.error > 0.25) == bool(count)
    assert all("limit 60%" in text and "reverses 8 times" in text and "time.scheme" in text
               for text in found.messages)


@pytest.mark.parametrize("force, oscillates", [
    (np.tile([0.0, 2.0], 6), True), (1 + 0.5 * np.tile([-1.0, 1.0], 6), False), (np.zeros(12), False),
    (np.linspace(0.0, 9.0, 12), False), (np.repeat([0.0, 2.0], 6), False)])
def test_which_forces_oscillate(force, oscillates):
    deviation, reversals = force_oscillation.oscillation(list(force))
    assert (deviation > force_oscillation.LIMIT and reversals >= force_oscillation.REVERSALS) == oscillates


def test_a_force_that_comes_and_goes_once_is_no_oscillation():
    """It deviates as much from a straight line, but reverses no more than twice."""
    model = SimpleNamespace(bodies=[SimpleNamespace(name="box")])
    scheme, monitor = SimpleNamespace(damps=False, inertia=True), ForceOscillation(model, None)
    for step in range(24):
        force = np.array([0.0, 0.0, 1e3 * (8 <= step < 10)])
        report = SimpleNamespace(evaluation=SimpleNamespace(contacts=(SimpleNamespace(resultant=force),)))
        state = SimpleNamespace(time=step, bodies=[None])
        assert monitor.notes(StepView(model, state, scheme, report, {})) == ()
