"""Stiffness of a strip on an elastic layer, in settlement and in rocking, whatever the place of its edges in a cell, and
whether its weight acts.

Strip of 1 m, smooth, on a layer of 2 m, E = 10 MPa, ν = 0.3, 8 m wide between rollers. Quadratic finite elements that
shrink to 8 mm at the edges have 10.845 MN/m and 2.259 MN m; on a deep layer they are within 0.2 % of π E b²/(4 (1 - ν²)).
"""

from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.body.mesh import generate
from hybrid.body.sharp_edges import SharpEdges, find_edges
from hybrid.body.surface import build_surface
from hybrid.contact import soft_edges
from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Axis, Faces, Grid, Load, Material, Motion, Scene, Soil, Stage, Time
from hybrid.setup.build import build
from hybrid.study.scenes import NO_OUTPUT, box, soil_scene

SETTLEMENT, ROCKING = 10.845e6, 2.259e6     # [N/m], [N m]
CELL, WEIGHT, LOAD = 0.125, 9810.0, 4e3     # [m], [N], [N]


def stiffness(beside=0.0, weightless=False, high=1.0):
    """(Settlement under a load, rotation under a moment, over those of finite elements) of the strip, its edges so many
    cells beside lines of the grid; high: height of cells over their width."""
    strip = box(1.0, 1.0, 0.5, density=2000.0, position=(beside * CELL, 0.5, 0.0), rest_on=0.0)
    grid = Grid(Axis(-4.0, 4.0, CELL), Axis(0.0, 1.0, collapsed=True), Axis(-2.0, 0.5, high * CELL), Faces(z_min="fixed"))
    soil = Soil(Material(law="hencky", young=1e7, poisson=0.3, density=2000.0), top=0.0)
    upright = Motion(held=("x", "ry")), Motion(held=("x",))
    given = -WEIGHT if weightless else 0.0
    pressed = Load(force=((0.0, 0.0, 0.0, given), (1.0, 0.0, 0.0, given - LOAD)))
    free = Load(force=(0.0, 0.0, given - LOAD))
    turned = Load(force=(0.0, 0.0, given - LOAD), moment=((0.0, 0.0, 0.0, 0.0), (1.0, 0.0, 0.05 * LOAD, 0.0)))
    stages = (Stage("rest", 1, motions=upright[:1], loads=(Load(force=(0.0, 0.0, given)),)),
              Stage("press", 1, motions=upright[:1], loads=(pressed,)), Stage("free", 1, motions=upright[1:], loads=(free,)),
              Stage("turn", 1, motions=upright[1:], loads=(turned,)))
    gravity = (0.0, 0.0, 0.0 if weightless else -9.81)
    simulation = build(Scene(name="strip", grid=grid, soil=soil, bodies=(strip,), stages=stages, gravity=gravity,
                             time=Time(1.0, inertia=False), output=NO_OUTPUT))
    at = [record.bodies[0] for record in simulation.steps()]
    angle = 2 * np.arcsin(at[3].quaternion[2]) - 2 * np.arcsin(at[2].quaternion[2])
    return LOAD / (at[0].position[2] - at[1].position[2]) / SETTLEMENT, 0.05 * LOAD / angle / ROCKING


@pytest.mark.parametrize("beside, weightless, high", [
    (0.0, False, 1.0), (0.25, False, 1.0), (0.5, False, 1.0), (0.5, True, 1.0), (0.5, False, 0.5)])
def test_a_strip_is_as_stiff_as_finite_elements_have_it(beside, weightless, high):
    settlement, rocking = stiffness(beside, weightless, high)
    assert settlement == pytest.approx(1.0, abs=0.025) and rocking == pytest.approx(1.0, abs=0.07)


def test_with_stiff_springs_up_to_its_edges_it_is_too_stiff(monkeypatch):
    monkeypatch.setattr(soft_edges, "SOFT", 0.0)
    settlement, rocking = stiffness(0.5)
    assert settlement > 1.05 and rocking > 1.2


