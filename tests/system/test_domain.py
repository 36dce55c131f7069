"""The soil around the anchor's path is large enough: twice as much of it hardly changes the force."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from hybrid.build import build


def contact_impulse(margin, drag_steps):
    """Mean horizontal and vertical contact force [N] over settling and drag of the coarse anchor."""
    path = Path(__file__).parents[2] / "demos" / "anchor.py"
    spec = importlib.util.spec_from_file_location("anchor_demo", path)
    demo = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(demo)
    records = list(build(demo.coarse_anchor(drag_steps, margin)).steps())
    force = np.array([r.bodies[0].contact_force for r in records])
    return force[25:, 0].mean() if drag_steps > 1 else force[:25, 2].max()


def test_landing_force_on_twice_the_soil():
    once, twice = contact_impulse(1.0, 1), contact_impulse(2.0, 1)
    assert abs(twice / once - 1) < 0.05


@pytest.mark.slow
def test_drag_force_on_twice_the_soil():
    once, twice = contact_impulse(1.0, 50), contact_impulse(2.0, 50)
    assert abs(twice / once - 1) < 0.05
