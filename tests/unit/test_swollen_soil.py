"""The monitor of sand that has opened and not closed: its volume under pressure counts, and that of other soil does not."""

from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.laws.hencky import Hencky
from hybrid.laws.mohr_coulomb import MohrCoulomb
from hybrid.laws.von_mises import VonMises
from hybrid.monitors import StepView
from hybrid.monitors.swollen_soil import EVERY, SwollenSoil

YOUNG = np.full(4, 1e7)
SAND = MohrCoulomb(YOUNG, 0.3, 33.0, 0.0, 0.0)
DILATING = MohrCoulomb(YOUNG, 0.3, 33.0, 5.0, 0.0)
SWELLING = np.array([1.0, 1.0, 1.04, 1.3])


def notes(law=SAND, volumes=SWELLING, pressures=(1e3, 1e3, 1e3, -1.0), step=EVERY, inertia=True, held=False, last=False,
          inactive=None):
    """Of four points of these volumes, over those at the start, and pressures [Pa]."""
    points = SimpleNamespace(stress=-np.array(pressures)[:, None, None] * np.eye(3), inactive=inactive,
                             deformation=np.cbrt(volumes)[:, None, None] * np.eye(3))
    soil = SimpleNamespace(held=held, law=law, constants=SimpleNamespace(volume=np.full(4, 0.5)))
    return SwollenSoil(None, None).notes(StepView(
        SimpleNamespace(soil=soil), SimpleNamespace(points=points, step=step, time=2.0), SimpleNamespace(inertia=inertia),
        None, {}, last))


def test_sand_that_carries_pressure_swollen_is_reported():
    text, = notes(volumes=np.array([1.0, 1.1, 1.2, 1.4]))
    assert "at t = 2 s has 1.10 of its volume at the start, limit 1.02" in text
    assert notes() == () and len(notes(pressures=[1e3] * 4)) == 1       # only what is pressed counts
    assert len(notes(pressures=[1e3] * 4, step=1, last=True)) == 1


def test_sand_that_dilates_may_swell_more():
    """It is told from 1.1 of its volume on."""
    more = np.array([1.2, 1.2, 1.1, 1.4])
    assert "limit 1.1." in notes(DILATING, volumes=more)[0] and notes(DILATING, volumes=0.9 * more) == ()


@pytest.mark.parametrize("other", [
    {"law": DILATING}, {"law": VonMises(YOUNG, 0.3, np.full(4, 1e4), "plane strain")},
    {"law": Hencky(YOUNG, 0.3)}, {"law": SimpleNamespace(plastic=True)}, {"step": 1}, {"inertia": False}, {"held": True},
    {"inactive": np.array([False, False, False, True])}])
def test_other_soil_may_have_another_volume(other):
    """Sand that dilates, clay, elastic soil, a law of the user, between looks, without inertia, held, out of the grid."""
    assert notes(**{"pressures": [1e3] * 4} | other) == ()
