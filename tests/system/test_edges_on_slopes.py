"""Bodies that slide on an edge over held ground given by heights on a grid."""

from dataclasses import replace

import numpy as np
import pytest
from limit_texts import limit_texts

from hybrid.monitors.limits import LIMITS, uneven
from hybrid.scene import Axis, Grid, Stage
from hybrid.setup.build import build
from hybrid.study.scenes import box, elastic, scene

G = 9.81


def edge_down(folder, slopes, bend=0.0, turn=(0.0, 1.0, 0.0, 45.0), steps=20, **body):
    """A smooth cube of 0.4 m, turned by 45 degrees, on a plane that falls with `slopes` along x and y, or is bent."""
    x, y = np.linspace(-1.5, 1.5, 13), np.linspace(-1.0, 1.0, 9)
    rows = [(a, b, -slopes[0] * a - slopes[1] * b + bend * a**2) for a in x for b in y]
    path = folder / "heights.csv"
    np.savetxt(path, rows, fmt="%.7f", delimiter=",", header="x,y,z", comments="")
    cube = box(0.4, 0.4, 0.4, name="cube", rotation=turn, rest_on="ground",
               **{"held": ("rx", "ry", "rz"), "position": (-0.4, 0.0, 0.0), **body})
    grid = Grid(Axis(-1.5, 1.5, 0.1), Axis(-1.0, 1.0, 0.1), Axis(-1.6, 1.4, 0.1))
    return scene("slope", grid, elastic(5e7), [cube], 0.01, [Stage("slide", steps)],
                 {"held": True, "top": 1.2, "ground": path}, gravity=(0.0, 0.0, -G))


@pytest.mark.parametrize("slopes", [(0.36, 0.0), (0.0, 0.36), (0.3, 0.2), (-0.3, 0.2)])
def test_a_smooth_edge_slides_down_a_plane_in_any_direction(slopes, tmp_path):
    """Between points of the ground it caught, and stood."""
    simulation = build(edge_down(tmp_path, slopes))
    list(simulation.steps())
    fall = np.array([*slopes, -slopes[0]**2 - slopes[1]**2]) / (1.0 + slopes[0]**2 + slopes[1]**2)
    np.testing.assert_allclose(simulation.state.bodies[0].velocity, 0.2 * G * fall, atol=5e-3)


@pytest.mark.parametrize("position", [(-0.4, -0.72, 0.0), (-0.4, 0.72, 0.0)])
def test_an_edge_slides_beside_the_end_of_a_skew_slope(position, tmp_path):
    """Which is no rectangle in the frame of the slope: its corners were left out."""
    simulation = build(edge_down(tmp_path, (0.3, 0.3), position=position, steps=10))
    list(simulation.steps())
    fall = np.array([0.3, 0.3, -0.18]) / 1.18
    np.testing.assert_allclose(simulation.state.bodies[0].velocity, 0.1 * G * fall, atol=5e-3)


def test_a_body_as_wide_as_the_ground_slides_on_its_edge():
    """Flush with both ends of the grid."""
    cube = box(0.4, 0.4, 0.4, name="cube", position=(0.0, 0.2, 0.0), rotation=(0.0, 1.0, 0.0, 45.0), rest_on=0.0,
               held=("y", "rx", "ry", "rz"), velocity=(1.0, 0.0, 0.0))
    grid = Grid(Axis(-1.0, 1.0, 0.2), Axis(0.0, 0.4, 0.2), Axis(-0.4, 0.4, 0.2))
    simulation = build(scene("slice", grid, elastic(5e7), [cube], 0.02, [Stage("slide", 10)], {"held": True, "top": 0.0},
                             gravity=(0.0, 0.0, -G)))
    list(simulation.steps())
    np.testing.assert_allclose(simulation.state.bodies[0].velocity, (1.0, 0.0, 0.0), atol=1e-3)


@pytest.mark.parametrize("given, told", [
    ({"slopes": (0.3, 0.0), "bend": 0.1}, True), ({"slopes": (0.3, 0.1)}, False), ({"slopes": (0.0, 0.0)}, False),
    ({"slopes": (0.3, 0.0), "bend": 0.1, "penalty": 100.0}, False),
    ({"slopes": (0.3, 0.0), "bend": 0.1, "held": ("x", "y", "z", "rx", "ry", "rz")}, False)])
def test_edges_on_ground_that_bends_are_told(given, told, tmp_path):
    found = limit_texts(uneven.edges_on_bends, edge_down(tmp_path, **given))
    assert len(found) == told and all("heights on a grid that are no plane" in text for text in found)
    assert uneven.edges_on_bends in LIMITS


@pytest.mark.parametrize("slopes, told", [((0.3, 0.0), False), ((0.0, 0.3), True)])
def test_a_slope_that_a_plane_of_symmetry_crosses_does_not_go_on_beyond_it(slopes, told, tmp_path):
    """Half of a cube is modelled, in the plane y = 0."""
    described = edge_down(tmp_path, slopes, held=(), turn=None)
    described = replace(described, grid=replace(described.grid, y=Axis(0.0, 1.0, 0.1)))
    body = build(described).model.bodies[0]
    assert body.mirrors and (body.ground is None) == told
    found = limit_texts(uneven.edges_on_bends, described)
    assert len(found) == told and all("fall across its plane of symmetry" in text for text in found)
