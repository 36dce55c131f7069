"""A contact force that rings is told of once; damped by the scheme it is not, nor where time is the order of events."""

from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.monitors import force_oscillation
from hybrid.monitors.force_oscillation import Ringing
from hybrid.study.failures import ringing as case


@pytest.mark.parametrize("method, count", [
    ("Newmark", 1), ("generalised-alpha, ρ∞ = 0", 0), ("Newmark (0.5625, 1)", 0)])
def test_a_plate_on_a_column(method, count):
    found = case.solve(2.0, **case.METHODS[method])
    assert len(found.told) == count and (found.error > 0.25) == bool(count)
    assert all("limit 60%" in text and "turns 8 times" in text and "spectral_radius = 0" in text for text in found.told)


@pytest.mark.parametrize("force, rings", [
    (np.tile([0.0, 2.0], 6), True), (1 + 0.5 * np.tile([-1.0, 1.0], 6), False), (np.zeros(12), False),
    (np.linspace(0.0, 9.0, 12), False), (np.repeat([0.0, 2.0], 6), False)])
def test_what_ringing_is(force, rings):
    swing, turns = force_oscillation._swing(list(force))
    assert (swing > force_oscillation.LIMIT and turns >= force_oscillation.TURNS) == rings


def test_a_force_that_comes_and_goes_once_does_not_ring():
    """As large a swing about a straight line, but it turns no more than twice."""
    model = SimpleNamespace(bodies=[SimpleNamespace(name="box")])
    scheme, watched = SimpleNamespace(damps=False, inertia=True), Ringing()
    for step in range(24):
        force = np.array([0.0, 0.0, 1e3 * (8 <= step < 10)])
        told = watched.notes(model, SimpleNamespace(time=step), [SimpleNamespace(force=force)], scheme)
        assert told == ()
