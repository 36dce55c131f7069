"""The monitor of impacts: what falling bodies lose over many steps is reported, and what others bring or store is not."""

from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.monitors import StepView
from hybrid.monitors.absorbed_impact import AbsorbedImpact


def notes(errors, elastic=0.0, plastic=True, first_order=False, inertia=True, **energy):
    """Of steps with these errors [J] of a body of 2 kg that falls with 10 m/s, 100 J, and stands still from the second step on."""
    body = SimpleNamespace(mass=SimpleNamespace(mass=2.0, inertia=np.eye(3)))
    model = SimpleNamespace(bodies=(body,), soil=SimpleNamespace(held=False, law=SimpleNamespace(plastic=plastic)))
    monitor, found = AbsorbedImpact(None, None), []
    for time, error in enumerate(errors):
        motion = SimpleNamespace(velocity=np.array([0.0, 0.0, 0.0 if time else -10.0]), spin=np.zeros(3), rotation=np.eye(3))
        found += monitor.notes(StepView(
            model=model, state=SimpleNamespace(time=float(time), bodies=(motion,)), scheme=SimpleNamespace(inertia=inertia, first_order=first_order),
            report=SimpleNamespace(evaluation=SimpleNamespace(contacts=(None,), pairs=None)),
            energy={"kinetic": 0.0 if time else 100.0, "elastic": elastic, "contact": 0.0, "error": error} | energy))
    return found


def test_small_losses_that_add_up_are_reported_once():
    assert notes([0.0, -7.0, -14.0]) == []
    text, = notes([0.0, -7.0, -16.0, -24.0])
    assert "16 J of the 100 J" in text and "t = 2 s (16%, limit 15%)" in text and "smaller cells" in text


@pytest.mark.parametrize("other", [{"drive": 1.0}, {"pull": -1.0}, {"elastic": 150.0}, {"plastic": False}, {"first_order": True},
                                   {"inertia": False}])
def test_other_energies_make_no_impact(other):
    """Work from outside, soil that stores more than falls, elastic soil, schemes that are meant to damp, no inertia."""
    assert notes([0.0, -40.0], **other) == []
