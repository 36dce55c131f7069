"""The monitor of motion that the time integration damps where bodies touch nothing."""

from types import SimpleNamespace

import pytest

from hybrid.monitors import DampedFlight, StepView, damped_flight
from hybrid.scheme import Scheme


@pytest.fixture(autouse=True)
def energies(monkeypatch):
    """Kinetic energy [J] of a body: what is given as its motion."""
    monkeypatch.setattr(damped_flight, "kinetic_energy", lambda body, motion: motion)


def notes(errors, moving=(10.0, 0.0), soil=0.0, touching=(), pressed=(), line=None, scheme=None, joints=("pin",),
          stop=0.0, load=0.0):
    """Of steps with these errors of the balance [J], in which two bodies have the kinetic energies `moving`, and those with
    numbers `touching` are in contact with the soil, those `pressed` with each other, every fifth step."""
    body = SimpleNamespace(line=line)
    model, found = SimpleNamespace(bodies=(body, body), joints=joints), []
    monitor = DampedFlight(None, None)
    for step, error in enumerate(errors, 1):
        now = step % 5 == 0
        side = SimpleNamespace(active=[0] * (now and len(pressed)))
        pairs = SimpleNamespace(step=SimpleNamespace(near=[SimpleNamespace(pair=SimpleNamespace(numbers=pressed))]),
                                contacts=[[side]])
        contacts = [[0] * (now and number in touching) for number in range(2)]
        report = SimpleNamespace(error=None, evaluation=SimpleNamespace(contacts=contacts, pairs=pairs))
        state = SimpleNamespace(step=step, time=0.1 * step, bodies=moving)
        energy = {"error": error, "kinetic": sum(moving) + soil, "stop": stop * (step // 5), "load": load * step}
        view = StepView(model, state, scheme or Scheme.default(), report, energy)
        found += monitor.notes(view)
    return found


FADES = [-0.2 * n for n in range(20)]


@pytest.mark.parametrize("given", [{}, {"touching": [1]}, {"pressed": (1,)}])
def test_energy_that_bodies_in_flight_lose_is_told_with_its_share(given):
    """Also beside bodies that rest."""
    text, = notes(FADES, **given)
    assert "has taken 12% of the largest kinetic energy, limit 10%" in text and "up to t = 1.1 s" in text
    assert "time.accuracy = 1e-3" in text


@pytest.mark.parametrize("errors, more", [
    (FADES[:10], {}), (FADES, {"joints": ()}), ([0.0] * 9 + [-3.5] * 9 + [-7.0] * 9, {}),
    ([-value for value in FADES], {}), (FADES, {"touching": [0]}), (FADES, {"pressed": (0, 1)}),
    (FADES, {"soil": 1.0}), (FADES, {"stop": 1.0}), (FADES, {"load": 2.0}),
    (FADES, {"line": "a line"}), (FADES, {"scheme": Scheme(inertia=False)}),
    (FADES, {"scheme": Scheme.newmark(0.5625, 1.0)})])
def test_other_losses_are_not(errors, more):
    """Little; free bodies; impacts within a step; a gain; contact a moment ago; soil that moves; stops; loads;
    a line; no inertia; a scheme of first order."""
    assert notes(errors, **more) == []
