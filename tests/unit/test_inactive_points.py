"""Inactive points take no part: neither mass, force, stiffness nor plastic work comes from them."""

from dataclasses import replace

import numpy as np
import pytest

from hybrid.scene import Axis, Faces, Grid, Stage
from hybrid.setup.build import build
from hybrid.study.scenes import scene

SAND = {"law": "drucker-prager", "young": 1e6, "poisson": 0.3, "friction_angle": 30.0, "dilation_angle": 0.0,
        "cohesion": 10.0}


@pytest.fixture(scope="module")
def case():
    """Soil, its points with a third inactive, which ones, and increments that shear all of them plastically."""
    side = Axis(start=0.0, end=0.8, size=0.2)
    simulation = build(scene("sand", Grid(side, side, Axis(start=-0.6, end=0.2, size=0.2), Faces()), SAND, [], 0.01,
                             [Stage("go", 1)], soil={"top": 0.0}))
    soil, points = simulation.model.soil, simulation.state.points
    lost = np.arange(len(points)) % 3 == 0
    nodes = np.stack(np.meshgrid(*soil.grid.axes, indexing="ij"), -1).reshape(-1, 3)
    shear = nodes @ np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.02, 0.01, -0.01]])
    return soil, points, lost, shear + 1e-3 * np.random.default_rng(1).standard_normal(nodes.shape)


def evaluated(soil, points, displacement):
    step = soil.begin(points, np.array([0.0, 0.0, -9.81]))
    return step, soil.evaluate(step, displacement)


def test_what_remains_is_what_the_others_give(case):
    """Soil of the other points alone has the same nodal masses, forces and plastic work."""
    soil, points, lost, displacement = case
    constants = replace(soil.constants, **{
        name: value[~lost] for name, value in vars(soil.constants).items() if value is not None})
    others = {name: value[~lost] for name, value in vars(points).items() if value is not None}
    fewer = replace(soil, constants=constants, law=soil.law.with_rows(soil.law.rows[~lost]))
    step, trial = evaluated(fewer, replace(points, **others), displacement)
    mass, force, work = step.mass.copy(), trial.force.copy(), fewer.plastic_work(step, trial)

    step, trial = evaluated(soil, replace(points, inactive=lost), displacement)
    assert work > 0 and soil.plastic_work(step, trial) == pytest.approx(work, rel=1e-12)
    np.testing.assert_allclose(step.mass, mass, atol=1e-13 * mass.max())
    np.testing.assert_allclose(trial.force, force, atol=1e-12 * np.abs(force).max())
    step, trial = evaluated(soil, points, displacement)
    assert soil.plastic_work(step, trial) > 1.2 * work     # inactive ones would have worked too
