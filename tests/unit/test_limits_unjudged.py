"""A body of few cells has a message where no other limit knows by how much its load is wrong."""

from dataclasses import replace

import pytest
from put_on_soil import put_on_soil

from hybrid.monitors.limits import limit_warnings
from hybrid.monitors.limits.unjudged import unjudged
from hybrid.scene import Motion, Stage
from hybrid.setup.build import build
from hybrid.study.scenes import box


def texts(size, z=-0.01, messages=(), **given):
    """About a smooth block of 0.6 m x 0.6 m that is driven along z, its edges a quarter of a cell from lines of the grid."""
    block = box(0.6, 0.6, 0.3, density=1e3, position=(0.05, 0.05, 0.0), rest_on=0.0, held=("x", "y", "rx", "ry", "rz"),
                driven=("z",), velocity=(0.0, 0.0, z), friction=0.0)
    scene = put_on_soil(block, size=size, x=(-1.2, 1.2), y=(-1.2, 1.2), z=(-1.2, 0.6), steps=5, **given)
    simulation = build(scene)
    return list(unjudged(simulation.scene, simulation.model, messages)), limit_warnings(simulation.scene, simulation.model)


@pytest.mark.parametrize("size, count", [(0.2, 1), (0.15, 0)])
def test_a_block_of_three_cells_is_told_of_and_one_of_four_is_not(size, count):
    found, all_texts = texts(size)
    assert len(found) == count == sum("too few to predict its load" in text for text in all_texts)
    assert all("body is 3 cells of 0.2 m wide across its path down, limit 4" in text for text in found)


@pytest.mark.parametrize("way, count", [(2e-3, 0), (3e-3, 1)])
def test_a_block_that_hardly_makes_clay_yield_is_not_told_of(way, count):
    """Half a metre deep, 2 s_u B/E = 2.4 mm."""
    block = box(0.6, 0.6, 0.3, density=1700.0, position=(0.05, 0.05, -0.5), held=("x", "y", "rx", "ry", "rz"),
                driven=("z",), velocity=(0.0, 0.0, -0.2 * way))
    simulation = build(put_on_soil(block, size=0.2, x=(-1.2, 1.2), y=(-1.2, 1.2), z=(-1.2, 0.6), steps=5))
    assert len(list(unjudged(simulation.scene, simulation.model, ()))) == count


TABLE = """// A lid of 3 m on two legs of 0.25 m, a prism along y
Point(1) = {-1.5, 0, -0.8}; Point(2) = {-1.25, 0, -0.8}; Point(3) = {-1.25, 0, 0}; Point(4) = {1.25, 0, 0};
Point(5) = {1.25, 0, -0.8}; Point(6) = {1.5, 0, -0.8}; Point(7) = {1.5, 0, 0.3}; Point(8) = {-1.5, 0, 0.3};
For i In {1:8}
  Line(i) = {i, i % 8 + 1};
EndFor
Curve Loop(1) = {1:8}; Plane Surface(1) = {1};
made[] = Extrude {0, 1, 0} { Surface{1}; };
Physical Volume("body") = {made[1]};
Physical Surface("contact") = {1, made[0], made[2]:made[9]};
"""


@pytest.mark.parametrize("size, count", [(0.2, 1), (0.0625, 0)])
def test_the_legs_of_a_body_count_and_not_the_body(size, count, tmp_path):
    (tmp_path / "table.geo").write_text(TABLE)
    table = replace(box(1.0, 1.0, 1.0), geometry=tmp_path / "table.geo", parameters={}, density=1e3, rest_on=0.0,
                    held=("x", "ry"), driven=("z",), velocity=(0.0, 0.0, -0.05))
    simulation = build(put_on_soil(table, size=size, x=(0.0, 3.0), z=(-2.0, 1.0), steps=5))
    found = list(unjudged(simulation.scene, simulation.model, ()))
    assert len(found) == count
    assert all("body has 2 parts ahead, one 1.3 cells of 0.2 m wide across its path down, limit 4" in text for text in found)


def test_a_belt_under_the_soil_pushes_none():
    """It is driven along x below all of it."""
    belt = box(1.0, 0.6, 0.3, density=1e3, position=(0.0, 0.0, -0.45), held=("y", "z", "rx", "ry", "rz"), driven=("x",),
               velocity=(0.05, 0.0, 0.0), friction=0.3)
    for lower, count in ((-0.6, 1), (-0.2, 0)):
        scene = put_on_soil(belt, size=0.2, x=(-1.2, 1.2), y=(-1.2, 1.2), z=(-1.2, 0.6), steps=5)
        scene = replace(scene, soil=replace(scene.soil, lower=(-1.2, -1.2, lower), geostatic=False))
        simulation = build(scene)
        assert len(list(unjudged(simulation.scene, simulation.model, ()))) == count


def test_what_hardly_moves_or_has_its_own_limit_is_not():
    assert not texts(0.2, z=-1e-4)[0] and not texts(0.2, messages=["body has 3 cells in its base"])[0]
    assert texts(0.2, messages=["other has 3 cells in its base"])[0] and texts(0.2, messages=["bodyguard has 3 cells"])[0]


def test_a_block_that_is_pushed_down_and_forwards_at_once():
    block = box(0.6, 0.6, 0.3, density=1e3, position=(0.05, 0.05, 0.0), rest_on=0.0, held=("y", "rx", "ry", "rz"),
                driven=("x", "z"), velocity=(0.01, 0.0, -0.01), friction=0.3)
    scene = put_on_soil(block, size=0.2, x=(-1.2, 1.2), y=(-1.2, 1.2), z=(-1.2, 0.6), steps=5)
    plough = Stage("plough", 5, motions=(Motion(component="z", velocity=0.0),))
    simulation = build(replace(scene, stages=(*scene.stages, plough)))
    assert sum("too few to predict its load" in text for text in limit_warnings(simulation.scene, simulation.model)) == 1
