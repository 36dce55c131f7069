"""Bodies that are moved along the fixed base of the grid: the force that this makes wrong, and the note about it."""

from dataclasses import replace

import pytest

from hybrid.monitors.limits import base, margins
from hybrid.monitors.limits.base import body_on_base
from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Axis, Body, Faces, Grid, Layer, Load, Material, Scene, Soil, Stage, Time
from hybrid.setup.build import build

STRENGTH, DEPTH = 16e3, 2.0
CLAY = {"law": "von-mises", "young": 8e6, "poisson": 0.49, "density": 1.0, "strength": STRENGTH}


def wall(foot, cell=0.1, z_min="fixed", steps=18, material=CLAY, loads=(), both=False, below=None, **body):
    """Simulation of a smooth wall pushed into clay in plane strain, its foot at a height [m] over the base; both: with clay
    on both sides; below: values of a layer under the clay and the wall."""
    made = Body(GEOMETRY / "box.geo", 2400.0, name="wall", position=(-0.12, 0.5, foot - 0.85),
                parameters={"length": 0.5, "width": 1.0, "height": 2.3, "size": 20.0},
                **{"held": ("z", "ry"), "driven": ("x",), "velocity": (0.0015, 0.0, 0.0), **body})
    bottom = -DEPTH - 5 * cell if below else -DEPTH
    grid = Grid(Axis(-0.57, 4.93, cell), Axis(0.0, 1.0, collapsed=True), Axis(bottom, 0.4, cell), Faces(z_min=z_min))
    soil = Soil(Material(**material), top=0.0, geostatic=False, **({} if both else {"lower": (0.13, 0.0, bottom)}))
    if below:
        values = dict(below)
        layer = Layer("rock", -DEPTH, law=values.pop("law"), material=values)
        step = ((-0.57, -DEPTH), (0.13, -DEPTH), (0.131, 0.0), (4.93, 0.0))
        soil = Soil(Material(**material), top=0.0, geostatic=False, ground=step, layers=(layer,))
    return build(Scene(name="wall", grid=grid, soil=soil, gravity=(0.0, 0.0, 0.0), bodies=(made,),
                       time=Time(1.0, inertia=False), stages=(Stage("push", steps, loads=loads),)))


def notes(*given, **more):
    simulation = wall(*given, **more)
    return list(body_on_base(simulation.scene, simulation.model))


@pytest.mark.parametrize("foot, text", [(-0.08, "0.08 m below"), (0.0, "foot on the"), (0.04, "0.04 m above")])
def test_a_wall_on_a_fixed_base_is_reported(foot, text):
    found, = notes(foot)
    assert text in found and "limit 0.5 cells, 0.05 m" in found and "0.1 m above the base, one cell" in found
    assert 'z_min = "roller"' in found
    free = {"held": ("z", "ry"), "driven": (), "velocity": (0.0, 0.0, 0.0)}
    assert notes(foot, loads=(Load(force=(1.0, 0.0, 0.0)),), **free) and not notes(foot, **free)
    assert not notes(foot, loads=(Load(force=(0.0, 0.0, -1.0)),), **free) and notes(foot, both=True, **free)


ROCK = {"law": "hencky", "young": 1e9, "poisson": 0.3, "density": 1.0}


@pytest.mark.parametrize("foot, below, reported", [
    (0.0, ROCK, True), (0.04, ROCK, True), (0.05, ROCK, False), (-0.06, ROCK, False),
    (0.0, {**CLAY, "strength": 4 * STRENGTH}, True), (0.0, {**CLAY, "strength": 3 * STRENGTH}, False)])
def test_a_wall_on_a_harder_layer_is_reported(foot, below, reported):
    found = notes(foot, below=below)
    assert len(found) == reported and all("harder layer rock, limit 0.5 cells" in text for text in found)


SAND = {"law": "mohr-coulomb", "young": 2e7, "poisson": 0.3, "density": 1.0, "friction_angle": 30.0, "dilation_angle": 0.0,
        "cohesion": 0.0}


