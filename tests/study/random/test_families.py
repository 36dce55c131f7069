"""Families of random scenes: nothing is set but the physics, seeds give the same values again, closed forms hold."""

from dataclasses import replace

import numpy as np
import pytest
from options import options_set
from scipy.spatial.transform import Rotation

from hybrid.scene import Solver
from hybrid.study.random import rides, tumbling
from hybrid.study.random.registry import FAMILIES


@pytest.mark.parametrize("name", FAMILIES)
def test_scenes_set_nothing_but_the_physics(name):
    family = FAMILIES[name]
    for seed in range(3):
        for scene in family.scenes(**family.values(name, seed)):
            assert options_set(scene) == []


def test_an_option_is_found():
    scene, = rides.FAMILIES["sphere"].scenes(**FAMILIES["sphere"].values("sphere", 0))
    other = replace(scene, method="published", solver=Solver(linear="direct"),
                    bodies=(replace(scene.bodies[0], penalty=10.0),))
    assert options_set(other) == ["Scene.method", "Solver.linear", "Body.penalty"]


@pytest.mark.parametrize("name", FAMILIES)
def test_a_seed_gives_the_same_values_again(name):
    family = FAMILIES[name]
    assert family.values(name, 3) == family.values(name, 3) != family.values(name, 4)


@pytest.mark.parametrize("shape, limit", [("sphere", 3.5), ("cylinder", 3.0)])
def test_sliding_turns_into_rolling_without_a_jump(shape, limit):
    """The two closed forms agree where sliding ends; without friction nothing spins, and rolling has no slip."""
    mu = np.tan(np.radians(40.0)) / limit
    slides, rolls = (rides.law(shape, 40.0, mu * factor) for factor in (1 - 1e-9, 1 + 1e-9))
    assert slides == pytest.approx(rolls, rel=1e-6)
    assert rides.law(shape, 40.0, 0.0)[1] == 0.0
    assert 2 * rolls[0] / rides.RADIUS == pytest.approx(rolls[1])


def test_a_cylinder_lies_across_the_heading():
    *axis, angle = rides.rotation("cylinder", 30.0, (50.0, 0.0, 0.0))
    turned = Rotation.from_rotvec(np.radians(angle) * np.array(axis))
    assert np.abs(turned.apply((0.0, 0.0, 1.0)) @ np.array([-0.5, np.sqrt(0.75), 0.0])) == pytest.approx(1.0)


def test_the_exact_top_turns_about_a_fixed_axis_and_keeps_its_momentum():
    edges = (0.9, 0.5, 0.2)
    steady = tumbling.exact(edges, 2.0, (0.0, 0.0, 1.0), 1.2)
    assert steady.as_rotvec() == pytest.approx([0.0, 0.0, 2.4], abs=1e-9)
    nudge = 1e-4
    before, after = (tumbling.exact(edges, 2.0, (0.1, 1.0, 0.0), 3.0 + sign * nudge) for sign in (-1, 1))
    spin = (after * before.inv()).as_rotvec() / (2 * nudge)     # about the axes of space, at 3 s
    a, b, c = np.square(edges)
    turned = tumbling.exact(edges, 2.0, (0.1, 1.0, 0.0), 3.0).as_matrix()
    inertia = turned @ np.diag([b + c, a + c, a + b]) @ turned.T
    assert inertia @ spin == pytest.approx(2.0 * np.array([0.1 * (b + c), a + c, 0.0]), abs=1e-6)


def test_every_error_with_an_aim_is_measured_and_a_value_that_is_not_finite_misses():
    family = FAMILIES["sphere"]
    assert family.missed({"distance": np.nan, "spin": -0.02, "airborne": 0.0}) == ["distance", "spin"]
