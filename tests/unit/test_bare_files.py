"""Solids of CAD, triangles and meshes are bodies as they are: groups are made, units scaled, halves cut, holes reported."""

import re
from contextlib import contextmanager
from pathlib import Path

import gmsh
import numpy as np
import pytest

from hybrid import cli
from hybrid.body import half
from hybrid.body.mesh import generate
from hybrid.body.smooth_mass import mass_and_surface
from hybrid.body.solid import signed_volumes, smoothed, validate
from hybrid.runtime.errors import GeometryError

GEOMETRY = Path(__file__).parents[2] / "geometry"
LENGTH, WIDTH, HEIGHT = 2.0, 1.0, 0.5
FILES = ".step", ".brep", ".stl", ".msh"


@contextmanager
def drawing(path, *, mesh=0, size=0.25):
    """gmsh with an empty model, which is written to `path` at the end, meshed in `mesh` dimensions."""
    gmsh.initialize([], False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setString("Geometry.OCCTargetUnit", "M")
        gmsh.option.setNumber("Mesh.MeshSizeMax", size)
        yield gmsh.model
        gmsh.model.occ.synchronize()
        if mesh:
            gmsh.model.mesh.generate(mesh)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    """Folder of boxes of 2 x 1 x 0.5 m about x = y = 0 and of spheres of r = 0.5 m about the origin, of all kinds."""
    folder = tmp_path_factory.mktemp("drawn")
    for suffix in FILES:
        mesh = {".stl": 2, ".msh": 3}.get(suffix, 0)
        with drawing(folder / f"box{suffix}", mesh=mesh) as model:
            model.occ.addBox(-LENGTH / 2, -WIDTH / 2, 0.0, LENGTH, WIDTH, HEIGHT)
        with drawing(folder / f"sphere{suffix}", mesh=mesh, size=0.08) as model:
            model.occ.addSphere(0, 0, 0, 0.5)
    return folder


@pytest.fixture(scope="module")
def two(tmp_path_factory):
    """Folder of two cubes side by side, shank and fluke, as a mesh with physical volumes and as solids with labels."""
    folder = tmp_path_factory.mktemp("two")
    for name in ("two.msh", "raw.step"):
        with drawing(folder / name, mesh=3 * name.endswith("msh"), size=0.5) as model:
            one, other = model.occ.addBox(0, -0.5, 0, 1, 1, 1), model.occ.addBox(1, -0.5, 0, 1, 1, 1)
            if name == "two.msh":
                model.occ.fragment([(3, one)], [(3, other)])
                model.occ.synchronize()
                for tag, group in ((one, "shank"), (other, "fluke")):
                    model.setPhysicalName(3, model.addPhysicalGroup(3, [tag]), group)
    text = (folder / "raw.step").read_text()
    labels = list(dict.fromkeys(re.findall(r"'(Open CASCADE STEP translator [^']+)'", text.replace("\n  ", ""))))
    for label, name in zip(sorted(labels, key=len)[-2:], ("shank", "fluke")):
        text = text.replace(label, name)
    (folder / "two.step").write_text(text)
    return folder


def box_inertia(mass, length, width, height):
    return mass / 12 * np.diag([width**2 + height**2, length**2 + height**2, length**2 + width**2])


# ---- whole bodies and halves -------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", FILES)
def test_a_box_of_any_file_has_its_mass(drawn, suffix):
    body, _ = mass_and_surface(generate(drawn / f"box{suffix}"), 1000.0)
    assert body.mass == pytest.approx(1000.0) and body.centre == pytest.approx([0, 0, 0.25], abs=1e-9)
    assert body.inertia == pytest.approx(box_inertia(1000.0, LENGTH, WIDTH, HEIGHT), abs=1e-6)


@pytest.mark.parametrize("suffix", FILES)
@pytest.mark.parametrize("axis", ["x", "y"])
def test_half_of_a_box_is_exact_and_its_cap_lies_in_the_plane(drawn, suffix, axis):
    mesh, a = generate(drawn / f"box{suffix}", symmetry=axis), "xy".index(axis)
    body, _ = mass_and_surface(mesh, 1000.0)
    sides = np.array([LENGTH, WIDTH, HEIGHT])
    sides[a] /= 2
    centre = np.array([0, 0, 0.25])
    centre[a] = sides[a] / 2
    assert body.mass == pytest.approx(500.0) and body.centre == pytest.approx(centre, abs=1e-9)
    assert body.inertia == pytest.approx(box_inertia(500.0, *sides), abs=1e-6)
    assert np.all(np.abs(mesh.points[np.unique(mesh.symmetry), a]) < 1e-9) and mesh.points[:, a].min() > -1e-9
    cap = mesh.points[mesh.symmetry]
    area = 0.5 * np.linalg.norm(np.cross(cap[:, 1] - cap[:, 0], cap[:, 2] - cap[:, 0]), axis=1).sum()
    assert area == pytest.approx(np.delete(sides, a).prod())


@pytest.mark.parametrize("suffix, error", [(".step", 1e-5), (".brep", 1e-5), (".stl", 3e-4), (".msh", 3e-4)])
def test_half_of_a_sphere_is_half_of_it_and_round(drawn, suffix, error):
    """The facets of r = 0.5 m and 0.08 m alone would be 0.9 % light."""
    mesh = generate(drawn / f"sphere{suffix}", symmetry="y")
    body, surface = mass_and_surface(mesh, 1000.0)
    mass = 1000.0 * 2 / 3 * np.pi * 0.5**3
    assert body.mass == pytest.approx(mass, rel=error)
    assert body.centre == pytest.approx([0, 3 / 8 * 0.5, 0], abs=5 * error)
    inertia = mass * 0.25 * np.array([2 / 5 - 9 / 64, 2 / 5, 2 / 5 - 9 / 64])
    assert np.diag(body.inertia) == pytest.approx(inertia, rel=3 * error)
    assert surface.curved.any()
    normals = mesh.normals.reshape(-1, 3)
    places = mesh.points[mesh.contact].reshape(-1, 3) / 0.5
    assert np.abs(np.einsum("ni,ni->n", normals, places)).min() > 0.98, "normals of a sphere, on the rim too"


def test_halves_of_random_meshes_fill_what_they_are_cut_from(monkeypatch):
    """Whatever lies across the plane: the half is closed, and the two halves are the whole."""
    monkeypatch.setattr(half, "check_halves", lambda *given: None)
    for shift in (0.0, 0.013, -0.2):
        mesh = generate(GEOMETRY / "box.geo", {"width": 0.7}, size=0.2)
        turned = mesh.points @ np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
        sides = []
        for sign in (1.0, -1.0):
            points = turned * [1.0, sign, 1.0] + [0.0, sign * shift, 0.0]
            tets = mesh.tets if sign > 0 else mesh.tets[:, [0, 2, 1, 3]]
            contact = mesh.contact if sign > 0 else mesh.contact[:, ::-1]
            if np.linalg.det(np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]) < 0:
                tets, contact = tets[:, [0, 2, 1, 3]], contact[:, ::-1]
            whole = mesh.__class__(points, tets, contact)
            kept = half.half_of(smoothed(whole), "y")
            validate(kept)
            sides.append(signed_volumes(kept.points, kept.tets).sum())
        assert sum(sides) == pytest.approx(signed_volumes(mesh.points, mesh.tets).sum())


