"""The monitor of motion that the time integration damps where bodies touch nothing."""

from types import SimpleNamespace

import pytest

from hybrid.monitors import DampedFlight, StepView
from hybrid.scheme import Scheme


def notes(errors, kinetic=10.0, touching=(), held=True, line=None, scheme=None, joints=("pin",)):
    """Of steps with these errors of the balance [J], of which those numbered `touching` have contact."""
    body = SimpleNamespace(line=line)
    model = SimpleNamespace(bodies=(body,), soil=SimpleNamespace(held=held), joints=joints)
    monitor, found = DampedFlight(None, None), []
    for step, error in enumerate(errors, 1):
        report = SimpleNamespace(error=None, evaluation=SimpleNamespace(contacts=([0] * (step in touching),), pairs=None))
        view = StepView(model, SimpleNamespace(step=step, time=0.1 * step), scheme or Scheme.default(), report,
                        {"error": error, "kinetic": kinetic})
        found += monitor.notes(view)
    return found


FADES = [-0.2 * n for n in range(20)]


def test_energy_that_bodies_in_flight_lose_is_told_with_its_share():
    text, = notes(FADES)
    assert "has taken 12% of the largest kinetic energy, limit 10%" in text and "up to t = 1.1 s" in text
    assert "time.accuracy = 1e-3" in text


@pytest.mark.parametrize("errors, more", [
    (FADES[:10], {}), (FADES, {"joints": ()}), ([0.0] * 9 + [-1.5] * 9 + [-3.0] * 9, {}),
    ([-value for value in FADES], {}), (FADES, {"touching": range(5, 20, 5)}), (FADES, {"held": False}),
    (FADES, {"line": "a line"}), (FADES, {"scheme": Scheme(inertia=False)}),
    (FADES, {"scheme": Scheme.newmark(0.5625, 1.0)})])
def test_other_losses_are_not(errors, more):
    """Little; free bodies; impacts within a step; a gain; contact a moment ago; soil that deforms; a line; no inertia; a
    scheme of first order."""
    assert notes(errors, **more) == []
