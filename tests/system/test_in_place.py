"""Bodies that are in the soil from the start: what they take of it, and what is left is in equilibrium."""

from dataclasses import replace
from io import StringIO

import numpy as np
import pytest

from hybrid.contact import assembly
from hybrid.contact.search import distances
from hybrid.output.progress import Progress
from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Axis, Body, Faces, Grid, Material, Scene, Soil, Stage, Time
from hybrid.scene.file import load_scene
from hybrid.setup.build import build
from hybrid.setup.plane_strain import section

CLAY = Material(law="von-mises", young=5e6, poisson=0.49, density=1700.0, strength=1e4, cone="plane strain")
HELD = ("x", "y", "z", "rx", "ry", "rz")
STEEL, DEPTH, SLICE = 7850.0, -1.487, 0.05


def scene(geometry, rotation, parameters, material=CLAY, inertia=False, **more):
    body = Body(GEOMETRY / geometry, STEEL, parameters=parameters, position=(0.0, 0.025, DEPTH), rotation=rotation, **more)
    return Scene(name="in place", soil=Soil(material, top=0.0), bodies=(body,), time=Time(0.01, inertia=inertia),
                 grid=Grid(Axis(start=-1.6, end=1.6, size=0.2), Axis(start=0.0, end=SLICE, collapsed=True),
                           Axis(start=-3.0, end=0.2, size=0.2), Faces(z_min="fixed")), stages=(Stage("rest", 2),))


PLATE = ("box.geo", None, {"length": 1.0, "width": 0.1, "height": 0.24, "size": 0.12}), 0.24
THIN = ("box.geo", None, {"length": 1.0, "width": 0.1, "height": 0.03, "size": 0.1}), 0.03
TILTED = ("box.geo", (0.0, 1.0, 0.0, 30.0), {"length": 1.0, "width": 0.1, "height": 0.24, "size": 0.12}), 0.24
PIPE = ("cylinder.geo", (1.0, 0.0, 0.0, 90.0), {"radius": 0.5, "height": 0.3, "size": 0.05}), np.pi / 4


@pytest.mark.parametrize("shape, area, error, force",
                         [(*PLATE, 1e-9, 0.05), (*THIN, 0.02, 0.15), (*TILTED, 0.03, 0.08), (*PIPE, 0.01, 0.05)])
def test_soil_and_steel_are_never_in_one_place_and_what_is_left_carries_the_body(shape, area, error, force):
    """The soil that is taken has the body's volume, no point is inside the body, and the force that holds it is its weight
    less that of this soil: div σ = -ρ g, whatever K0."""
    simulation = build(scene(*shape, held=HELD))
    body, points = simulation.model.bodies[0], simulation.state.points
    full = 3.2 * 3.0 * SLICE
    taken = full - simulation.model.soil.constants.volume.sum()
    assert taken == pytest.approx(area * SLICE, rel=error)
    assert simulation.model.soil.constants.mass.sum() == pytest.approx((full - taken) * CLAY.density)
    motion = simulation.state.bodies[0]
    y = np.where(simulation.model.soil.grid.collapsed, motion.position, points.position) - motion.position
    outside, _ = distances(y @ motion.rotation, section(body, motion.rotation, simulation.model.soil.grid))
    assert outside.min() > 0.0
    assert simulation.imbalance.share < 0.02 and not points.plastic_strain.max() > 1e-9
    held = next(simulation.steps()).bodies[0].contact_force[2]
    assert held == pytest.approx(CLAY.density * 9.81 * area * SLICE, rel=force)
    row, = simulation.sheet()["modelled"]["in place from the start"]
    assert "body is in place: it takes" in row and "settled at the start" in simulation.sheet()["modelled"]


def test_a_body_of_the_soils_density_rests_where_it_is():
    """Free, with inertia: it neither sinks nor rises, and the soil around it does not move."""
    simulation = build(replace(scene(*PLATE[0], inertia=True), stages=(Stage("rest", 5),)))
    same = build(replace(simulation.scene, bodies=(replace(simulation.scene.bodies[0], density=CLAY.density),)))
    heavy = [list(one.steps())[-1].bodies[0].position[2] - DEPTH for one in (simulation, same)]
    assert abs(heavy[1]) < 0.05 * abs(heavy[0]) and heavy[0] < 0.0


