"""Named parts of a body's surface: their triangles, their areas, and the forces of the soil on each."""

from dataclasses import replace

import numpy as np
import pytest

from hybrid.body.mesh import generate
from hybrid.body.parts import surface_parts
from hybrid.body.smooth_mass import mass_and_surface
from hybrid.output import body_figures
from hybrid.output.history import History, read_history
from hybrid.runtime.data import GEOMETRY
from hybrid.runtime.errors import GeometryError
from hybrid.scene import Axis, Body, Faces, Grid, Material, Scene, Soil, Stage, Time
from hybrid.setup.build import build

R, SLEEVE, EXTENSION, SHAFT = 0.5, 0.6, 0.2, 1.5
CONE = {"radius": R, "angle": 60.0, "shaft": SHAFT, "sleeve": SLEEVE, "extension": EXTENSION, "size": 0.12}
AREAS = {"tip": 2 * np.pi * R**2 + 2 * np.pi * R * EXTENSION, "sleeve": 2 * np.pi * R * SLEEVE,
         "shaft": 2 * np.pi * R * (SHAFT - SLEEVE - EXTENSION) + np.pi * R**2}
SQUARE = """SetFactory("OpenCASCADE"); Mesh.MeshSizeMax = 0.5; Box(1) = {0, 0, 0, 1, 1, 1};
Physical Volume("body") = {1}; Physical Surface("contact") = {1:6}; """


def parts_of(mesh):
    surface = mass_and_surface(mesh, 1.0)[1]
    return surface_parts(mesh, surface, surface)


@pytest.mark.parametrize("symmetry, share", [(None, 1.0), ("y", 0.5)])
def test_a_cone_has_the_areas_of_its_parts(symmetry, share):
    parts = parts_of(generate(GEOMETRY / "cone.geo", CONE, symmetry=symmetry))
    assert dict(zip(parts.names, parts.area / share)) == pytest.approx(AREAS, rel=2e-3)
    down = dict(zip(parts.names, parts.across(np.array([0.0, 0.0, -1.0])) / share))
    assert down == pytest.approx({"tip": np.pi * R**2, "sleeve": 0.0, "shaft": 0.0}, rel=2e-3, abs=1e-3)


def test_a_geometry_without_named_surfaces_has_no_parts():
    assert parts_of(generate(GEOMETRY / "sphere.geo", {"radius": 0.3, "size": 0.1})) is None


def test_what_has_no_name_is_the_rest(tmp_path):
    path = tmp_path / "square.geo"
    path.write_text(SQUARE + 'Physical Surface("under side") = {5}; Physical Surface("empty") = {}; ')
    parts = parts_of(generate(path))
    assert parts.names == ("under side", "rest") and parts.area == pytest.approx([1.0, 5.0])


def test_a_surface_in_two_parts_is_refused(tmp_path):
    path = tmp_path / "square.geo"
    path.write_text(SQUARE + 'Physical Surface("low") = {5}; Physical Surface("both") = {5, 6};')
    with pytest.raises(GeometryError, match="surface 5 is in the physical surfaces 'low' and 'both'.*keep it in one"):
        generate(path)


def pushed(steps=2, **body):
    """Scene of a quarter of a cone whose shoulder is near the surface of elastic soil."""
    side = Axis(start=0.0, end=1.5, size=0.25)
    cone = Body(GEOMETRY / "cone.geo", 1000.0, name="cone", parameters=CONE, rest_on=-0.9, driven=("z",), friction=0.3,
                velocity=(0.0, 0.0, -0.02), held=("x", "y", "rx", "ry", "rz"))
    return Scene(name="pushed", grid=Grid(side, side, Axis(start=-2.0, end=0.5, size=0.25), Faces(z_min="fixed")),
                 soil=Soil(Material(law="hencky", young=1e6, poisson=0.2, density=1500.0), top=0.0, geostatic=False),
                 bodies=(replace(cone, **body),), time=Time(1.0, inertia=False), gravity=(0.0, 0.0, 0.0),
                 stages=(Stage("push", steps),))


@pytest.mark.parametrize("friction", [0.3, pytest.param(0.5, marks=pytest.mark.slow)])
def test_the_mesh_of_its_tip_changes_neither_force_nor_iterations(friction):
    """With edges of one length the mesh has four facets around the tip, which cut through the cone: closest points jump
    there."""
    forces = []
    for size in (0.1, 0.12, 0.2):
        records = list(build(pushed(3, friction=friction, parameters=CONE | {"size": size})).steps())
        assert max(record.iterations for record in records) < 40
        forces.append([record.bodies[0].contact_force[2] for record in records])
    assert np.ptp(forces, axis=0) == pytest.approx(0.0, abs=0.005 * np.max(forces))


