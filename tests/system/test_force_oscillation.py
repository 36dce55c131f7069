"""A contact force that oscillates is reported once, not with a scheme that damps; without inertia, one that scatters."""

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


def scattered(forces, rates=None, plastic=True):
    """Notes about a box that is driven down without inertia under these forces [N], at these rates [m/s]."""
    body = SimpleNamespace(name="box", driven=np.arange(6) == 2)
    law, scheme = SimpleNamespace(plastic=plastic), SimpleNamespace(damps=True, inertia=False)
    model = SimpleNamespace(bodies=[body], soil=SimpleNamespace(law=law, held=False))
    monitor, found = ForceOscillation(model, None), []
    for step, force in enumerate(forces):
        contact = SimpleNamespace(resultant=np.array([0.0, 0.0, force]))
        report = SimpleNamespace(evaluation=SimpleNamespace(contacts=(contact,)))
        motion = SimpleNamespace(velocity=np.array([0.0, 0.0, -0.1 if rates is None else rates[step]]), spin=np.zeros(3))
        found += monitor.notes(StepView(model, SimpleNamespace(time=step, bodies=[motion]), scheme, report, {}))
    return found


def test_a_force_without_inertia_that_scatters_is_reported_once():
    jumps = 1e3 + 30.0 * np.tile([-1.0, 1.0], 10)
    text, = scattered(jumps)
    assert "scatters: up to t = 11 s it deviates by 5%" in text and "limit 4%" in text
    assert not scattered(1e3 + 0.5 * (jumps - 1e3)) and not scattered(np.linspace(0.0, 1e3, 20))


def test_a_rise_to_a_plateau_is_no_scatter():
    """Of a bar in clay, whose forces deviate by 6 % from a straight line and reverse five times by less than a per cent."""
    forces = [35.16, 42.18, 45.92, 47.78, 48.51, 48.05, 48.31, 47.86, 48.38, 48.71, 49.29, 48.91]
    assert force_oscillation.oscillation(forces)[1] == 5 and not scattered(forces)


@pytest.mark.parametrize("other", [{"rates": 0.1 * np.tile([-1.0, 1.0], 10)}, {"rates": np.zeros(20)}, {"plastic": False}])
def test_bodies_that_are_moved_to_and_fro_or_held_and_elastic_soil_are_not_judged(other):
    assert not scattered(1e3 + 70.0 * np.tile([-1.0, 1.0], 10), **other)
