"""Bodies lowered under clay or sand, as a trapdoor is: too little of it rests on few cells, which is unsafe and reported."""

from dataclasses import replace

import pytest
from limit_texts import limit_texts

from hybrid.monitors.limits import cells, sand_cells, trapdoors
from hybrid.scene import Axis, Faces, Grid, Material, Soil, Time
from hybrid.study.random.fresh.problem import PUSHED, body, scene
from hybrid.study.random.fresh.problem import clay as clay_of


def trapdoor(across, velocity=-0.001):
    """Half of a door of 2 m under 2 m of clay, with `across` cells in its width."""
    size = 2.0 / across
    grid = Grid(Axis(0.0, 5.0, size), Axis(0.0, 1.0, collapsed=True), Axis(-1.0, 2.5, size), Faces())
    door = body("box.geo", {"length": 2.0, "width": 1.0, "height": 0.5, "size": 20.0}, name="door",
                position=(0.0, 0.5, -0.25), velocity=(0.0, 0.0, velocity), **PUSHED)
    soil = Soil(clay_of(1e4), top=2.0, lower=(0.0, 0.0, 0.0), geostatic=False)
    return scene("trapdoor", grid, soil, [door], Time(1.0, inertia=False), 10)


@pytest.mark.parametrize("across, exact, found", [(8, 11.65, 8.13), (16, 11.65, 10.03), (32, 11.65, 10.99)])
def test_the_law_of_trapdoors_is_what_was_measured(across, exact, found):
    assert found / exact == pytest.approx(1 - trapdoors.TRAPDOOR / across, abs=0.02)


def test_a_door_lowered_under_clay_is_reported_and_not_as_one_that_is_pushed_in():
    text, = limit_texts(trapdoors.trapdoors, trapdoor(16))
    assert "16 cells wide and is lowered" in text and "14% too low" in text
    assert not limit_texts(cells.few_cells, trapdoor(16))
    for silent in (trapdoor(32), trapdoor(16, velocity=0.001)):
        assert not limit_texts(trapdoors.trapdoors, silent)


@pytest.mark.parametrize("across, dilation, lacks", [
    (4, 30.0, 0.45), (8, 30.0, 0.23), (16, 30.0, 0.08), (8, 0.0, 0.09), (8, 20.0, 0.09)])
def test_the_law_of_trapdoors_under_sand_is_what_was_measured(across, dilation, lacks):
    sand = Material(law="mohr-coulomb", young=1e7, poisson=0.3, density=1800.0, friction_angle=30.0, dilation_angle=dilation,
                    cohesion=0.0)
    assert trapdoors._lacks_under_sand(sand) / across == pytest.approx(lacks, abs=0.06)
    under = replace(trapdoor(across), gravity=(0.0, 0.0, -9.81))
    under = replace(under, soil=replace(under.soil, material=sand))
    found = limit_texts(trapdoors.trapdoors, under)
    assert len(found) == (lacks > 0.2 or across == 16 or dilation == 20.0) and all("under sand" in text for text in found)
    assert not limit_texts(sand_cells.footings, under)