@pytest.mark.parametrize("above, below, harder", [
    (CLAY, ROCK, True), (SAND, ROCK, True), (ROCK, ROCK, False), (ROCK, CLAY, False),
    (SAND, SAND, False), ({**SAND, "cohesion": 1e3}, {**SAND, "cohesion": 4e3}, True),
    ({**SAND, "cohesion": 1e3}, {**SAND, "cohesion": 4e3, "friction_angle": 20.0}, False),
    (CLAY, SAND, False), (SAND, CLAY, False), (CLAY, {**CLAY, "strength": 4 * STRENGTH}, True),
    ({**CLAY, "strength": 1e3, "strength_gradient": 20e3}, CLAY, False)])
def test_soil_is_harder_that_does_not_yield_or_is_four_times_as_strong(above, below, harder):
    """2 m under the top of the upper one."""
    assert base._harder(Material(**below), Material(**above), 2.0) == harder


def test_rock_is_harder_wherever_it_is_written():
    """As a layer under clay, or as the soil itself under a layer of clay."""
    under, over = layer_of(ROCK, "rock", top=-DEPTH), layer_of(CLAY, "clay", bottom=-DEPTH)
    assert base_of(Soil(Material(**CLAY), top=0.0, geostatic=False, layers=(under,))) == "rock"
    assert base_of(Soil(Material(**ROCK), top=0.0, geostatic=False, layers=(over,))) == "soil"


def layer_of(values, name, **ends):
    values = dict(values)
    return Layer(name, **ends, law=values.pop("law"), material=values)


def base_of(soil):
    """Name of the harder layer of a soil of 3 m."""
    grid = Grid(Axis(0.0, 1.0, 0.5), Axis(0.0, 1.0, collapsed=True), Axis(-3.0, 0.5, 0.5))
    simulation = build(Scene(name="soil", grid=grid, soil=soil, gravity=(0.0, 0.0, 0.0), time=Time(1.0, inertia=False),
                             stages=(Stage("rest", 1),)))
    (height, name, _), = base.hard_bases(simulation.scene, simulation.model)
    assert height == -DEPTH
    return name.removeprefix("harder layer ")


def test_a_wall_that_moves_away_from_the_soil_on_a_harder_layer_is_not_reported():
    assert not notes(0.0, below=ROCK, velocity=(-0.0015, 0.0, 0.0))


def test_walls_that_the_base_does_not_hinder_are_not_reported():
    assert not notes(0.05) and not notes(0.0, z_min="roller")
    assert not notes(0.0, material={**CLAY, "law": "hencky", "strength": None})
    assert not notes(0.0, held=("x", "ry"), driven=("z",), velocity=(0.0, 0.0, 0.001))


def test_the_force_is_that_of_the_clay_from_the_limit_on():
    """2 s_u H after 0.0135 H: 47 % too much with the foot on the base."""
    on, above = (list(wall(foot).steps())[-1].bodies[0].contact_force[0] / (-2.0 * STRENGTH * DEPTH) for foot in (0.0, 0.05))
    assert on > 1.3 and above == pytest.approx(1.0, abs=0.03)


def test_the_force_half_a_cell_above_rock_is_that_of_the_clay():
    """2 s_u H; 3 times as much where traces of rock in the cells above it are tied to rock by its own modulus."""
    last = list(wall(0.05, below=ROCK).steps())[-1].bodies[0].contact_force[0] / (-2.0 * STRENGTH * DEPTH)
    assert last == pytest.approx(1.0, abs=0.07)


@pytest.mark.parametrize("cells, found", [(2, 0.18), (4, 0.085), (8, 0.05)])
def test_the_law_of_a_squeezed_layer_is_what_was_measured(cells, found):
    assert base.SQUEEZED / cells == pytest.approx(found, abs=0.01)


@pytest.mark.parametrize("cells, found", [(2, 0.57), (4, 0.20), (8, 0.14)])
def test_the_law_of_a_layer_pressed_by_a_fifth_is_about_what_was_measured(cells, found):
    """Over the load of what is left of the layer."""
    assert (base.SQUEEZED + base.PRESSED * 0.2) / cells == pytest.approx(found, abs=0.1)


@pytest.mark.parametrize("phi, friction, ratio, found", [
    (10.0, 1.0, 4.0, (2.00, 1.23, 1.09)), (20.0, 1.0, 3.0, (2.2, 1.4, 1.13)), (20.0, 1.0, 4.0, (2.59, 1.62, 1.23)),
    (20.0, 0.0, 4.0, (1.6, 1.3, 1.1))])
