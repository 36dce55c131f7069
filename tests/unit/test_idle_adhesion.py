"""The monitor of clay that touches a body and has too little pressure to bear its adhesion."""

from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.monitors import StepView
from hybrid.monitors.idle_adhesion import STEPS, IdleAdhesion


def notes(pressures, adhesion=1.0, tension=0.0, friction=np.inf, heavy=False):
    """Of steps in which two contact points of 1 and 3 kN of adhesion have these pressures [N]; a third one is open."""
    body = SimpleNamespace(name="lid", interface=SimpleNamespace(adhesion=adhesion, tension=tension), friction=friction)
    model, found = SimpleNamespace(bodies=(body,), gravity=np.array([0.0, 0.0, -9.81 * heavy])), []
    points = SimpleNamespace(limits=SimpleNamespace(shear=np.array([1e3, 9e9, 3e3])))
    monitor = IdleAdhesion(model, None)
    for time, pressure in enumerate(pressures):
        contact = SimpleNamespace(active=np.array([0, 2]), pressure=np.array(pressure))
        terms = SimpleNamespace(step=SimpleNamespace(pair=SimpleNamespace(points=points)))
        report = SimpleNamespace(evaluation=SimpleNamespace(contacts=[contact], bodies=[terms]))
        found += monitor.notes(StepView(model, SimpleNamespace(time=time, bodies=(None,)), None, report, {}))
    return found


def test_a_lid_that_nothing_presses_is_reported_once():
    text, = notes([(1.0, -5.0)] * (STEPS + 3))
    assert "lid mobilises at most 10 N of its adhesion to the clay that it touches, 4e+03 N (0%, limit 60%)" in text
    assert "at t = 2 s" in text
    assert "gravity" in text and "body.tension" in text
    text, = notes([(1.0, -5.0)] * STEPS, heavy=True)
    assert "gravity" not in text and "Press the body on" in text


@pytest.mark.parametrize("pressures, given", [
    ([(60.0, 200.0)] * 9, {}), (([(1.0, 1.0)] * (STEPS - 1) + [(60.0, 200.0)]) * 3, {}),
    ([(1.0, 1.0)] * 9, {"adhesion": None}),
    ([(1.0, 1.0)] * 9, {"tension": 5e3}), ([(1.0, 1.0)] * 9, {"friction": 0.25}), ([(1.0, 1.0)] * 9, {"friction": 0.0})],
    ids=["pressed", "in between", "no adhesion", "a bond", "friction", "smooth"])
def test_others_are_not(pressures, given):
    assert notes(pressures, **given) == []
