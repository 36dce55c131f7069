"""Bodies that slide past each other on a line of the grid: the force that this makes wrong, and the note about it."""

import pytest

from hybrid.monitors.limits.shear_gap import shear_on_a_line
from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Axis, Body, Grid, Material, Scene, Soil, Stage, Time
from hybrid.setup.build import build

STRENGTH, CELL, LENGTH = 20e3, 0.125, 2.0
CLAY = Material(law="von-mises", young=10e6, poisson=0.49, density=1.0, strength=STRENGTH)
HALF = """SetFactory("OpenCASCADE");
DefineConstant[height = {0.5, Name "Parameters/height"}];   // [m] of the walls over the base of half a shear box
Mesh.MeshSizeMin = 2; Mesh.MeshSizeMax = 2;
Box(1) = {-1.5, -0.5, -0.5, 3, 1, height + 0.5};
Box(2) = {-1, -1, 0, 2, 2, height + 1};
BooleanDifference{ Volume{1}; Delete; }{ Volume{2}; Delete; }
Physical Volume("body") = {1};
Physical Surface("contact") = Abs(Boundary{ Volume{1}; });
"""


HELD = ("x", "y", "z", "rx", "ry", "rz")
SLIDES = {"held": ("y", "z", "rx", "ry", "rz"), "driven": ("x",), "velocity": (0.003, 0.0, 0.0)}


def scene(bodies, lower, upper):
    """Simulation of two bodies in plane strain, with clay between two corners [m]."""
    grid = Grid(Axis(-1.5, 1.5, CELL), Axis(0.0, 1.0, collapsed=True), Axis(-1.0, 1.0, CELL))
    soil = Soil(CLAY, lower=(lower[0], 0.0, lower[1]), upper=(upper[0], 1.0, upper[1]))
    return build(Scene(name="sheared", grid=grid, soil=soil, gravity=(0.0, 0.0, 0.0), bodies=bodies,
                       time=Time(1.0, inertia=False), stages=(Stage("shear", 20),)))


def shear_box(folder, gap, off, filled=0.5, **motion):
    """Shear box full of clay up to `filled` [m]; the upper half, which `motion` describes, is a `gap` [m] above the lower
    one, the middle of the gap `off` [m] above a line of the grid."""
    (folder / "half.geo").write_text(HALF)
    lower, upper = (Body(folder / "half.geo", 2000.0, name=name, position=(0.0, 0.5, z), parameters={"height": height},
                         **how) for name, z, height, how in
                    (("lower", -0.5, 0.5 - gap / 2 + off, {"held": HELD}),
                     ("upper", 0.5, 0.5 - gap / 2 - off, {"rotation": (0, 1, 0, 180.0), **SLIDES, **motion})))
    return scene((lower, upper), (-1.0, -0.5), (1.0, filled))


def blocks(where, surface):
    """Two solid blocks beside or upon each other, their centres at `where` (x, z) [m], over clay up to `surface` [m]."""
    size = {"length": 1.0, "width": 1.0, "height": 0.25, "size": 20.0}
    lower, upper = (Body(GEOMETRY / "box.geo", 2000.0, name=name, parameters=size, position=(x, 0.5, z), **how)
                    for name, (x, z), how in zip(("lower", "upper"), where, ({"held": HELD}, SLIDES)))
    return scene((lower, upper), (-1.5, -1.0), (1.5, surface))


def notes(simulation):
    return list(shear_on_a_line(simulation.scene, simulation.model))


@pytest.mark.parametrize("off, least, most", [(0.0, 1.6, 1.9), (CELL / 2, 0.97, 1.2)])
def test_a_shear_box_that_is_cut_on_a_line_is_too_strong(tmp_path, off, least, most):
    """After half a cell, over s_u times the area that is left; within 2 % at first with the gap in the middle of a row."""
    simulation = shear_box(tmp_path, 0.02, off)
    force = -[record.bodies[1].contact_force[0] for record in simulation.steps()][-1]
    assert least < force / (STRENGTH * (LENGTH - 0.06)) < most
    assert bool(notes(simulation)) == (off == 0.0)


@pytest.mark.parametrize("gap, off, finer", [(0.02, 0.0, False), (0.02, 0.05, False), (0.0625, 0.0, True)])
def test_bodies_that_slide_on_a_line_are_reported(tmp_path, gap, off, finer):
    found, = notes(shear_box(tmp_path, gap, off))
    assert f"gap of {gap:.2g} m at the line of the grid z = 0 m, limit one cell, 0.125 m" in found
    assert "Move the lines of the grid along z by half a cell" in found
    assert ("use cells of at most" in found) == finer


@pytest.mark.parametrize("gap, off", [(CELL, 0.0), (0.02, CELL / 2), (0.0625, 0.05)])
def test_gaps_in_which_a_row_is_sheared_are_not_reported(tmp_path, gap, off):
    assert not notes(shear_box(tmp_path, gap, off))


def test_bodies_that_do_not_slide_or_have_no_soil_across_the_gap_are_not_reported(tmp_path):
    rises = {"driven": ("z",), "held": ("x", "y", "rx", "ry", "rz"), "velocity": (0.0, 0.0, 0.002)}
    assert not notes(shear_box(tmp_path, 0.02, 0.0, **rises))
    assert not notes(shear_box(tmp_path, 0.02, 0.0, held=HELD, driven=(), velocity=(0.0, 0.0, 0.0)))
    assert not notes(shear_box(tmp_path, 0.02, 0.0, filled=0.0))


def test_blocks_on_the_surface_are_not_reported():
    """One upon the other, with the joint on a line; side by side, with the gap on a line; and one upon a buried one."""
    assert not notes(blocks(((0.0, 0.125), (0.0, 0.375)), 0.0))
    assert not notes(blocks(((-0.51, 0.125), (0.51, 0.125)), 0.0))
    assert not notes(blocks(((0.0, -0.125), (0.0, 0.125)), 0.0))