def test_the_law_of_a_thin_layer_with_friction_is_about_what_was_measured(phi, friction, ratio, found):
    """With 2, 4, 8 cells in it; and the size of cells asked for has the excess that is allowed."""
    material, thick, width = Material(**SAND | {"friction_angle": phi}), 0.5, 0.5 * ratio
    for cells, excess in zip((2, 4, 8), found):
        law, size = base._with_friction(material, friction, thick, width, thick / cells)
        assert 1.0 + law == pytest.approx(excess, rel=0.25 if cells == 2 else 0.09)
    assert base._with_friction(material, friction, thick, width, size)[0] == pytest.approx(base.EXCESS)


@pytest.mark.parametrize("thick, below, count", [(0.4, ROCK, 1), (1.0, ROCK, 0), (0.4, SAND, 0)])
def test_a_strip_that_squeezes_a_thin_layer_of_soil_with_friction_on_a_harder_one(thick, below, count):
    """Beside rock in the grid, its end below the rock is no end of the soil."""
    simulation = strip_on(Material(**{**SAND, "cohesion": 1e3}), thick, below, -0.001, friction=1.0)
    found = list(base.squeezed_layer(simulation.scene, simulation.model))
    assert len(found) == count
    assert all("presses 0.4 m of soil with friction, 2 cells of 0.2 m" in text for text in found)
    assert all("squeezes it out is more than 200% too high, limit 10%" in text for text in found)     # 5.2 times, by the law
    ends = [text for text in margins.narrow_margins(simulation.scene, simulation.model) if "below it" in text]
    assert len(ends) == (below is SAND)


@pytest.mark.parametrize("thick, below, velocity, count", [
    (0.4, ROCK, -0.001, 1), (0.4, {**CLAY, "strength": 4 * STRENGTH}, -0.001, 1), (0.4, CLAY, -0.001, 0),
    (0.4, ROCK, 0.001, 0), (1.0, ROCK, -0.001, 0)])
def test_a_strip_that_squeezes_a_thin_layer_of_clay_on_a_harder_one(thick, below, velocity, count):
    """1.6 m wide, in cells of 0.2 m."""
    simulation = strip_on(Material(**CLAY), thick, below, velocity, adhesion=1.0)
    found = list(base.squeezed_layer(simulation.scene, simulation.model))
    assert len(found) == count
    assert all("presses 0.4 m of clay, 2 cells of 0.2 m" in text and "out is about 19% too high" in text for text in found)


def test_the_fixed_base_of_the_grid_under_a_thin_layer():
    """Its usual model of rock: the same excess, by its name."""
    layered = strip_on(Material(**{**SAND, "cohesion": 1e3}), 0.4, ROCK, -0.001, friction=1.0).scene
    grid = replace(layered.grid, z=Axis(-0.4, 0.4, 0.2), faces=Faces(z_min="fixed"))
    simulation = build(replace(layered, grid=grid, soil=replace(layered.soil, layers=())))
    text, = base.squeezed_layer(simulation.scene, simulation.model)
    assert "presses 0.4 m of soil with friction, 2 cells of 0.2 m, on the fixed base of the grid: the load" in text
    crust = layer_of(ROCK, "crust", bottom=-0.2)        # elastic, of no limit load, over soil that yields
    simulation = build(replace(layered, grid=grid, soil=replace(layered.soil, layers=(crust,))))
    assert not list(base.squeezed_layer(simulation.scene, simulation.model))


def strip_on(material, thick, below, velocity, **interface):
    strip = Body(GEOMETRY / "box.geo", 1000.0, name="strip", position=(0.0, 0.5, 0.0), rest_on=0.0,
                 parameters={"length": 1.6, "width": 1.0, "height": 0.4, "size": 20.0}, held=("x", "ry"), driven=("z",),
                 velocity=(0.0, 0.0, velocity), **interface)
    grid = Grid(Axis(0.0, 4.0, 0.2), Axis(0.0, 1.0, collapsed=True), Axis(-1.2, 0.4, 0.2))
    soil = Soil(material, top=0.0, geostatic=False, layers=(layer_of(below, "under", top=-thick),))
    return build(Scene(name="strip", grid=grid, soil=soil, gravity=(0.0, 0.0, 0.0), bodies=(strip,),
                       time=Time(1.0, inertia=False), stages=(Stage("press", 2),)))
