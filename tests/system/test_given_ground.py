"""Ground with given heights, held or not: bodies feel its surface as given, not the flat tops of its columns."""

import numpy as np
import pytest

from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Axis, Body, Faces, Grid, Material, Scene, Soil, Stage, Time
from hybrid.setup.build import build
from hybrid.soil.given_ground import GivenGround
from hybrid.soil.model import Soil as SoilModel

G, VALLEY, RADIUS = 9.81, 3.0, 0.2
ROCK = Material(law="hencky", young=5e7, poisson=0.2, density=2000.0)
SLICE = Axis(start=0.0, end=0.5, collapsed=True)


def scene(ground, body, x, z, top, steps, size=0.1, time=0.01):
    return Scene(name="held", grid=Grid(Axis(*x, size), SLICE, Axis(*z, size), Faces(z_min="fixed")),
                 soil=Soil(ROCK, top=top, ground=ground, held=True, geostatic=False), bodies=(body,), time=Time(time),
                 stages=(Stage("go", steps),), gravity=(0.0, 0.0, -G))


def roller(x, **more):
    """A cylinder across the slice that lies on the ground at x [m]."""
    return Body(GEOMETRY / "cylinder.geo", 2400.0, parameters={"radius": RADIUS, "height": 0.5, "size": 0.04},
                rotation=(1.0, 0.0, 0.0, 90.0), position=(x, 0.25, 0.0), rest_on="ground", friction=0.6, **more)


def test_a_cylinder_swings_in_a_valley_with_the_period_of_a_pendulum_and_without_loss():
    """T = 2π √(3 (R - r) / 2 g) (1 + θ²/16). On the tops of columns a ball lost 39 % of its energy, or was
    refused. The straight pieces of the profile bend by half a degree; in steps of 0.01 s that adds 0.9 % to the swing."""
    x = np.linspace(-1.5, 1.5, 121)
    ground = tuple(zip(x.tolist(), (VALLEY - np.sqrt(VALLEY**2 - x**2)).tolist()))
    simulation = build(scene(ground, roller(0.5), (-1.5, 1.5), (-0.5, 1.0), 0.5, 420, time=0.005))
    time, place = np.array([(record.time, record.bodies[0].position[0]) for record in simulation.steps()]).T
    i = np.flatnonzero(place[1:] * place[:-1] < 0.0)
    zeros = time[i] - place[i] * (time[i + 1] - time[i]) / (place[i + 1] - place[i])    # one, after a quarter of it
    start = place[0]
    swing = np.arcsin(start / (VALLEY - RADIUS))
    assert 4 * zeros == pytest.approx(2 * np.pi * np.sqrt(1.5 * (VALLEY - RADIUS) / G) * (1 + swing**2 / 16), rel=5e-3)
    assert place.min() == pytest.approx(-start, rel=5e-3)


def test_a_cylinder_rolls_down_a_slope_given_by_its_heights():
    """s = g sin α t² / 3 on 20°, from rest."""
    slope = np.tan(np.radians(20.0))
    simulation = build(scene(((0.0, 3.0 * slope), (3.0, 0.0)), roller(0.5), (0.0, 3.0), (-0.5, 1.8), 1.1, 80))
    start = simulation.state.bodies[0].position.copy()
    *_, last = simulation.steps()
    way = np.linalg.norm(last.bodies[0].position - start)
    assert way == pytest.approx(G * np.sin(np.radians(20.0)) * last.time**2 / 3, rel=0.01)


def test_walls_keep_their_columns_and_gentle_ground_is_followed_on_its_upper_faces():
    """Columns of 0.5 m: the first is level, the next one rises at 45 degrees, the third has a wall in it."""
    surface = np.array([0.0, 0.5, 1.0, 1.25, 1.25, 1.5]), None, np.array([1.0, 1.0, 1.5, 1.5, 0.5, 0.5])
    position = np.array([[0.25, 0.0, 0.75], [0.75, 0.0, 1.125], [1.25, 0.0, 0.75], [0.75, 0.0, 0.5]])
    half = np.array([[0.25, 0.5, 0.25], [0.25, 0.5, 0.125], [0.25, 0.5, 0.25], [0.25, 0.5, 0.25]])
    ground = GivenGround.of(surface, 1.4, position, half)
    assert ground.follows.tolist() == [True, True, False, False] and ground.highest.tolist() == [True, True, False, False]
    place = np.array([[0.6, 0.0, 1.25], [1.0, 0.0, 1.2], [0.5, 0.0, 1.2], [1.0, 0.0, 0.6], [1.3, 0.0, 1.0]])
    point, up = np.array([1, 1, 1, 3, 2]), np.array([True, False, False, False, True])
    offset = (place - position[point]) / half[point]
    way, kept = ground.moved(point, up, offset)
    assert kept.tolist() == [True, True, False, True, True]     # 0.2 m above the foot of the slope there is no side
    assert place[:, 2] + way == pytest.approx([1.1, 1.2, 1.2, 0.6, 1.0])
    down = np.tile([0.0, 0.0, -1.0], (5, 1))
    across = np.tile([np.sqrt(0.5), 0.0, -np.sqrt(0.5)], (5, 1))
    usual = np.full(5, 0.3)
    assert ground.projected_share(point, up, offset, down, usual) == pytest.approx([1.0, 0.3, 0.3, 0.3, 0.3])
    assert ground.projected_share(point, up, offset, across, usual)[0] == pytest.approx(np.sqrt(2.0))    # area of the slope