def test_the_half_of_a_shipped_geometry_needs_no_group_for_its_cap():
    mesh = generate(GEOMETRY / "sphere.geo", symmetry="x")
    assert len(mesh.symmetry) and mesh.points[:, 0].min() == 0.0
    with pytest.raises(GeometryError, match="is cut already: leave symmetry = 'y' out"):
        generate(GEOMETRY / "stockless_anchor.geo", symmetry="y")


@pytest.mark.parametrize("suffix", [".step", ".stl"])
def test_halves_that_are_none_are_refused(tmp_path, suffix):
    for name, start, reason in (("off", -0.3, "is not symmetric about y = 0: 0.7 m³ lie at y > 0 and 0.3 m³"),
                                ("below", -1.5, "nothing of it lies at y > 0"),
                                ("above", 0.5, "no face of it lies in the plane y = 0")):
        with drawing(tmp_path / f"{name}{suffix}", mesh=2 * (suffix == ".stl")) as model:
            model.occ.addBox(0, start, 0, 1, 1, 1)
        with pytest.raises(GeometryError, match=reason):
            generate(tmp_path / f"{name}{suffix}", symmetry="y")
    with drawing(tmp_path / f"half{suffix}", mesh=2 * (suffix == ".stl")) as model:
        model.occ.addBox(0, 0, 0, 1, 1, 1)
    assert len(generate(tmp_path / f"half{suffix}", symmetry="y").symmetry), "a half that is drawn stays as it is"
    with pytest.raises(GeometryError, match="symmetry = 'z' must be one of 'x', 'y'"):
        generate(tmp_path / f"half{suffix}", symmetry="z")


@pytest.mark.parametrize("suffix", [".msh", ".stl"])
def test_halves_of_a_coarse_mesh_of_a_round_body_are_alike(suffix, tmp_path):
    with drawing(tmp_path / f"cone{suffix}", mesh=2 if suffix == ".stl" else 3, size=0.3) as model:
        model.occ.addCone(0, 0, 0, 0, 0, 1, 0.5, 0)
    for axis in "xy":
        assert len(generate(tmp_path / f"cone{suffix}", symmetry=axis).symmetry)