def test_forces_of_the_parts_add_up_to_that_of_the_body(tmp_path):
    simulation = build(pushed())
    observer = History(tmp_path)
    observer.start(simulation)
    for record in simulation.steps():
        observer.accepted(record, simulation)
        body = record.bodies[0]
        assert sum(body.parts.values()) == pytest.approx(body.contact_force, rel=1e-12)
    found = read_history(tmp_path)
    for axis in "xyz":
        whole = sum(found[f"cone_contact_{name}_f{axis}_whole_N"] for name in AREAS)
        assert whole == pytest.approx(found[f"cone_contact_f{axis}_whole_N"], rel=1e-12)
    tip = found["cone_contact_tip_fz_N"]
    assert (tip > 0.9 * found["cone_contact_fz_N"]).all() and (found["cone_contact_tip_fz_whole_N"] == 4 * tip).all()
    row, = (value for label, value in simulation.sheet()["modelled"].items() if label.startswith("parts of surfaces"))
    assert row[0].startswith("cone: tip ") and row[0].endswith("of the whole")


def test_edges_and_corners_on_held_ground_belong_to_the_face_that_looks_at_it(tmp_path):
    """A box whose base is named stands on it: nothing is left for its flanks."""
    path = tmp_path / "named.geo"
    path.write_text("""SetFactory("OpenCASCADE");
Box(1) = {-0.1, -0.15, -0.1, 0.2, 0.3, 0.2};
Mesh.MeshSizeMin = 1; Mesh.MeshSizeMax = 1;
low[] = Surface In BoundingBox{-1, -1, -0.101, 1, 1, -0.099};
Physical Volume("body") = {1};
Physical Surface("base") = {low[]};
Physical Surface("contact") = Abs(Boundary{ Volume{1}; });
""")
    axis = Axis(-0.5, 0.5, 0.25)
    stands = Body(path, 1000.0, rest_on=0.0, name="box")
    described = Scene(name="stands", grid=Grid(axis, axis, Axis(-0.25, 0.0, 0.25)),
                      soil=Soil(Material(law="hencky", young=1e7, poisson=0.3, density=1800.0), held=True, geostatic=False),
                      bodies=(stands,), time=Time(0.01, beta=0.5625, gamma=1.0), stages=(Stage("stand", 20),))
    simulation = build(described)
    *_, record = simulation.steps()
    assert simulation.model.bodies[0].ground is not None
    body = record.bodies[0]
    assert body.parts["base"] == pytest.approx(body.contact_force) and body.contact_force[2] > 100.0


def test_their_stresses_are_drawn(tmp_path):
    scene = pushed()
    simulation = build(scene)
    simulation.run([History(tmp_path)])
    areas = {"cone": {"tip": (2.0, {axis: (0.8, 0.1) for axis in "xyz"})}}
    initial = {"cone": simulation.initial_bodies[0].position}
    assert body_figures.parts(tmp_path, initial, areas).stat().st_size > 5000
    assert body_figures.parts(tmp_path, initial, {}) is None


def test_the_way_of_a_figure_begins_where_its_stage_does(tmp_path):
    """From the start of the run in its first stage, whose first step the history has at its end."""
    simulation = build(pushed(3))
    simulation.run([History(tmp_path)])
    history, initial = read_history(tmp_path), simulation.initial_bodies[0].position
    (axis, way), = body_figures.driven_ways(history, "cone", initial)
    place = "xyz".index(axis)
    assert way[-1] == simulation.state.bodies[0].position[place] - initial[place] and len(way) == len(history["step"])
    later = {name: values.copy() for name, values in history.items()}
    later["stage"][-2:] = "second"
    (_, way), = body_figures.driven_ways(later, "cone", initial)
    assert len(way) == 2 and way[-1] == pytest.approx(history[f"cone_{axis}_m"][-1] - history[f"cone_{axis}_m"][-3])


def test_parts_of_a_prism_are_those_of_its_slice(tmp_path):
    path = tmp_path / "square.geo"
    path.write_text(SQUARE + 'Physical Surface("under side") = {5}; Physical Surface("end") = {3};')
    body = Body(path, 1000.0, name="block", position=(-0.5, -0.5, 0.0), driven=("z",), velocity=(0.0, 0.0, -0.01),
                held=("x", "y", "rx", "ry", "rz"))
    scene = replace(pushed(1), bodies=(body,), grid=Grid(
        Axis(start=-1.5, end=1.5, size=0.25), Axis(start=-0.1, end=0.1, collapsed=True),
        Axis(start=-2.0, end=0.5, size=0.25),
        Faces(z_min="fixed")))
    simulation = build(scene)
    parts = simulation.model.bodies[0].parts
    assert dict(zip(parts.names, parts.area)) == pytest.approx({"under side": 0.2, "end": 0.0, "rest": 0.6})
    record, = simulation.steps()
    assert record.bodies[0].parts["under side"][2] > 0.9 * record.bodies[0].contact_force[2] > 0.0
