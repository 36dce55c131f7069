"""Planes of symmetry are found by the bodies in them; what is reported of the whole is that of a model of the whole."""

import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fake_run import FakeSimulation

import hybrid
from hybrid.body.symmetry import Mirror, whole_columns
from hybrid.output import history, progress, summary
from hybrid.runtime.errors import SceneError
from hybrid.scene import Axis, Body, Faces, Grid, Joint, Load, Material, Motion, Output, Scene, Soil, Stage, Time
from hybrid.setup.build import build
from hybrid.study.scenes import soil_scene

GEOMETRY = Path(hybrid.__file__).parents[1] / "geometry"
SIDE, SIZE = 0.6, 0.15
HALF, WHOLE = Axis(0.0, SIDE, SIZE), Axis(-SIDE, SIDE, SIZE)


def pressed(x=WHOLE, y=WHOLE, steps=2, **body):
    """Scene of a ball of r = 0.3 m that goes down and along x into elastic soil, as far as the cells allow."""
    ball = Body(GEOMETRY / "sphere.geo", 2000.0, name="ball", parameters={"radius": 0.3, "size": 0.06}, rest_on=-0.002,
                velocity=(0.0, 0.0, -0.1), driven=("z",), held=("x", "y", "rx", "ry", "rz"), friction=0.3)
    return Scene(name="pressed", grid=Grid(x, y, Axis(-0.6, 0.6, SIZE), Faces(z_min="fixed")),
                 soil=Soil(Material(law="hencky", young=1e6, poisson=0.2, density=1500.0), top=0.0),
                 bodies=(replace(ball, **body),), time=Time(0.02), stages=(Stage("press", steps),), output=Output(every=0))


def last(scene):
    simulation = build(scene)
    *_, record = simulation.steps()
    return simulation, record.row()


@pytest.fixture(scope="module")
def whole():
    return last(pressed())


@pytest.mark.parametrize("given", [
    {"y": HALF, "symmetry": "y"}, {"x": HALF, "symmetry": "x"}, {"x": HALF, "y": HALF}, {"y": HALF}])
def test_the_part_reports_what_the_whole_has(whole, given):
    model, row = whole
    part, found = last(pressed(**given))
    times = 4 if "x" in given and "y" in given else 2
    assert len(part.mirrors) == np.log2(times) and not model.mirrors and not any("whole" in name for name in row)
    names = [name.replace("_whole", "") for name in found if "whole" in name]
    assert {"ball_contact_fz_N", "ball_reaction_fz_N", "ball_drive_z_J", "energy_elastic_J", "energy_drive_J"} <= set(names)
    force, energy = abs(row["ball_contact_fz_N"]), abs(row["energy_drive_J"])
    # of a ball across the plane, twice as heavy
    own = ("kinetic", "potential", "error") if "symmetry" not in given else ()
    for name in names:
        quantity, _, unit = name.rpartition("_")
        if any(word in name for word in own) or own and "reaction_fz" in name or own and "drive" in name:
            continue
        scale = {"N": force, "Nm": 0.3 * force, "J": energy}[unit]
        assert found[f"{quantity}_whole_{unit}"] == pytest.approx(row[name], abs=5e-3 * scale), name
    assert found["ball_contact_fz_whole_N"] == pytest.approx(times * found["ball_contact_fz_N"])
    assert part.sheet()["modelled"]["symmetry"]


@pytest.mark.parametrize("spin, rotation, mirrored", [
    ((0.0, 5.0, 0.0), None, True), ((0.0, 0.0, 5.0), None, False),
    ((0.0, 5.0, 0.0), (1.0, 0.0, 0.0, 90.0), False), ((0.0, 0.0, 5.0), (1.0, 0.0, 0.0, 90.0), True)])
def test_a_ball_that_spins_out_of_the_plane_is_whole(spin, rotation, mirrored):
    """The spin is given about the axes of the body; the second rotation turns its y into the z of space."""
    free = {"driven": (), "held": (), "velocity": (0.0, 0.0, 0.0), "rest_on": 0.1}
    assert bool(build(pressed(y=HALF, spin=spin, rotation=rotation, **free)).mirrors) == mirrored


