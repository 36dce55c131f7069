"""Edges of bodies that tumble into one another."""

from dataclasses import replace

import numpy as np
import pytest
from flying_bodies import G, kinetic, run, scene

from hybrid.contact import body_to_body
from hybrid.scene import Body
from hybrid.study.scenes import box

WEDGE = """SetFactory("OpenCASCADE");
DefineConstant[ side = {1.0, Name "Parameters/side"} ];
Mesh.MeshSizeMin = 20; Mesh.MeshSizeMax = 20;
Point(1) = {-side/2, -side/2, -side/2}; Point(2) = {side/2, -side/2, -side/2}; Point(3) = {-side/2, -side/2, side/2};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 1}; Curve Loop(1) = {1, 2, 3}; Plane Surface(1) = {1};
out[] = Extrude {0, side, 0} { Surface{1}; };
Physical Volume("body") = {out[1]}; Physical Surface("contact") = Abs(Boundary{ Volume{out[1]}; });
"""
ANGLE = """SetFactory("OpenCASCADE");
DefineConstant[ side = {1.0, Name "Parameters/side"} ];
Mesh.MeshSizeMin = 20; Mesh.MeshSizeMax = 20;
Box(1) = {-side/2, -side/2, -side/2, side, side, 0.4*side}; Box(2) = {-side/2, -side/2, -side/2, 0.4*side, side, side};
BooleanUnion(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
Physical Volume("body") = {3}; Physical Surface("contact") = Abs(Boundary{ Volume{3}; });
"""


def test_edges_of_bodies_that_tumble_into_one_another_create_no_energy(tmp_path, monkeypatch):
    """A wedge and an angle. A place that is deep in the other body when it comes to look at one of its sides begins without
    force; in the broken variant with that of all of its depth."""
    for name, text in (("wedge", WEDGE), ("angle", ANGLE)):
        (tmp_path / f"{name}.geo").write_text(text)
    wedge = Body(tmp_path / "wedge.geo", 510.0, name="wedge", parameters={"side": 0.4119935794185126}, friction=0.0,
                 position=(0.0, 0.07331236999726828, 2.9012870108162248), velocity=(0.5613436482272174, 0.0, 0.0),
                 rotation=(-2.13776035232065, -0.03737255129589478, 1.1108587227241173, 110.99700768305132),
                 spin=(-0.7258823736273858, 1.220882353762482, -0.2878744772998454))
    angle = Body(tmp_path / "angle.geo", 719.0, name="angle", parameters={"side": 0.34714714847898775}, friction=0.0,
                 position=(0.75, -0.07781049440439708, 3.0012538103337967), velocity=(-1.0754972672789722, 0.0, 0.0),
                 rotation=(0.6181252152801249, 1.1860229612831674, -0.6153347881509634, 139.357704102392),
                 spin=(1.4765713015465716, -2.3899833745231294, -1.2529315260815572))
    described = scene([wedge, angle], 120, 1e-3, gravity=(0.0, 0.0, 0.0))
    begin, kept = body_to_body.begin, []

    def unbounded(*given):
        begun = begin(*given)
        return replace(begun, rest=np.where(begun.touching, begun.rest, -begun.places.depth),
                       overlap=np.full(len(begun), np.inf))

    for law in (begin, unbounded):
        monkeypatch.setattr(body_to_body, "begin", law)
        simulation, records = run(described)
        assert any(record.pairs[0].force.any() for record in records)
        kept.append(kinetic(simulation, simulation.state.bodies) / kinetic(simulation, simulation.initial_bodies))
    assert kept[0] == pytest.approx(1.0, abs=0.03) and kept[1] > 3.0


@pytest.mark.parametrize("steps", [80, pytest.param(180, marks=pytest.mark.slow)])
def test_boxes_that_tumble_onto_one_another_gain_no_energy(steps):
    """Corners and edges first: both fall turned by 40 and 30 degrees. After 1.8 s the lower one lies flat on the slab."""
    slab = box(3.0, 3.0, 0.5, name="slab", position=(0.0, 0.0, 2.0), held=("x", "y", "z", "rx", "ry", "rz"), friction=0.4)
    low = box(0.5, 0.4, 0.3, name="low", position=(0.0, 0.0, 2.75), rotation=(1.0, 0.4, 0.2, 40.0), friction=0.4)
    high = box(0.6, 0.2, 0.2, name="high", position=(0.05, 0.1, 3.3), rotation=(0.2, 1.0, 0.5, 30.0), friction=0.4,
               spin=(0.0, 0.0, 2.0))
    simulation, records = run(scene([slab, low, high], steps, 0.01))
    assert max(r.energies["error"] for r in records) < 1e-6
    # by how they tumble: 5 to 12 mm in steps of 10, 5 and 1.25 ms
    assert max(p.overlap for r in records for p in r.pairs) < 12e-3
    if steps < 180:
        return
    lying = simulation.state.bodies[1]
    assert lying.position[2] == pytest.approx(2.4, abs=1e-3) and np.abs(lying.velocity).max() < 1e-2
    assert records[-1].pairs[0].force[2] == pytest.approx(-simulation.masses[1].mass * G, rel=0.01)