def test_a_body_beside_a_wall_is_pushed_by_it():
    """The wall ends between columns: it carries what a face of the domains does, p_f E A δ."""
    wall = ((0.0, 0.0), (1.0, 0.0), (1.0, 0.6), (2.0, 0.6))
    box = Body(GEOMETRY / "box.geo", 2400.0, parameters={"length": 0.3, "width": 0.5, "height": 0.3, "size": 1.0},
               name="box",
               position=(0.84, 0.25, 0.25), driven=("x",), held=("z", "ry"), velocity=(1.1, 0.0, 0.0), friction=0.0)
    simulation = build(scene(wall, box, (0.0, 2.0), (-0.4, 1.0), 0.6, 1))
    record, = simulation.steps()
    body = simulation.model.bodies[0]
    assert record.bodies[0].contact_force[0] == pytest.approx(-body.penalty * 0.3 * 0.5 * 0.001, rel=0.1)


@pytest.mark.parametrize("spin", [0.0, -40.0])
@pytest.mark.parametrize("shift", [0.0, 0.013])
def test_a_sphere_that_is_thrown_along_the_ground_slides_from_the_first_step_on(spin, shift):
    """Friction was zero there, or pushed it on."""
    side = Axis(-0.6, 0.6, 0.2)
    ball = Body(GEOMETRY / "sphere.geo", 900.0, parameters={"radius": 0.19, "size": 0.05}, position=(shift, 0.033, 0.0),
                rest_on=0.0,
                friction=0.3, velocity=(2.0, 0.0, 0.0), spin=(0.0, spin, 0.0))
    simulation = build(Scene(name="thrown", grid=Grid(side, side, Axis(-0.2, 0.0, 0.2)),
                             soil=Soil(ROCK, held=True, geostatic=False),
                             bodies=(ball,), time=Time(0.01), stages=(Stage("go", 3),), gravity=(0.0, 0.0, -G)))
    for record in simulation.steps():
        force = record.bodies[0].contact_force
        assert force[2] > 0.0 and force[0] == pytest.approx(-0.3 * force[2], rel=0.03)


SLOPE = np.tan(np.radians(20.0))
CLAY = Material(law="von-mises", young=50e6, poisson=0.49, density=1800.0, strength=100e3)


def on_slope(friction, height="ground"):
    """Scene of a block on a slope of clay, for half a second."""
    ground = ((0.0, 3.5), (1.0, 3.5), (6.0, 3.5 - 5.0 * SLOPE), (7.0, 3.5 - 5.0 * SLOPE))
    block = Body(GEOMETRY / "box.geo", 2400.0, parameters={"length": 1.5, "width": 0.5, "height": 0.5, "size": 1.0},
                 rotation=(0.0, 1.0, 0.0, 20.0), position=(2.9, 0.25, 0.0), rest_on=height, friction=friction)
    return Scene(
        name="slid", grid=Grid(Axis(0.0, 7.0, 0.25), SLICE, Axis(0.0, 4.5, 0.25), Faces(z_min="fixed")),
        soil=Soil(CLAY, top=3.5, ground=ground), bodies=(block,), time=Time(0.02), stages=(Stage("go", 25),),
        gravity=(0.0, 0.0, -G))


def slid(friction):
    """(Simulation, way (3,) [m] of the block)."""
    simulation = build(on_slope(friction))
    start = simulation.state.bodies[0].position.copy()
    list(simulation.steps())
    return simulation, simulation.state.bodies[0].position - start


@pytest.mark.parametrize("friction", [0.0, 0.2])
def test_a_block_on_a_slope_that_deforms_slides(friction, monkeypatch):
    """s = g (sin α - μ cos α) t² / 2. On the tops of columns, of whose steps it takes a part at the start, it stands in
    them."""
    simulation, way = slid(friction)
    assert "in place from the start" not in simulation.start and simulation.warned == ()
    free = 0.5 * G * (np.sin(np.radians(20.0)) - friction * np.cos(np.radians(20.0))) * 0.5**2
    assert np.linalg.norm(way) == pytest.approx(free, rel=0.05) and -way[2] / way[0] == pytest.approx(SLOPE, rel=0.03)
    if friction:
        monkeypatch.setattr(SoilModel, "ground", None)
        monkeypatch.setattr("hybrid.setup.in_place.depth_in_ground", lambda *_: np.inf)
        simulation, way = slid(friction)
        assert "in place from the start" in simulation.start and np.linalg.norm(way) < 0.1 * free


def test_a_block_in_the_slope_is_in_place():
    simulation = build(on_slope(0.2, height=2.0))
    assert "in place from the start" in simulation.start
