"""Body forces and gravity that is turned on: nodal loads, motion in closed form, work of the load."""

import numpy as np
import pytest

from hybrid.runtime.errors import SceneError
from hybrid.scene import Axis, Grid, Stage
from hybrid.setup.build import build
from hybrid.step.energy import balance_error, energies
from hybrid.study.scenes import FREE, SCHEMES, elastic, scene, steel

AXIS = Axis(start=-1.0, end=1.2, size=0.2)
GRAVITY = np.array([1.0, 0.5, -9.81])


def flying(stages, body_force=None, bodies=(), gravity=GRAVITY):
    """A block of soil in free flight, by Newmark's rule: exact for loads that are linear in time."""
    return build(scene(
        "flight", Grid(AXIS, AXIS, Axis(start=-2.0, end=2.0, size=0.2), FREE), elastic(1e5, 0.3), bodies, 0.04, stages,
        soil={"lower": (-0.2, -0.4, 0.0), "upper": (0.4, 0.2, 0.6)}, gravity=tuple(gravity),
        time=SCHEMES["newmark"], solver={"tolerance": 1e-13, "linear": "direct"}), body_force=body_force)


def test_nodal_load_has_the_force_and_the_moment_of_that_on_the_points():
    def force(time, position):
        return np.sin(3 * position[:, ::-1]) + time

    simulation = flying([Stage("fly", 1)], force)
    soil, points = simulation.model.soil, simulation.state.points
    step = soil.begin(points, simulation.model.loads.on_points(0.5, soil.constants.position))
    on_points = soil.constants.mass[:, None] * (GRAVITY + force(0.5, soil.constants.position))
    nodes = np.stack(np.meshgrid(*soil.grid.axes, indexing="ij"), -1).reshape(-1, 3)
    np.testing.assert_allclose(step.weight.sum(axis=0), on_points.sum(axis=0), rtol=1e-13)
    moment = np.cross(points.position, on_points).sum(axis=0)
    np.testing.assert_allclose(np.cross(nodes, step.weight).sum(axis=0), moment, atol=1e-11 * np.abs(moment).max())
    np.testing.assert_allclose(step.velocity, 0.0)


def test_uniform_body_force_is_as_gravity():
    """Newmark's rule is exact for it; its work is what the block gains."""
    force = np.array([0.3, -2.0, 4.0])
    simulation = flying([Stage("fly", 8)], lambda time, position: np.broadcast_to(force, position.shape))
    start, before = simulation.state.points, energies(simulation.model, simulation.state)
    for n, record in enumerate(simulation.steps(), 1):
        fallen = simulation.state.points.position - start.position
        wanted = (GRAVITY + force) * (0.04 * n) ** 2 / 2
        np.testing.assert_allclose(fallen, np.broadcast_to(wanted, fallen.shape), atol=1e-12)
    mass = simulation.model.soil.constants.mass.sum()
    assert record.energies["load"] == pytest.approx(mass * force @ fallen[0], rel=1e-10)
    assert abs(balance_error(record.energies, before)) < 1e-10 * mass


def test_gravity_that_is_turned_on():
    """Share t/T: velocity g t²/2T, exactly; soil and body the same, and all of it afterwards; energy balances."""
    stages = [Stage("on", 10, gravity=(0.0, 1.0)), Stage("after", 1)]
    simulation = flying(stages, bodies=[steel(0.2, 0.2, 0.2, position=(0.9, 0.9, 1.0))])
    mass = simulation.model.soil.constants.mass.sum() + simulation.masses[0].mass
    before, run = energies(simulation.model, simulation.state), simulation.steps()
    for wanted in [*(GRAVITY * 0.4 / 2 * (n / 10) ** 2 for n in range(1, 11)), 0.24 * GRAVITY]:
        record, state = next(run), simulation.state
        np.testing.assert_allclose(state.points.velocity, np.broadcast_to(wanted, (len(state.points), 3)), atol=1e-11)
        np.testing.assert_allclose(state.bodies[0].velocity, wanted, atol=1e-11)
        assert abs(balance_error(record.energies, before)) < 1e-11 * mass
    assert abs(record.energies["load"]) > 100.0


def test_bad_loads_are_refused():
    with pytest.raises(ValueError, match="shape"):
        flying([Stage("fly", 1)], lambda time, position: np.zeros(3))
    with pytest.raises(SceneError, match="stage.0.gravity"):
        flying([Stage("fly", 1, gravity=(-1.0, 1.0))])