def test_the_penalty_on_held_ground_is_that_of_the_whole_body():
    """By its weight: the part of it in a half model, or in a slice, weighs less and touches less ground."""
    def penalty(described):
        held = replace(described.soil, held=True, geostatic=False)
        return build(replace(described, soil=held)).model.bodies[0].penalty

    free = {"driven": (), "held": (), "velocity": (0.0, 0.0, 0.0), "rest_on": 0.0}
    whole = penalty(pressed(**free))
    for given in ({"y": HALF}, {"y": HALF, "symmetry": "y"}, {"x": HALF, "y": HALF}):
        assert penalty(pressed(**free, **given)) == pytest.approx(whole, rel=5e-3)
    drum = {"geometry": GEOMETRY / "cylinder.geo", "parameters": {"radius": 0.3, "height": 1.0, "size": 0.06},
            "rotation": (1.0, 0.0, 0.0, 90.0)}
    thin, thick = (penalty(pressed(y=Axis(-b, b, collapsed=True), **free, **drum)) for b in (0.05, 0.5))
    assert thin == pytest.approx(thick)


def test_masses_of_part_and_whole_are_reported():
    simulation = build(pressed(y=HALF, symmetry="y"))
    mass = 2000.0 * 4 / 3 * np.pi * 0.3**3
    assert 2 * simulation.masses[0].mass == pytest.approx(mass, rel=2e-3)
    assert f"the whole {2 * simulation.masses[0].mass:.6g} kg" in simulation.sheet()["modelled"]["bodies"][0]
    content = summary._whole(simulation)["symmetry"]
    assert content["planes"] == ["y = 0 m"] and content["bodies"]["ball"]["mass_whole_kg"] == pytest.approx(mass, rel=2e-3)


def test_a_body_that_is_cut_is_held_in_its_plane_and_may_not_leave_it():
    free = {"y": HALF, "symmetry": "y", "driven": (), "held": (), "velocity": (0.0, 0.0, 0.0), "rest_on": 0.0}
    simulation = build(pressed(**free))
    assert simulation.model.bodies[0].free.tolist() == [True, False, True, False, True, False]
    assert "body.0.held = [y, rx, rz]: the model is symmetric about y = 0 m" in map(str, simulation.decisions)
    assert build(pressed(**(free | {"y": WHOLE, "symmetry": None}))).model.bodies[0].free.all()
    for motion in ({"velocity": (0.0, 0.1, 0.0)}, {"driven": ("rx",)}):
        with pytest.raises(SceneError, match="ball. is cut by y = 0 m, a plane of symmetry .* but moves in"):
            build(pressed(**(free | motion)))
    freed = replace(pressed(**free), stages=(Stage("press", 1, motions=(Motion(free=("y",)),)),))
    with pytest.raises(SceneError, match="moves in y"):
        build(freed)


@pytest.mark.parametrize("change", [
    {"position": (0.0, 0.02, 0.0)},                                 # its middle beside the plane
    {"parameters": {"radius": 0.7, "size": 0.15}},                   # over all of the soil
    {"driven": ("y", "z"), "held": ("x", "rx", "ry", "rz")},        # it goes through the plane
    {"geometry": GEOMETRY / "box.geo", "rotation": (1.0, 0.0, 0.0, 10.0),                # a block that leans
     "parameters": {"length": 0.3, "width": 0.6, "height": 0.2, "size": 1.0}},
    {"geometry": GEOMETRY / "box.geo", "rotation": (1.0, 0.0, 0.0, 0.5),
     "parameters": {"length": 0.3, "width": 0.6, "height": 0.2, "size": 1.0}},
    {"geometry": GEOMETRY / "box.geo", "rotation": (1.0, 0.0, 0.0, 5.0),                 # whose moments do not lean
     "parameters": {"length": 0.3, "width": 0.4, "height": 0.4, "size": 1.0}},
])
def test_a_body_across_an_end_of_the_grid_is_no_half_otherwise(change):
    assert not build(pressed(y=HALF, **change)).mirrors


@pytest.mark.parametrize("geometry, parameters, rotation", [
    ("box.geo", {"length": 0.3, "width": 0.4, "height": 0.4, "size": 1.0}, (1.0, 0.0, 0.0, 45.0)),
    ("box.geo", {"length": 0.3, "width": 0.4, "height": 0.2, "size": 1.0}, (0.0, 1.0, 0.0, 20.0)),
    ("sphere.geo", {"radius": 0.2, "size": 0.1}, (1.0, 2.0, 3.0, 40.0)), ("sphere.geo", {"radius": 0.2, "size": 0.16}, None),
    ("cylinder.geo", {"radius": 0.2, "height": 0.3, "size": 0.1}, (1.0, 0.0, 0.0, 90.0))])
def test_a_body_across_an_end_of_the_grid_that_is_its_own_image_is_a_half(geometry, parameters, rotation):
    (mirror,), = [body.mirrors for body in build(pressed(
        y=HALF, geometry=GEOMETRY / geometry, parameters=parameters, rotation=rotation)).model.bodies]
    assert mirror.axis == "y" and not mirror.cut


