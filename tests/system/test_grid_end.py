"""Soil that spreads to an end of the grid is held there from then on, which is told; not where it was held from the
start, or where nothing holds it."""

from dataclasses import replace

import pytest

from hybrid.scene import Axis, Faces, Grid, Stage, Time
from hybrid.setup.build import build
from hybrid.study.scenes import NO_OUTPUT, box, soil_scene


def notes(end=1.0, faces=(), **time):
    """Of half an elastic specimen of 0.5 m x 1 m in plane strain, pressed together by 40 % in cells of 0.25 m."""
    platen = box(3.0, 1.0, 0.2, size=20.0, position=(0.0, 0.5, 0.0), rest_on=1.0, held=("x", "ry"), driven=("z",),
                 velocity=(0.0, 0.0, -0.05))
    grid = Grid(Axis(0.0, end, 0.25), Axis(0.0, 1.0, collapsed=True), Axis(0.0, 1.25, 0.25), Faces(**dict(faces)))
    scene = replace(soil_scene([platen], young=1e6, poisson=0.45, time=Time(step=1.0, **{"inertia": False} | time)),
                    grid=grid, stages=(Stage("press", 8),), output=NO_OUTPUT)
    soil = replace(scene.soil, top=None, lower=(0.0, 0.0, 0.0), upper=(0.5, 1.0, 1.0))
    records = build(replace(scene, soil=soil)).steps()
    return [note for record in records for note in record.notes if "the end of the grid at" in note]


@pytest.mark.parametrize("inertia, wrong", [(False, "forces are too large"), (True, "it runs no farther")])
def test_soil_that_reaches_an_end_of_the_grid_that_holds_it_is_told_once(inertia, wrong):
    text, = notes(inertia=inertia)
    assert wrong in text
    assert text.startswith("soil has spread to the last cell before the end of the grid at x = 1 m at t = ")
    assert "Move grid.x.end outwards" in text


@pytest.mark.parametrize("other", [{"end": 2.0}, {"end": 0.5}, {"faces": {"x_max": "free"}},
                                   {"faces": {"x_max": "free", "z_min": "fixed"}}])
def test_other_ends_are_not(other):
    assert notes(**other) == []
