"""A strip footing at the crest of a clay slope (demos/crest.toml), on ground that is not level.

Upper bound of limit analysis, with Prandtl's fan cut short by the slope β: a wedge of area B²/4 under the footing goes
down at 45° with the velocity √2 V, the fan of radius B/√2 turns it by π/2 - β, and a wedge of area B²/4 leaves along the
slope.

    dissipation   (2 + π - 2β) s_u B V      work of the weight   ½ γ B² V sin β
    q / s_u = 2 + π - 2β - (γ B / 2 s_u) sin β

Quick form in cells of 0.25 m, 8 in the width: 4.25 (3.92), and 3.10 (3.10) on a slope of 45°; the scene itself, 4.12.
"""

import functools
from pathlib import Path

import numpy as np
import pytest

from hybrid.scene.file import load_scene
from hybrid.setup.build import build

DEMO = Path(__file__).parents[2] / "demos" / "crest.toml"
COARSE = ["grid.x.size=0.25", "grid.z.size=0.25", "body.footing.velocity=[0, 0, -0.005]", "stage.0.steps=14"]
WIDTH, STRENGTH, WEIGHT = 2.0, 25e3, 1700.0 * 9.81


def bound(slope):
    return 2 + np.pi - 2 * slope - WEIGHT * WIDTH / (2 * STRENGTH) * np.sin(slope)


def work_of_the_weight(slope, n=400):
    """∫ γ·v dA / (γ B² V) of the mechanism, by the areas and velocities of the wedges and of n sectors of the fan."""
    turn = np.pi / 2 - slope
    angle = -np.pi / 4 + (np.arange(n) + 0.5) * turn / n
    up = [0.25 * np.sin(-np.pi / 4), np.sum(0.25 * turn / n * np.sin(angle)), 0.25 * np.sin(np.pi / 4 - slope)]
    return -np.sqrt(2) * sum(up)


@functools.cache
def pressed(*more):
    simulation = build(load_scene(DEMO, [*COARSE, *more]))
    return simulation, max(record.bodies[0].contact_force[2] for record in simulation.steps()) / (WIDTH * STRENGTH)


@pytest.mark.parametrize("slope", [0.2, np.arctan(0.5), 0.9])
def test_the_work_of_the_weight_is_that_of_its_formula(slope):
    assert work_of_the_weight(slope) == pytest.approx(0.5 * np.sin(slope), rel=1e-4)


@pytest.mark.parametrize("run, drop", [(6.0, 3.0), (4.0, 4.0)])
def test_load_at_the_crest(run, drop):
    simulation, factor = pressed(f"soil.ground=[[0.0, 0.0], [{run}, {-drop}]]")
    assert factor == pytest.approx(bound(np.arctan(drop / run)), rel=0.1)
    assert simulation.start["settled at the start"].startswith("quasi-static, from 1")       # per cent of the weight
    assert simulation.imbalance.share < 2e-3


def test_a_slope_takes_the_share_of_the_load_that_theory_says():
    slope, level = (pressed(f"soil.ground=[[0.0, 0.0], [6.0, {end}]]")[1] for end in (-3.0, 0.0))
    assert slope / level == pytest.approx(bound(np.arctan(0.5)) / bound(0.0), rel=0.06)