FREE = {"y": HALF, "driven": (), "held": (), "velocity": (0.0, 0.0, 0.0), "rest_on": 0.0}
ABOUT_X = (1.0, 0.0, 0.0)


@pytest.mark.parametrize("densities, mirrored", [((500.0, 500.0), True), ((500.0, 3000.0), False)])
def test_halves_of_unlike_densities_are_no_symmetric_body(densities, mirrored, tmp_path):
    """Two boxes beside one another, on either side of the plane x = 0."""
    path = tmp_path / "two.geo"
    path.write_text("""SetFactory("OpenCASCADE");
Box(1) = {-0.5, -0.5, -0.5, 0.5, 1, 1};
Box(2) = {0, -0.5, -0.5, 0.5, 1, 1};
BooleanFragments{ Volume{1}; Delete; }{ Volume{2}; Delete; }
Mesh.MeshSizeMin = 0.5;
Mesh.MeshSizeMax = 0.5;
Physical Volume("left") = {1};
Physical Volume("right") = {2};
Physical Surface("contact") = Abs(CombinedBoundary{ Volume{:}; });
""")
    described = soil_scene([Body(path, dict(zip(("left", "right"), densities)), name="two", position=(0.0, 1.0, 0.5))],
                           x=(0.0, 2.0), y=(0.0, 2.0), gravity=(0.0, 0.0, -9.81), time=Time(0.01))
    assert bool(build(described).model.bodies[0].mirrors) == mirrored


@pytest.mark.parametrize("joint, mirrored", [
    ({"kind": "hinge", "point": (0.0, 1.0, 0.0), "axis": ABOUT_X}, False),      # a pendulum that swings out of the plane
    ({"kind": "hinge", "point": (0.0, 0.0, 1.0), "axis": ABOUT_X}, True),
    ({"kind": "hinge", "point": (0.0, 0.0, 1.0), "axis": (0.0, 1.0, 0.0)}, True),
    ({"kind": "hinge", "point": (0.0, 0.0, 1.0), "axis": (1.0, 1.0, 0.0)}, False),
    ({"kind": "rod", "point": (0.0, 0.0, 0.0), "end": (0.0, 1.0, 0.4)}, False),
    ({"kind": "rod", "point": (0.0, 0.0, 0.0), "end": (1.0, 0.0, 0.4)}, True),
])
def test_a_joint_beside_the_plane_makes_a_body_a_whole_one(joint, mirrored):
    simulation = build(replace(pressed(**FREE), joints=(Joint("pin", bodies=("ball",), **joint),)))
    assert bool(simulation.mirrors) == mirrored
    assert any("is joined beside it by pin" in text for text in simulation.warned) != mirrored


@pytest.mark.parametrize("beside, mirrored", [(0.0, True), (1.0, False)])
def test_a_chain_that_leaves_the_plane_is_whole(beside, mirrored):
    """Three balls one above another, joined at their middles in the plane; the last one may be beside it."""
    first = replace(pressed(**FREE).bodies[0], rest_on=None, position=(0.0, 0.0, 2.0))
    second = replace(first, name="second", position=(0.0, 0.0, 3.0))
    third = replace(first, name="third", position=(0.0, beside, 4.0))
    joints = (Joint("low", "ball", ("ball", "second"), (0.0, 0.0, 0.5)),
              Joint("high", "ball", ("second", "third"), (0.0, 0.0, 0.5)))
    simulation = build(replace(pressed(**FREE), bodies=(first, second, third), joints=joints))
    assert [bool(body.mirrors) for body in simulation.model.bodies] == [mirrored] * 3


def test_a_run_says_first_that_half_is_modelled():
    stream = io.StringIO()
    progress.Progress(stream).start(build(pressed(y=HALF)))
    assert "symmetry: y = 0 m: half of the whole is modelled\n" in stream.getvalue()
    scene = pressed(**FREE | {"y": HALF})
    stages = replace(scene.stages[0], loads=(Load(force=(0.0, 0.0, -1.0)),)),
    progress.Progress(stream).start(build(replace(scene, stages=stages)))
    assert "is modelled; loads of stages act on this part, 2 times as much on the whole" in stream.getvalue()


