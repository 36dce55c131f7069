"""Bases with holes on clay: the warning counts the cells in their bars, whatever the width of the whole."""

import re

import pytest

from hybrid.monitors.limits import bars
from hybrid.scene import Axis, Body, Faces, Grid, Material, Motion, Scene, Soil, Stage, Time
from hybrid.setup.build import build

# Holes of 0.6 m in a mat of 1.6 m; found 44.33 and 36.97 kN a quarter with 10 and 20 cells to a metre, pressed by 15 mm
FOUND = {0.1: 44.33, 0.05: 36.97}
MAT = """SetFactory("OpenCASCADE");
Mesh.MeshSizeMin = 0.3; Mesh.MeshSizeMax = 0.3;
Box(1) = {-0.8, -0.8, 0, 1.6, 1.6, 0.3};
Box(2) = {0.1, 0.1, -1, 0.6, 0.6, 3};
Box(3) = {-0.7, 0.1, -1, 0.6, 0.6, 3};
Box(4) = {0.1, -0.7, -1, 0.6, 0.6, 3};
Box(5) = {-0.7, -0.7, -1, 0.6, 0.6, 3};
v() = BooleanDifference{ Volume{1}; Delete; }{ Volume{2:5}; Delete; };
Physical Volume("body") = {v()};
Physical Surface("contact") = Abs(Boundary{ Volume{v()}; });
"""
HOLES = MAT[MAT.index("Box(2)"):MAT.index("Physical")]
WHOLE = MAT.replace(HOLES, "v() = {1};\n")


def pressed(tmp_path, geometry, size, law="von-mises"):
    """Warnings about the quarter of a mat that is pressed on the ground."""
    path = tmp_path / "mat.geo"
    path.write_text(geometry)
    side = Axis(0.0, 2.0, size)
    strength = {"strength": 2e4} if law == "von-mises" else {"friction_angle": 30.0, "cohesion": 1e3, "dilation_angle": 0.0}
    mat = Body(path, 2400.0, name="mat", rest_on=0.0, held=("x", "y", "rx", "ry", "rz"))
    described = Scene(
        name="mat", grid=Grid(side, side, Axis(-1.0, 0.4, size), Faces(z_min="fixed")), bodies=(mat,),
        soil=Soil(Material(law=law, young=2e7, poisson=0.3, density=1800.0, **strength), top=0.0),
        time=Time(1.0, inertia=False), gravity=(0.0, 0.0, 0.0),
        stages=(Stage("press", 1, motions=(Motion(component="z", displacement=((0.0, 0.0), (1.0, -0.015))),)),))
    simulation = build(described)
    return list(bars.bars(simulation.scene, simulation.model))


@pytest.mark.parametrize("size, number", [(0.1, "1.4 cells"), (0.2, "0.7 cells")])
def test_the_cells_in_bars_are_judged(tmp_path, size, number):
    text, = pressed(tmp_path, MAT, size)
    assert number in text and text.startswith("mat presses clay") and "at most 0.02 m" in text
    share = float(re.search(r"up to (\d+)%", text)[1])
    if size in FOUND:
        exact = 2 * FOUND[0.05] - FOUND[0.1]
        assert 1.0 < (1.0 + share / 100) / (FOUND[size] / exact) < 1.1


TRIANGLE = WHOLE.replace("Box(1) = {-0.8, -0.8, 0, 1.6, 1.6, 0.3};", """
Point(1) = {-0.5, -0.5, 0}; Point(2) = {0.5, -0.5, 0};
Point(3) = {0, 0.5, 0}; Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 1}; Curve Loop(1) = {1:3}; Plane Surface(1) = {1};
Extrude {0, 0, 0.3} { Surface{1}; }""")


@pytest.mark.parametrize("geometry, law", [(TRIANGLE, "von-mises"), (WHOLE, "von-mises"), (MAT, "drucker-prager")])
def test_a_base_without_holes_has_no_bars_and_sand_is_not_judged_so(tmp_path, geometry, law):
    assert pressed(tmp_path, geometry, 0.2, law) == []