def test_points_near_an_edge_are_softer_by_their_distance():
    """A square of 1 m, its edges on three sides sharp: p_f h/6 = 50 at an edge."""
    square = SimpleNamespace(vertices=np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)]),
                             triangles=np.array([(0, 1, 2), (0, 2, 3)]), curvature=np.zeros((2, 3, 3)))
    sides, numbers = np.array([(0, 0), (0, 0), (1, 1)]), np.array([(0, 0), (1, 1), (1, 1)])
    ends = soft_edges.ends_of(square, SharpEdges(sides, numbers, np.zeros((3, 2)), np.zeros((3, 2))))
    found = soft_edges.soft_edges(ends, penalty=3000.0, cell=0.1)
    points = np.array([(0.5, 0.0, 0.0), (0.5, 0.05, 0.0), (0.98, 0.5, 0.0), (0.5, 0.89, 0.0), (0.01, 0.5, 0.0)])
    assert found.shares(points) == pytest.approx([1 / 51, 1 / 26, 1 / 41, 1.0, 1.0])
    assert soft_edges.soft_edges(ends[:0], penalty=3000.0, cell=0.1) is None


def test_the_rim_of_a_cylinder_is_round():
    """Of a facet of 0.15 m on a radius of 0.5 m the middle is 5.6 mm inside."""
    mesh = generate(GEOMETRY / "cylinder.geo", {"radius": 0.5, "height": 1.0, "size": 0.15})
    surface = build_surface(mesh.points, mesh.contact, mesh.normals)
    ends = soft_edges.ends_of(surface, find_edges(surface, 0.1))
    middle = ends.mean(axis=1)
    assert np.linalg.norm(middle[:, :2], axis=1) == pytest.approx(0.5, abs=5e-4)
    assert np.abs(middle[:, 2]) == pytest.approx(0.5)


@pytest.mark.parametrize("table, gravity, soft", [
    ({}, -9.81, True), ({"velocity": (1.0, 0.0, 0.0)}, -9.81, True), ({}, 0.0, True),
    ({"driven": ("z",), "velocity": (0.0, 0.0, -1.0)}, 0.0, True), ({"velocity": (1.0, 0.0, 0.0)}, 0.0, False),
    ({"driven": ("x",), "velocity": (1.0, 0.0, 0.0)}, -9.81, False)])
def test_bodies_that_slide_along_have_rounded_edges(table, gravity, soft):
    """Soil in front of a sharp edge comes to lie inside them, as on a bank that they are driven up."""
    block = box(0.4, 0.4, 0.2, position=(0.4, 0.4, 0.0), rest_on=0.0, **table)
    body = build(soil_scene([block], gravity=(0.0, 0.0, gravity))).model.bodies[0]
    assert (body.soft_edges is not None) == soft and (body.surface is body.outline) == soft


@pytest.mark.parametrize("cells, expected", [(4, 4.68e6), (8, 4.59e6)])
def test_a_wall_driven_into_elastic_soil_is_as_stiff_as_one_that_a_load_moves(cells, expected):
    """0.4 m thick and 0.8 m deep, by 10 mm; both tend to 4.5 MN/m. With rounded edges 5.03 and 4.75 MN/m."""
    size = 0.8 / cells
    wall = box(0.4, 1.0, 1.0, size=20.0, density=2500.0, position=(0.0, 0.5, -0.3), held=("z", "ry"), friction=0.3)
    push = Stage("push", 3, motions=(Motion(component="x", displacement=((0.0, 0.0), (3.0, 0.01))),))
    grid = Grid(Axis(-3.0, 3.0, size), Axis(0.0, 1.0, collapsed=True), Axis(-2.0, 0.6, size), Faces(z_min="fixed"))
    soil = Soil(Material(law="hencky", young=5e6, poisson=0.3, density=1800.0), top=0.0)
    simulation = build(Scene(name="wall", grid=grid, bodies=(wall,), time=Time(1.0, inertia=False), output=NO_OUTPUT,
                             soil=soil, stages=(push,)))
    *_, last = simulation.steps()
    assert -last.bodies[0].contact_force[0] / 0.01 == pytest.approx(expected, rel=0.003)