@pytest.mark.parametrize("suffix", [".step", ".stl"])
@pytest.mark.parametrize("axes, angle, what", [((0, 0, 1), 5.0, "∫ x y dV"), ((1, 0, 0), -30.0, "∫ z dV")])
def test_halves_of_the_same_volume_that_are_no_mirror_images_are_refused(axes, angle, what, suffix, tmp_path):
    """A bar through the origin, turned: half of it would be dragged without the force across."""
    for turned in (angle, 0.0):
        with drawing(tmp_path / f"bar{turned:g}{suffix}", mesh=2 * (suffix == ".stl")) as model:
            bar = model.occ.addBox(-1.0, -0.2, -0.15, 2.0, 0.4, 0.3)
            model.occ.rotate([(3, bar)], 0, 0, 0, *axes, np.radians(turned))
    with pytest.raises(GeometryError, match="both halves have the same volume, but " + what):
        generate(tmp_path / f"bar{angle:g}{suffix}", symmetry="y")
    assert len(generate(tmp_path / f"bar0{suffix}", symmetry="y").symmetry)


# ---- units -------------------------------------------------------------------------------------------------


def test_scale_makes_metres_of_a_file_and_of_its_named_points(drawn, two):
    assert np.ptp(generate(drawn / "box.stl", scale=0.001).points, axis=0) == pytest.approx([2e-3, 1e-3, 5e-4])
    assert np.ptp(generate(drawn / "box.step", size=0.2, scale=0.5).points, axis=0) == pytest.approx([1.0, 0.5, 0.25])
    shackle = generate(GEOMETRY / "stockless_anchor.geo", scale=0.1).named_points["shackle"]
    assert shackle == pytest.approx([0.33, 0, 0])
    for scale in (0.0, -1.0, float("nan")):
        with pytest.raises(GeometryError, match="scale.*must be"):
            generate(drawn / "box.stl", scale=scale)


def test_size_is_the_one_parameter_of_a_solid(drawn):
    assert len(generate(drawn / "box.step", size=0.15).tets) > 3 * len(generate(drawn / "box.step", size=0.5).tets)
    with pytest.raises(GeometryError, match=r"no parameter 'siz'; did you mean 'size'\?"):
        generate(drawn / "box.step", {"siz": 0.1})
    with pytest.raises(GeometryError, match="no parameter 'radius': .stl files declare none"):
        generate(drawn / "box.stl", {"radius": 1.0})


# ---- densities ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["two.msh", "two.step"])
@pytest.mark.parametrize("symmetry", [None, "y"])
def test_two_densities_have_the_inertia_of_the_composite(two, name, symmetry):
    densities, width = {"shank": 1000.0, "fluke": 3000.0}, 0.5 if symmetry else 1.0
    body, _ = mass_and_surface(generate(two / name, symmetry=symmetry, volumes=tuple(densities)), densities)
    masses, mass = np.array([1000.0, 3000.0]) * width, 4000.0 * width
    assert body.mass == pytest.approx(mass)
    assert body.centre == pytest.approx([1.25, 0.25 if symmetry else 0.0, 0.5], abs=1e-9)
    apart = masses @ np.array([0.75, 0.25]) ** 2
    assert body.inertia == pytest.approx(box_inertia(mass, 1, width, 1) + np.diag([0, apart, apart]), abs=1e-6)
    assert np.trace(body.gravity_load) == pytest.approx(3 * mass)


def test_round_parts_of_two_densities_are_as_heavy_as_the_smooth_ones(tmp_path):
    """A ball whose upper half is lead: layers between facets and sphere have the density below them."""
    path = tmp_path / "ball.geo"
    path.write_text("""SetFactory("OpenCASCADE");
Mesh.MeshSizeMax = 0.12; Mesh.MeshSizeMin = 0.12;
Sphere(1) = {0, 0, 0, 0.5}; Box(2) = {-1, -1, 0, 2, 2, 1};
up() = BooleanIntersection{ Volume{1}; }{ Volume{2}; };
low() = BooleanDifference{ Volume{1}; Delete; }{ Volume{2}; Delete; };
all() = BooleanFragments{ Volume{up(0)}; Delete; }{ Volume{low(0)}; Delete; };
u() = Volume In BoundingBox{-1, -1, -1e-3, 1, 1, 1}; l() = Volume In BoundingBox{-1, -1, -1, 1, 1, 1e-3};
Physical Volume("upper") = {u()}; Physical Volume("lower") = {l()};
Physical Surface("contact") = Abs(CombinedBoundary{ Volume{u(), l()}; });
""")
    densities = {"lower": 1000.0, "upper": 11000.0}
    body, _ = mass_and_surface(generate(path, volumes=tuple(densities)), densities)
    half = 2 / 3 * np.pi * 0.5**3
    assert body.mass == pytest.approx(12000 * half, rel=1e-4)
    assert body.centre[2] == pytest.approx(10000 * half * 3 / 16 / (12000 * half), rel=1e-3)
    body, _ = mass_and_surface(generate(path), 1000.0)      # one density is that of all volumes, whatever their names
    assert body.mass == pytest.approx(2000 * half, rel=1e-4)