def test_a_body_in_place_in_space():
    ball = Body(GEOMETRY / "sphere.geo", STEEL, parameters={"radius": 0.3, "size": 0.1}, position=(0.03, 0.0, -0.61),
                held=HELD)
    side = Axis(start=-0.8, end=0.8, size=0.2)
    simulation = build(Scene(name="ball", grid=Grid(side, side, Axis(start=-1.4, end=0.2, size=0.2), Faces(z_min="fixed")),
                             soil=Soil(Material(relative_density=38.0), top=0.0), bodies=(ball,),
                             time=Time(1.0, inertia=False), stages=(Stage("rest", 1),)))
    taken = 1.6 * 1.6 * 1.4 - simulation.model.soil.constants.volume.sum()
    assert taken == pytest.approx(4 / 3 * np.pi * 0.3**3, rel=0.03)
    density = simulation.model.soil.constants.mass[0] / simulation.model.soil.constants.volume[0]
    force = next(simulation.steps()).bodies[0].contact_force
    assert force[2] == pytest.approx(density * 9.81 * 4 / 3 * np.pi * 0.3**3, rel=0.2)     # three cells in its diameter
    assert np.abs(force[:2]).max() < 0.05 * force[2]


def pile():
    """Half of a pile in clay without weight, pushed sideways by a twentieth of a cell in a step."""
    body = Body(GEOMETRY / "box.geo", 1000.0, parameters={"length": 0.8, "width": 0.8, "height": 2.2, "size": 20.0},
                position=(0.0, 0.0, -0.7), held=("y", "z", "rx", "ry", "rz"), driven=("x",), velocity=(0.01, 0.0, 0.0),
                adhesion=0.5)
    grid = Grid(Axis(start=-2.4, end=2.4, size=0.2), Axis(start=0.0, end=1.4, size=0.2),
                Axis(start=-2.6, end=0.4, size=0.2), Faces(z_min="fixed"))
    clay = replace(CLAY, density=1.0, cone=None)
    return build(Scene(name="pile", grid=grid, soil=Soil(clay, top=0.0), gravity=(0.0, 0.0, 0.0), bodies=(body,),
                       time=Time(1.0, inertia=False), stages=(Stage("push", 1),)))


def test_clay_that_just_touches_a_body_does_not_make_the_tangent_singular():
    """All points around a pile in clay without weight are on the ramp of adhesion."""
    record, = pile().steps()
    assert record.increments == 1 and record.iterations < 20
    assert record.bodies[0].contact_force[0] < -2.0 * 0.8 * 0.4 * 1e4


def test_with_the_ramp_in_its_tangent_it_would(monkeypatch):
    """Of a block in plane strain, pushed down by a quarter of a cell a step."""
    block = Body(GEOMETRY / "box.geo", 1000.0, parameters={"length": 0.8, "width": 1.0, "height": 0.4, "size": 20.0},
                 position=(0.0, 0.5, -1.0), held=("x", "ry"), driven=("z",), velocity=(0.0, 0.0, 0.05), adhesion=0.5)
    grid = Grid(Axis(-2.4, 2.4, 0.2), Axis(0.0, 1.0, collapsed=True), Axis(-2.6, 0.4, 0.2), Faces(z_min="fixed"))
    scene = Scene(name="block", grid=grid, soil=Soil(replace(CLAY, density=1.0), top=0.0), gravity=(0.0, 0.0, 0.0),
                  bodies=(block,), time=Time(1.0, inertia=False), stages=(Stage("push", 1),))
    record, = build(scene).steps()
    assert record.increments == 1 and record.iterations < 25
    derivative = assembly.derivative
    monkeypatch.setattr(assembly, "derivative", lambda contact, kind: derivative(
        contact, assembly.Tangent.UNSOFTENED if kind is assembly.Tangent.DEFINITE else kind))
    record, = build(scene).steps()
    assert record.increments > 1 and record.iterations > 30


@pytest.mark.parametrize("place, asks", [(-0.05, True), (-0.15, True), (-0.4, False), (-1.0, False), (0.0, None)])
def test_a_body_that_hardly_overlaps_the_ground_is_asked_whether_that_is_meant(place, asks):
    """Before the first step, in the terminal: less than a cell of 0.2 m deep may be a wrong number."""
    described = scene(*PIPE[0], held=HELD)
    simulation = build(replace(described, bodies=(replace(described.bodies[0], rest_on=place),)))
    rows = simulation.start.get("in place from the start", [])
    assert [("only" in row and 'set body.rest_on = "ground"' in row) for row in rows] == ([] if asks is None else [asks])
    if asks:
        assert f"only {-place:g} m deep in the ground, {-place / 0.2:g} cells, limit 1" in rows[0]
    stream = StringIO()
    Progress(stream).start(simulation)
    assert stream.getvalue().splitlines() == rows