@pytest.mark.parametrize("scene", [
    replace(pressed(y=HALF), gravity=(0.0, -1.0, -9.0), soil=replace(pressed().soil, geostatic=False)),
    replace(pressed(y=HALF), grid=replace(pressed(y=HALF).grid, faces=Faces(z_min="fixed", y_min="free"))),
    replace(pressed(y=HALF), soil=replace(pressed().soil, lower=(-SIDE, SIZE, -0.6), geostatic=False)),
])
def test_no_plane_of_symmetry_without_a_roller_soil_and_gravity_in_it(scene):
    assert not build(scene).mirrors


@pytest.mark.parametrize("planes, share", [({"x": HALF, "y": HALF}, 4), ({"y": HALF}, 2), ({"y": HALF, "symmetry": "y"}, 2)])
def test_a_body_counts_with_the_share_of_its_mass_in_the_part(planes, share):
    """Whether it lies across the planes or is cut there."""
    free = {"driven": (), "held": (), "velocity": (0.0, 0.0, 0.0), "rest_on": 0.0}
    part, whole = (build(pressed(**free, **given)).model.bodies[0].mass for given in (planes, {}))
    assert share * part.mass == pytest.approx(whole.mass, rel=1e-4)
    assert share * part.inertia[1, 1] == pytest.approx(whole.inertia[1, 1], rel=1e-4)
    np.testing.assert_allclose(share * part.gravity_load[2], whole.gravity_load[2], rtol=1e-4)


def test_cut_faces_in_no_plane_are_noted():
    def notes(**given):
        return " ".join(build(pressed(**given)).warned)

    assert "its cut face lies in no plane of symmetry" in notes(symmetry="y")
    assert "its cut face lies in no plane" in notes(y=HALF, symmetry="y", rotation=(1.0, 0.0, 0.0, 10.0))
    for given in ({"y": HALF, "symmetry": "y"}, {"y": HALF}, {}):
        assert "symmetr" not in notes(**given)


def test_forces_along_a_normal_and_moments_across_it_cancel():
    columns = dict.fromkeys([f"{kind}_{c}{a}_{unit}" for kind in ("contact", "reaction") for c, unit in
                             (("f", "N"), ("m", "Nm")) for a in "xyz"] + ["tension_N", "drive_z_J", "x_m", "qx"], 1.0)
    half, quarter = (whole_columns(columns, tuple(Mirror(a, 0.0, True) for a in axes)) for axes in ("y", "xy"))
    assert {name: half[f"contact_{name}"] for name in ("fx_whole_N", "fy_whole_N", "my_whole_Nm", "mx_whole_Nm")} == {
        "fx_whole_N": 2, "fy_whole_N": 0, "my_whole_Nm": 2, "mx_whole_Nm": 0}
    assert [quarter[f"reaction_{name}"]
            for name in ("fz_whole_N", "fx_whole_N", "mz_whole_Nm", "my_whole_Nm")] == [4, 0, 0, 0]
    assert half["tension_whole_N"] == 2 and quarter["drive_z_whole_J"] == 4 and "x_whole_m" not in half
    assert list(half).index("tension_whole_N") == list(half).index("tension_N") + 1
    assert whole_columns(columns, ()) == columns


def test_history_figure_and_progress_speak_of_the_whole(tmp_path):
    class Half(FakeSimulation):
        def record(self):
            record = super().record()
            record.bodies[0].mirrors, record.copies = (Mirror("y", 0.0, True),), 2
            return record

    simulation = Half()
    simulation.run([history.History(tmp_path)])
    columns = history.read_history(tmp_path)
    assert history.body_names(columns) == ["anchor"]
    assert np.array_equal(columns["anchor_tension_whole_N"], 2 * columns["anchor_tension_N"])
    assert np.array_equal(columns["energy_kinetic_whole_J"], 2 * columns["energy_kinetic_J"])
    assert "tension 12 kN of the whole" in progress.describe(simulation.record(), 4, 1)
    from hybrid.output import figures

    drawn = {}
    original, figures.figure = figures.figure, _Spy(figures.figure, drawn)
    try:
        figures.tension(tmp_path)
    finally:
        figures.figure = original
    assert drawn["label"] == "line tension, whole body [kN]" and drawn["highest"] == pytest.approx(12.0)


class _Spy:
    """`figures.figure` that notes label and highest value of its only axes."""

    def __init__(self, figure, drawn):
        self.figure, self.drawn = figure, drawn

    def __call__(self, *given):
        self.context = self.figure(*given)
        return self

    def __enter__(self):
        self.drawing = self.context.__enter__()
        return self.drawing

    def __exit__(self, *error):
        (axes,) = self.drawing.axes
        self.drawn["label"] = axes.get_ylabel()
        self.drawn["highest"] = max(line.get_ydata().max() for line in axes.lines[:1])
        return self.context.__exit__(*error)
