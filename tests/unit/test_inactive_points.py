"""Inactive points take no part: neither mass, force, stiffness nor plastic work comes from them."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.scene import Axis, Faces, Grid, Stage
from hybrid.scheme import Scheme
from hybrid.setup.build import build
from hybrid.soil.transfer import interpolate
from hybrid.step import error_estimate
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


def test_the_error_in_time_is_that_of_the_others(case):
    soil, points, lost, _ = case
    step = soil.begin(points, np.zeros(3))
    acceleration = np.random.default_rng(2).standard_normal((soil.grid.node_count, 3))

    def error(**history):
        own = SimpleNamespace(basis=step.basis, points=replace(points, **history))
        increment = SimpleNamespace(model=SimpleNamespace(soil=soil, scheme=Scheme.newmark()), soil=own, dt=0.1)
        return error_estimate._of_soil(increment, SimpleNamespace(rates=(None, acceleration)))

    new = interpolate(step.basis, soil.grid.shape, acceleration)
    mass, squares = soil.constants.mass[~lost], np.sum((new - points.acceleration)[~lost] ** 2, axis=1)
    assert error(inactive=lost) == pytest.approx(0.1**2 / 12 * np.sqrt(mass @ squares / mass.sum()), rel=1e-12)
    assert abs(error() / error(inactive=lost) - 1) > 1e-3