def test_around_a_shaft_with_a_tip_no_more_soil_is_cut_than_it_takes():
    """A penetrometer, whose tip makes bounds of distances far smaller than gaps. Sampled with such bounds, domains that
    touch it nowhere were cut by a thousandth, so that their faces counted as exposed: 1.31 of the area of the shaft, 4 %
    more soil."""
    demo = GEOMETRY.parent / "demos" / "cone.toml"
    simulation = build(load_scene(demo, ["body.cone.rest_on=-2.5", "stage.0.steps=1"]))
    radius, length = 0.5, 0.5 / np.tan(np.pi / 6)
    model, body = simulation.model, simulation.model.bodies[0]
    reach = 4.5**2 * 7.5 - model.soil.constants.volume.sum()
    assert reach == pytest.approx(np.pi * radius**2 * (2.5 - length * 2 / 3) / 4, rel=0.015)
    history = simulation.state.contacts[0]
    place = history.position - simulation.state.bodies[0].position
    up = place[:, 2] - body.surface.vertices[:, 2].min() - length
    along = history.touching & (up > 0.5) & (up < 1.5)
    normal = place * [1.0, 1.0, 0.0] / np.hypot(*place[:, :2].T)[:, None]
    points = simulation.state.points
    area = (body.places.area(history.place, points.half_width[history.point], model.soil.constants.volume[history.point])
            * body.places.projected_share(history.place, normal))
    assert area[along].sum() == pytest.approx(np.pi / 2 * radius, rel=0.05)


BUCKET = """SetFactory("OpenCASCADE");
Mesh.MeshSizeMin = 2; Mesh.MeshSizeMax = 2;
Box(1) = {-1.5, 0, -1, 3, 1, 1.4};      // 3 m wide, with skirts 1 m long and 0.5 m thick below a lid at z = 0
Box(2) = {-1, -1, -2, 2, 3, 2};
BooleanDifference{ Volume{1}; Delete; }{ Volume{2}; Delete; }
Physical Volume("body") = {1};
Physical Surface("contact") = Abs(Boundary{ Volume{1}; });
"""


def test_a_lid_that_lies_on_clay_is_bonded_as_the_skirts_in_it_are(tmp_path):
    """A bucket in clay without weight, pulled and pushed alike: the lid, for which no soil was taken, carried nothing up."""
    (tmp_path / "bucket.geo").write_text(BUCKET)
    grid = Grid(Axis(start=-5.0, end=5.0, size=0.5), Axis(start=0.0, end=1.0, collapsed=True),
                Axis(start=-5.0, end=1.0, size=0.5), Faces(z_min="fixed"))
    forces = []
    for velocity in (0.01, -0.01):
        bucket = Body(tmp_path / "bucket.geo", STEEL, position=(0.1, 0.0, 0.0), held=("x", "ry"), driven=("z",),
                      velocity=(0.0, 0.0, velocity), tension="full", adhesion=1.0)
        simulation = build(Scene(name="bucket", grid=grid, soil=Soil(CLAY, top=0.0), bodies=(bucket,),
                                 gravity=(0.0, 0.0, 0.0), time=Time(1.0, inertia=False), stages=(Stage("move", 3),)))
        forces.append(list(simulation.steps())[-1].bodies[0].contact_force[2])
    assert forces[1] > 0.0 and forces[0] == pytest.approx(-forces[1], rel=0.05)


def test_soil_in_a_bucket_is_carried_by_it(tmp_path):
    """A bucket open at its top, level with the soil around it, whose content touches no other soil: lifted out of it, it
    carries the weight of that."""
    bucket = (BUCKET.replace("{-1.5, 0, -1, 3, 1, 1.4}", "{-0.75, 0, -0.75, 1.5, 1, 1}")
              .replace("{-1, -1, -2, 2, 3, 2}", "{-0.5, -1, -0.5, 1, 3, 3}"))
    (tmp_path / "bucket.geo").write_text(bucket)
    grid = Grid(Axis(start=-2.0, end=2.0, size=0.125), Axis(start=0.0, end=1.0, collapsed=True),
                Axis(start=-1.5, end=2.0, size=0.125), Faces(z_min="fixed"))
    body = Body(tmp_path / "bucket.geo", STEEL, held=("x", "ry"), driven=("z",), velocity=(0.0, 0.0, 0.4))
    soil = Soil(Material(law="hencky", young=5e6, poisson=0.3, density=1700.0), top=0.0)
    simulation = build(Scene(name="bucket", grid=grid, soil=soil, bodies=(body,), time=Time(0.1),
                             stages=(Stage("lift", 25),)))
    weight = 1700.0 * 9.81 * 1.0 * 0.5
    assert "settled at the start" in simulation.sheet()["modelled"]
    forces = [record.bodies[0].contact_force[2] for record in simulation.steps()]
    assert np.mean(forces[-10:]) == pytest.approx(-weight, rel=0.02)    # it swings a little on the bucket
