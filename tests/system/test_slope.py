"""A long slope whose gravity is turned on (demos/slope.toml): the stress of the infinite slope, and when it slides.

At a depth d of the middle  σ_zz = -ρ g d cosθ,  τ_xz = ρ g d sinθ.  The share of gravity at which it slides is bounded
from above by limit analysis (tests/helpers/limit_load.py), whose bounds fall with the first order of the triangles.
"""

import re
from pathlib import Path

import numpy as np
import pytest
from limit_load import share_of_gravity

from hybrid.runtime.errors import SceneError, StepError
from hybrid.scene.file import load_scene
from hybrid.setup.build import build

DEMO = Path(__file__).parents[2] / "demos" / "slope.toml"
COARSE, FINE = ["grid.x.size=1.0", "grid.z.size=0.5"], ["grid.x.size=0.25", "grid.z.size=0.125"]
STEEP, DEPTH, LENGTH, WEIGHT, COHESION = np.radians(20.0), 2.0, 20.0, 1700 * 9.81, 1e3


def slope(*changes):
    return build(load_scene(DEMO, changes))


def errors(simulation, turn=1.0):
    """Root mean square errors of σ_zz and τ_xz in the middle 2 m over their values at the base; turn: of the slope."""
    place, stress = simulation.initial_position, simulation.state.points.stress
    middle = np.abs(place[:, 0] - LENGTH / 2) < 1.0
    depth, stress = DEPTH - place[middle, 2], stress[middle]
    normal, shear = WEIGHT * np.cos(turn * STEEP), WEIGHT * np.sin(turn * STEEP)
    return (np.sqrt(np.mean((stress[:, 2, 2] + normal * depth) ** 2)) / (normal * DEPTH),
            np.sqrt(np.mean((stress[:, 0, 2] - shear * depth) ** 2)) / (shear * DEPTH))


def share_at_sliding(angle):
    """Share of gravity by limit analysis, extrapolated from two bounds at the first order."""
    gravity = WEIGHT * np.array([np.sin(STEEP), -np.cos(STEEP)])
    coarse, fine = (share_of_gravity(gravity, COHESION, np.radians(angle), LENGTH, DEPTH, 20 * k, 4 * k) for k in (1, 2))
    return 2 * fine - coarse


def share_reached(*grid):
    """Share of gravity, in steps of a hundredth, that a slope of 12 degrees carries before it has moved by 8 mm."""
    simulation, reached = slope(*friction(12), *grid, "stage.0.steps=50", "stage.0.gravity=[0.0,0.5]"), 0.0
    try:
        for record in simulation.steps():
            if np.abs(simulation.state.points.position - simulation.initial_position).max() > 8e-3:
                break
            reached = record.step / 100
    except StepError as failure:
        assert re.search(r"residual .* after \d+ iterations.*load exceeds what the soil can carry", str(failure))
    return reached


def friction(angle):
    return [f"soil.material.friction_angle={angle}", f"soil.material.dilation_angle={angle}"]


@pytest.mark.parametrize("law", [[], ["soil.material.dilation_angle=0"]], ids=["associated", "no dilation"])
def test_a_slope_below_its_friction_angle_stands_with_the_stress_of_the_infinite_slope(law):
    """Points carry a cell's mean stress: errors halve with the cells; a slope of 25 degrees is distinguished."""
    found = []
    for grid in (COARSE, []):
        simulation = slope(*grid, *law)
        for record in simulation.steps():
            assert record.rejections == 0 and record.notes == ()
        found.append(errors(simulation))
        assert max(errors(simulation, 1.25)) > 0.1
    assert max(found[1]) < 0.045 and max(found[0]) < 0.08
    assert np.log2(np.divide(*found)) == pytest.approx(1.0, abs=0.2)


@pytest.mark.parametrize("grids", [(COARSE, []), pytest.param((COARSE, [], FINE), marks=pytest.mark.slow)])
def test_a_slope_above_its_friction_angle_slides(grids):
    """At the share of gravity of limit analysis, from above, and nearer with smaller cells. Without its ends the slope would
    slide at half of that. With 25 degrees of friction all of gravity does not move it."""
    exact = share_at_sliding(12)
    reached = [share_reached(*grid) for grid in grids]
    assert reached == sorted(reached, reverse=True)
    for found, error in zip(reached[1:], (0.06, 0.03)):
        assert found == pytest.approx(exact, rel=error)
    assert exact > 1.6 * COHESION / (WEIGHT * DEPTH * (np.sin(STEEP) - np.cos(STEEP) * np.tan(np.radians(12))))
    assert len(list(slope(*COARSE, *friction(25)).steps())) == 10


def test_stress_at_rest_is_refused_under_inclined_gravity():
    """It would not be in equilibrium; the remedy is the one that this scene uses."""
    remedies = r"z points up: write gravity = \[0.0, 0.0, -.*stage.gravity = \[0.0, 1.0\]"
    with pytest.raises(SceneError, match=f"geostatic needs gravity along -z.*{remedies}"):
        slope("soil.geostatic=true", "stage.0.gravity=[1.0, 1.0]")
