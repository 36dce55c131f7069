"""The scene builders of the studies give scenes that can be built, with the values that their arguments name."""

import pytest

from hybrid.scene import Axis, Faces, Grid, Material, Soil
from hybrid.setup.build import build
from hybrid.study import scenes


def test_a_plane_has_its_stiffness_and_settles_first():
    scene = scenes.plane(scenes.box(0.5, 0.5, 0.5, rest_on=0.0), 3, 0.01, stiffness=2e6, settle=2)
    assert scene.soil.held and scene.soil.material.young == 2e6
    assert [(stage.name, stage.steps) for stage in scene.stages] == [("settle", 2), ("run", 3)]
    assert scenes.settling(0) == []


def test_weight_grows_in_quasi_static_steps():
    """Mean stress of a column after the last step: half of its weight."""
    soil = Soil(Material(law="hencky", young=1e7, poisson=0.0, density=1000.0), geostatic=False)
    side = scenes.collapsed()
    scene = scenes.loaded_by_weight("column", Grid(side, side, Axis(0.0, 4.0, 1.0), Faces()), soil, 2, -10.0)
    assert not scene.time.inertia and scene.gravity == (0.0, 0.0, -10.0)
    simulation = build(scene)
    list(simulation.steps())
    assert simulation.state.points.stress[:, 2, 2].mean() == pytest.approx(-2e4, rel=1e-2)


def test_bodies_have_the_density_and_the_motion_that_are_given():
    assert scenes.steel(1.0, 1.0, 1.0).density == 8000.0 and scenes.sphere(0.5, 0.1).parameters["radius"] == 0.5
    driven = scenes.driven(1.0, 1.0, 1.0, velocity=(0.0, 0.0, -1.0))
    assert driven.driven == ("x", "y", "z") and driven.held == ("rx", "ry", "rz")


def test_soil_scenes_take_axes_or_their_ends():
    scene = scenes.soil_scene(x=Axis(0.0, 1.0, 0.5), size=0.1, held=True)
    assert (scene.grid.x.size, scene.grid.y.size) == (0.5, 0.1) and scene.soil.held
