"""A pull line that cuts through the soil above an anchor, in a scene: its bearing, its work, and what it cannot do."""


import numpy as np
import pytest

from hybrid.body.embedded_line import shackle
from hybrid.runtime.data import GEOMETRY
from hybrid.runtime.errors import SceneError
from hybrid.scene import Axis, Body, Faces, Grid, Layer, Material, Pull, Scene, Soil, Stage, Time
from hybrid.setup.build import build

CLAY = Material(law="von-mises", young=1e7, poisson=0.49, density=1700.0, strength=1e4, strength_gradient=1e3)
SAND = Material(relative_density=50.0)


def scene(material=CLAY, **soil):
    pull = Pull((0.0, 0.0, 0.0), (0.05, 0.0, 0.0), 1e5, 6.0, diameter=0.04, direction=(6.0, 0.0, 0.9))
    box = Body(GEOMETRY / "box.geo", 7850.0, parameters={"length": 0.6, "width": 0.5, "height": 0.4, "size": 0.2},
               position=(0.0, 0.25, -0.9), held=("rx", "ry", "rz", "y"), friction=0.3, pull=pull)
    return Scene(name="line", grid=Grid(Axis(start=-1.6, end=1.6, size=0.2), Axis(start=0.0, end=0.5, collapsed=True),
                                        Axis(start=-2.4, end=0.2, size=0.2), Faces(z_min="fixed")),
                 soil=Soil(material, top=0.0, **soil), bodies=(box,), time=Time(1.0, inertia=False), stages=(Stage("pull", 3),))


def test_force_at_the_shackle_is_that_of_the_closed_form():
    """Of a box in clay that is pulled at the mudline, 0.9 m above it, by less than it bears."""
    simulation = build(scene())
    soil = simulation.model.bodies[0].line.soil
    assert (soil.bearing, soil.gradient, soil.width) == pytest.approx((11 * 1e4 * 0.1, 11 * 1e3 * 0.1, 0.1))
    assert simulation.sheet()["modelled"]["pull lines in soil"][0].startswith("body: bearing of 1.1e+04 N/m and 1100 N/m a metre")
    record = list(simulation.steps())[-1]
    body = simulation.state.bodies[0]
    distance = np.linalg.norm(body.target - body.position)
    tension, angle = shackle(1e5 * (distance - 6.0), 0.0, soil.load(-body.position[2])[0], 0.4)
    assert simulation.evaluation.bodies[0].trial.tension == pytest.approx(tension, rel=1e-9) and 0.3 < angle < 1.57
    balance = record.bodies[0].contact_force + tension * np.array([np.cos(angle), 0.0, np.sin(angle)])
    assert balance[[0, 2]] == pytest.approx([0.0, simulation.model.bodies[0].mass.mass * 9.81], abs=2e-3 * tension)


def test_sand_bears_with_the_depth():
    line = build(scene(SAND)).model.bodies[0].line.soil
    angle = np.radians(28 + 0.125 * 50)
    factor = np.exp(np.pi * np.tan(angle)) * np.tan(np.pi / 4 + angle / 2) ** 2
    density = build(scene(SAND)).model.soil.constants
    assert line.bearing == 0.0
    assert line.gradient == pytest.approx(factor * density.mass[0] / density.volume[0] * 9.81 * 0.1)


@pytest.mark.parametrize("soil", [{"layers": (Layer("top", bottom=-1.0),)}, {"ground": ((-1.0, 0.0), (1.0, -0.2))}])
def test_a_line_in_other_soil_is_refused(soil):
    with pytest.raises(SceneError, match="body.0.pull.diameter = 0.04: must be left out with soil"):
        build(scene(**soil))
