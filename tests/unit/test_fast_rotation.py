"""The monitor of bodies that an impact has set spinning."""

from ast import literal_eval
from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.monitors import FastRotation, StepView
from hybrid.scheme import Scheme

PLATE = SimpleNamespace(name="plate", free=np.ones(6, bool), mass=SimpleNamespace(inertia=np.diag([1.0, 2.0, 3.0])))
GUIDE = SimpleNamespace(name="guide", free=np.zeros(6, bool), mass=PLATE.mass)
ASKEW = np.array([0.6, 0.0, 0.8])


def notes(spins, dt=0.01, joints=(), error=None, inertia=True, monitor=None):
    """Of steps of `dt` [s] with these spins (3,) [rad/s] of the plate, beside a guide."""
    monitor, found = monitor or FastRotation(None, None), []
    still = SimpleNamespace(spin=np.zeros(3))
    model = SimpleNamespace(bodies=(PLATE, GUIDE), joints=[SimpleNamespace(bodies=pair) for pair in joints])
    for step, spin in enumerate(spins, 1):
        report = SimpleNamespace(dt=dt, error=error, evaluation=SimpleNamespace(contacts=(None, None)))
        state = SimpleNamespace(step=step, time=step * dt, bodies=(SimpleNamespace(spin=np.array(spin)), still))
        found += monitor.notes(StepView(model, state, Scheme.generalised_alpha(0.0) if inertia else SimpleNamespace(
            inertia=False), report, {}))
    return found


STRUCK = [0.0 * ASKEW, *[40.0 * ASKEW] * 60]


def test_a_body_that_tumbles_after_an_impact_is_told_once():
    text, = notes(STRUCK)
    assert text.startswith("plate tumbles, by 0.4 rad a step at t = 0.26 s, limit 0.2 rad for generalised alpha")
    assert "smaller time.step" in text and len(notes(STRUCK[:25])) == 0


@pytest.mark.parametrize("spins, more", [
    ([spin * 0.45 for spin in STRUCK], {}), ([np.linalg.norm(spin) * np.eye(3)[2] for spin in STRUCK], {}),
    (STRUCK[1:], {}), (STRUCK, {"joints": [(0, None)]}), (STRUCK, {"joints": [(0, 1)]}), (STRUCK, {"error": 1e-6}),
    (STRUCK, {"inertia": False})])
def test_others_are_not(spins, more):
    """Slower; about an axis of inertia; from the start, which `check` tells; on a hinge; with time.accuracy."""
    assert notes(spins, **more) == []


def test_what_it_remembers_can_be_read_again():
    """A number that is not finite cannot, and all monitors of a resumed run would begin afresh."""
    monitor = FastRotation(None, None)
    notes(STRUCK[1:], monitor=monitor)
    memory = monitor.memory()
    assert memory["_from_start"] == [0] and literal_eval(repr(memory)) == memory