def test_names_of_volumes_are_checked(two, drawn):
    for volumes, reason in ((("shank", "fluk"), r"no physical volume 'fluk', which .* did you mean 'fluke'\?"),
                            (("shank",), "volumes .* are not in the physical volumes shank of body.density")):
        with pytest.raises(GeometryError, match=reason):
            generate(two / "two.msh", volumes=volumes)
    with pytest.raises(GeometryError, match="no physical volume 'shank', which density names"):
        generate(drawn / "box.stl", volumes=("shank",))
    mesh = generate(two / "two.msh")
    with pytest.raises(GeometryError, match="density names the volumes shank, but it has fluke, shank"):
        mass_and_surface(mesh, {"shank": 1.0})
    assert mass_and_surface(mesh, 1000.0)[0].mass == pytest.approx(2000.0), "one number is for all volumes"


def test_solids_that_overlap_are_refused_where_they_do(tmp_path):
    with drawing(tmp_path / "two.step") as model:
        model.occ.addBox(0, 0, 0, 1, 1, 1)
        model.occ.addBox(0.9, 0, 0, 1, 1, 1)
    with pytest.raises(GeometryError, match=r"solids '1' and '2' overlap, about \(0.95, 0.5, 0.5\) m"):
        generate(tmp_path / "two.step")


# ---- leaks -------------------------------------------------------------------------------------------------


def test_triangles_that_leak_are_told_where(drawn, tmp_path):
    facets = re.findall(r"facet.*?endfacet\n", (drawn / "sphere.stl").read_text(), re.S)
    path = tmp_path / "ball.stl"

    def refused(kept, scale=1.0):
        path.write_text("solid ball\n" + "".join(kept) + "endsolid ball\n")
        with pytest.raises(GeometryError) as found:
            generate(path, scale=scale)
        return str(found.value)

    place = np.mean([list(map(float, v.split())) for v in re.findall(r"vertex (.*)", facets[50])], axis=0)
    for scale in (1.0, 0.001):
        message = refused(facets[:50] + facets[51:], scale)
        assert "is not closed: 3 edges of triangles have a face on one side only" in message
        found = np.array(re.search(r"\((.*)\) m", message).group(1).split(","), float)
        assert found == pytest.approx(scale * place, rel=2e-3, abs=1e-4 * scale)
    assert "join more than two triangles" in refused(facets + facets[:1])
    path.write_text("solid nothing\nendsolid nothing\n")
    with pytest.raises(GeometryError):
        generate(path)


def test_faces_that_are_no_solid_are_sewn_or_told_where_they_leak(tmp_path):
    for name, open_face in (("shell", False), ("open", True)):
        with drawing(tmp_path / f"{name}.step") as model:
            box = model.occ.addBox(0, 0, 0, 1, 1, 1)
            model.occ.remove([(3, box)])
            if open_face:
                model.occ.remove([(2, 3)])      # y = 0
    assert mass_and_surface(generate(tmp_path / "shell.step"), 1000.0)[0].mass == pytest.approx(1000.0)
    with pytest.raises(GeometryError, match=r"is not closed: 4 edges of faces .* about .*\(0.5, 0, 0\) m"):
        generate(tmp_path / "open.step")


# ---- command line ------------------------------------------------------------------------------------------


def test_mesh_prints_volumes_and_takes_densities(two, capsys):
    assert cli.main(["mesh", str(two / "two.step"), "--symmetry", "y", "--density", "shank=1000,fluke=3000"]) == 0
    printed = capsys.readouterr().out
    assert "shank: 0.5" in printed and "fluke: 3000" in printed and "half of a body" in printed
    assert re.search(r"mass \[kg\] +2000\n", printed)
    for density in ("shank=1,2", "shank=x", "-1", "", "shank=1,shank=2"):
        assert cli.main(["mesh", str(two / "two.step"), f"--density={density}"]) == 2
        assert "must be a positive number of kg/m³" in capsys.readouterr().err
