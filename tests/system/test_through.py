"""A thin plate thrown at soil in steps longer than its thickness: no corner may be carried through it."""

import pytest

from hybrid.build import build
from hybrid.scene import Axis, Body, Faces, Grid, Material, Scene, Soil, Solver, Stage, Time
from hybrid.system.equations import Step


@pytest.fixture
def thrown(geometry):
    """A plate of 40 mm at 5 m/s, in steps of 0.15 m, 10 mm above a block of elastic soil."""
    axis = Axis(start=0.0, end=0.8, size=0.2)
    return build(Scene(
        name="thrown", grid=Grid(axis, axis, Axis(start=-0.8, end=0.6, size=0.2), Faces(z_min="fixed")),
        soil=Soil(Material(law="hencky", young=5e6, poisson=0.2, density=1800.0), top=0.0),
        bodies=(Body(geometry=geometry / "box.geo", density=8000.0, rest_on=0.01, position=(0.4, 0.4, 0.0),
                     parameters={"length": 0.5, "width": 0.5, "height": 0.04, "size": 0.25}, velocity=(0.0, 0.0, -5.0)),),
        time=Time(step=0.03), stages=(Stage("throw", 4),), solver=Solver(tolerance=1e-4)))


def lowest_gap_to_soil(simulation):
    """Height [m] of the plate's middle above the highest soil under it."""
    points, plate = simulation.state.points, simulation.state.bodies[0].position
    under = abs(points.position[:, :2] - plate[:2]).max(axis=1) < 0.2
    return plate[2] - (points.position + points.half)[under, 2].max()


def test_long_steps_are_halved_until_no_corner_is_carried_through(thrown):
    records = list(thrown.steps())
    assert sum(r.rejections for r in records) > 0
    assert lowest_gap_to_soil(thrown) > 0.0
    assert records[-1].bodies[0].velocity[2] > -1.0


def test_without_the_check_it_goes_through(thrown, monkeypatch):
    monkeypatch.setattr(Step, "passed_through", lambda self, evaluation: 0)
    list(thrown.steps())
    assert lowest_gap_to_soil(thrown) < 0.0
