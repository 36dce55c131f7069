"""Geometry files become closed, outward-oriented solids, or are refused with the reason."""

from dataclasses import replace
from pathlib import Path

import gmsh
import numpy as np
import pytest

from hybrid.body import mesh as meshing
from hybrid.body import mesh_worker
from hybrid.body.mesh import generate
from hybrid.body.solid import TetMesh, boundary_faces, oriented, signed_volumes, validate
from hybrid.runtime.errors import GeometryError

GEOMETRY = Path(__file__).parents[2] / "geometry"
SHIPPED = ["sphere", "box", "cylinder", "cone", "notched_block", "stockless_anchor", "ac14_fluke",
           "ac14_shank"]
HEAD = """SetFactory("OpenCASCADE");
DefineConstant[ length = {1.0, Name "Parameters/length"} size = {0.6, Name "Parameters/size"} ];
Mesh.MeshSizeMin = size;
Mesh.MeshSizeMax = size;
Box(1) = {0, 0, 0, length, 1, 1};
"""
BODY = 'Physical Volume("body") = {1};\n'
CONTACT = 'Physical Surface("contact") = Abs(Boundary{ Volume{1}; });\n'


@pytest.fixture
def geo(tmp_path):
    """Write a .geo file of the given text and return its path."""

    def write(text):
        path = tmp_path / "body.geo"
        path.write_text(text + "\n")  # gmsh may lose statements on a last line without one
        return path

    return write


def cube():
    """Unit cube of six tetrahedra around a diagonal, all its surface in contact."""
    points = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
    tets = []
    for path in ([4, 2, 1], [4, 1, 2], [2, 4, 1], [2, 1, 4], [1, 4, 2], [1, 2, 4]):
        tet = [0, path[0], path[0] + path[1], 7]
        positive = np.linalg.det(points[tet[1:]] - points[0]) > 0.0
        tets.append(tet if positive else [tet[0], tet[2], tet[1], tet[3]])
    tets = np.array(tets)
    return TetMesh(points, tets, boundary_faces(tets), name="cube")


def enclosed(points, triangles):
    """Volume [m³] inside outward triangles."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.einsum("ij,ij->", np.cross(a, b), c) / 6.0


# ---- what is accepted --------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_geometry_is_a_closed_outward_solid(name):
    mesh = generate(GEOMETRY / f"{name}.geo")
    surface = np.vstack([mesh.contact, mesh.symmetry])
    volume = signed_volumes(mesh.points, mesh.tets).sum()
    assert volume > 0.0
    assert enclosed(mesh.points, surface) == pytest.approx(volume, rel=1e-12)
    assert mesh.name == name
    assert np.array_equal(np.unique(mesh.tets), np.arange(len(mesh.points)))


def test_anchor_has_its_published_dimensions_and_names():
    mesh = generate(GEOMETRY / "stockless_anchor.geo")
    shackle, tip = mesh.named_points["shackle"], mesh.named_points["tip"]
    on_surface = mesh.points[np.unique(mesh.contact)]
    for point in (shackle, tip):
        assert np.linalg.norm(on_surface - point, axis=1).min() < 1e-9
    assert shackle == pytest.approx([3.3, 0.0, 0.0], abs=1e-9)
    along, thick = np.array([1.0, 0.0, -np.tan(np.radians(35.0))]), 0.08
    assert np.dot(tip, along / np.linalg.norm(along)) == pytest.approx(1.7, abs=1e-9)
    assert tip[2] == pytest.approx(on_surface[:, 2].min(), abs=1e-9), "the tip is the lowest point"
    assert tip[2] == pytest.approx(-1.7 * np.sin(np.radians(35.0)) - thick / 2 * np.cos(np.radians(35.0)))
    assert np.all(np.abs(mesh.points[np.unique(mesh.symmetry), 1]) < 1e-9)
    assert mesh.points[:, 1].min() > -1e-9
    assert 1000 < len(mesh.contact) < 3000


@pytest.mark.parametrize("angle, size", [(20.0, 0.2), (45.0, 0.3)])
def test_anchor_follows_its_parameters(angle, size):
    mesh = generate(GEOMETRY / "stockless_anchor.geo", {"opening_angle": angle, "tip_thickness": 0.1}, size)
    s, c = np.sin(np.radians(angle)), np.cos(np.radians(angle))
    assert mesh.named_points["tip"][[0, 2]] == pytest.approx([1.7 * c - 0.05 * s, -1.7 * s - 0.05 * c])


def test_parameters_and_size_are_applied_and_forgotten():
    default = generate(GEOMETRY / "box.geo")
    mesh = generate(GEOMETRY / "box.geo", {"length": 3.0}, size=1.0)
    assert np.ptp(mesh.points, axis=0) == pytest.approx([3.0, 1.0, 1.0])
    again = generate(GEOMETRY / "box.geo")
    assert np.array_equal(again.points, default.points) and np.array_equal(again.tets, default.tets)
    assert len(generate(GEOMETRY / "box.geo", size=0.25).tets) > 3 * len(default.tets)


def test_a_refused_file_does_not_disturb_the_next(geo):
    before = generate(GEOMETRY / "sphere.geo")
    for _ in range(2):
        with pytest.raises(GeometryError):
            generate(geo("Box(1) = {0, 0"))
    after = generate(GEOMETRY / "sphere.geo")
    assert np.array_equal(before.points, after.points)


def test_nothing_is_printed(capfd, geo):
    generate(GEOMETRY / "box.geo")
    with pytest.raises(GeometryError):
        generate(geo("Box(1) = {0, 0"))
    assert capfd.readouterr() == ("", "")


def test_a_mesh_that_is_asked_for_again_is_not_made_again_and_stays_as_it_was(geo, monkeypatch):
    path = geo(HEAD + BODY + CONTACT)
    first = generate(path, {"length": 2.0})
    first.points[:] = 0.0
    runs = []
    run = meshing._run
    monkeypatch.setattr(meshing, "_run", lambda *given: runs.append(given) or run(*given))
    assert np.ptp(generate(path, {"length": 2}).points[:, 0]) == pytest.approx(2.0) and not runs
    geo(HEAD + 'Physical Volume("body") = {1};' + CONTACT + "// changed")
    generate(path, {"length": 2.0})
    assert len(runs) == 1, "the file has changed; it is evaluated once, parameters or not"


# ---- what is refused ---------------------------------------------------------------------------------------


def test_missing_file_is_refused(tmp_path):
    with pytest.raises(GeometryError, match="nothing.geo cannot be read: there is no such file"):
        generate(tmp_path / "nothing.geo")


@pytest.mark.parametrize(
    "text, reason",
    [
        ("Box(1) = {0, 0", "syntax error"),
        (HEAD + "Box(2) = {0, 0, 0, -1, 1", "syntax error"),
        (HEAD + "Mesh.MeshSizeMin = nothing;", "gmsh reports"),
        ('SetFactory("OpenCASCADE");\nSphere(1) = {0, 0, 0, 1};\nDilate {{0, 0, 0}, {0.02, 0.02, 1}} { Volume{1}; }\n'
         "Mesh.MeshSizeMin = 2;" + BODY + CONTACT, "No elements in volume 1; elements are too large for the shape: give"),
        (HEAD + CONTACT, r"no physical volume 'body' \(found: none\)"),
        (HEAD + BODY, r"no physical surface 'contact' \(found: none\)"),
        (HEAD + BODY + 'Physical Surface("contact") = {1, 2, 3, 4, 5};', "not watertight.*in neither"),
        (HEAD + BODY + CONTACT + 'Physical Surface("symmetry") = {1};', "not watertight.*listed twice"),
        (
            HEAD + BODY + "Rectangle(9) = {5, 5, 5, 1, 1};" + 'Physical Surface("contact") = {1:6, 9};',
            "0 are in neither .* [1-9][0-9]* triangles of these groups are not on the boundary",
        ),
        (
            HEAD + BODY + 'Physical Surface("contact") = {2, 3, 4, 6};\n'
            'Physical Surface("symmetry") = {1, 5};',
            "'symmetry'.*one plane.*For a quarter model draw the whole body .* corner of the grid",
        ),
        (HEAD + "Box(2) = {3, 0, 0, 1, 1, 1};" + BODY + CONTACT, r"volumes \[2\] are not in"),
        (
            HEAD + 'Box(2) = {0.5, 0, 0, 1, 1, 1}; Physical Volume("body") = {1, 2};'
            'Physical Surface("contact") = {1:12};',
            "in 2 pieces",
        ),
        (HEAD + BODY + CONTACT + 'Physical Point("end") = {1, 2};', "point 'end' has 2 points"),
        (HEAD + BODY + CONTACT + "Mesh.ElementOrder = 2;", "only linear triangles and tetrahedra"),
        (HEAD + "Rectangle(9) = {0, 0, 5, 1, 1};" + 'Physical Surface("contact") = {9};', "volume 'body'"),
    ],
)
def test_broken_geometry_is_refused_with_the_reason(geo, text, reason):
    with pytest.raises(GeometryError, match=reason):
        generate(geo(text))


def test_geometry_without_volume_elements_is_refused(monkeypatch):
    monkeypatch.setattr(mesh_worker, "elements", lambda *_: np.zeros((0, 4), dtype=int))
    path = GEOMETRY / "box.geo"
    try:
        with mesh_worker.session(path, {"path": path, "parameters": {}, "memory": 0}):
            with pytest.raises(GeometryError, match="no volume elements"):
                mesh_worker.mesh({"path": path, "parameters": {}, "tetrahedra": 1000, "remedy": "", "volumes": ()})
    finally:
        gmsh.finalize()


@pytest.mark.parametrize(
    "parameters, reason",
    [
        ({"lenght": 2.0}, "no parameter 'lenght'; did you mean 'length'"),
        ({'a"b': 2.0}, "no parameter 'a\"b'; did you mean"),
        ({"length": float("nan")}, "'length' = nan must be a finite number"),
        ({"length": "2"}, "'length' = '2' must be a finite number"),
        ({"length": True}, "must be a finite number"),
        ({"size": 0.0}, "size = 0.0 m must be positive"),
        ({"length": 0.0}, "gmsh reports"),
    ],
)
def test_bad_parameters_are_refused(geo, parameters, reason):
    with pytest.raises(GeometryError, match=reason):
        generate(geo(HEAD + BODY + CONTACT), parameters)


def test_a_parameter_of_a_file_without_any_is_refused_with_the_name_it_must_have(geo):
    """Constants under other names are no parameters; under the name of the message they are."""
    text = HEAD.replace("Parameters/", "Box/") + BODY + CONTACT
    with pytest.raises(GeometryError, match=r"no parameter 'length' \(declared: none\).*\"Parameters/length\""):
        generate(geo(text), {"length": 2.0})
    text = text.replace('Name "Box/length"', 'Name "Parameters/length"')
    assert np.ptp(generate(geo(text), {"length": 2.0}).points[:, 0]) == pytest.approx(2.0)


# ---- validation on arrays ----------------------------------------------------------------------------------


def test_a_sound_mesh_passes():
    validate(cube())


def test_flipped_tetrahedron_is_refused():
    mesh = cube()
    tets = mesh.tets.copy()
    tets[2, [1, 2]] = tets[2, [2, 1]]
    with pytest.raises(GeometryError, match="1 of 6 tetrahedra.*number 2, has a negative one"):
        validate(replace(mesh, tets=tets))


def test_flat_tetrahedron_is_refused():
    mesh = cube()
    points = mesh.points.copy()
    points[7] = [1.0, 1.0, 0.0]
    with pytest.raises(GeometryError, match="negative or zero volume"):
        validate(replace(mesh, points=points))


def test_coordinates_that_are_not_finite_are_refused():
    mesh = cube()
    points = mesh.points.copy()
    points[3, 1] = np.nan
    with pytest.raises(GeometryError, match="point 3 has coordinates.*not finite"):
        validate(replace(mesh, points=points))
    with pytest.raises(GeometryError, match="point 'end'"):
        validate(replace(mesh, named_points={"end": np.full(3, np.inf)}))


def test_missing_doubled_and_inward_triangles_are_refused():
    mesh = cube()
    with pytest.raises(GeometryError, match="not watertight: of 12 faces .* 1 are in neither"):
        validate(replace(mesh, contact=mesh.contact[1:]))
    with pytest.raises(GeometryError, match="1 are listed twice"):
        validate(replace(mesh, contact=np.vstack([mesh.contact, mesh.contact[:1]])))
    inward = mesh.contact.copy()
    inward[4] = inward[4, ::-1]
    with pytest.raises(GeometryError, match="1 surface triangles face inward"):
        validate(replace(mesh, contact=inward))
    validate(oriented(replace(mesh, contact=inward)))


def test_inner_faces_are_not_contact():
    mesh = cube()
    inner = np.array([[0, 4, 7]])
    with pytest.raises(GeometryError, match="1 triangles of these groups are not on the boundary"):
        validate(replace(mesh, contact=np.vstack([mesh.contact, inner])))


def test_parts_joined_by_an_edge_only_are_refused():
    points = np.array([[0, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], dtype=float)
    tets = np.array([[0, 2, 3, 1], [0, 4, 5, 1]])
    mesh = TetMesh(points, tets, boundary_faces(tets))
    with pytest.raises(GeometryError, match="1 edges .* joins 4 at \\(0, 0, 0.5\\)"):
        validate(mesh)


def test_separate_pieces_and_overlapping_tetrahedra_are_refused():
    mesh = cube()
    apart = TetMesh(
        np.vstack([mesh.points, mesh.points + 5.0]),
        np.vstack([mesh.tets, mesh.tets + 8]),
        np.vstack([mesh.contact, mesh.contact + 8]),
    )
    with pytest.raises(GeometryError, match="in 2 pieces"):
        validate(apart)
    thrice = replace(mesh, tets=np.vstack([mesh.tets, mesh.tets, mesh.tets]))
    with pytest.raises(GeometryError, match="tetrahedra share the face"):
        validate(thrice)


# ---- normals of the surface --------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", [".stl", ".msh"])
def test_a_mesh_without_geometry_has_the_normals_of_its_facets(tmp_path, suffix):
    """A cylinder of facets that bend by 15 degrees is round; its ends are plane and its rim is sharp."""
    gmsh.initialize([], False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, 1, 0.5)
    gmsh.model.occ.synchronize()
    gmsh.option.setNumber("Mesh.MeshSizeMax", 2 * np.pi * 0.5 / 24)
    for dim, name in ((3, "body"), (2, "contact")):
        group = gmsh.model.addPhysicalGroup(dim, [tag for _, tag in gmsh.model.getEntities(dim)])
        gmsh.model.setPhysicalName(dim, group, name)
    gmsh.model.mesh.generate(3)
    gmsh.write(str(tmp_path / f"body{suffix}"))
    gmsh.finalize()
    path = tmp_path / f"body{suffix}"
    if suffix == ".stl":
        path = tmp_path / "body.geo"
        path.write_text('Merge "body.stl"; Surface Loop(1) = {1}; Volume(1) = {1}; Mesh.MeshSizeMax = 0.3;\n'
                        'Physical Volume("body") = {1}; Physical Surface("contact") = {1};\n')
    mesh = generate(path)
    corners = mesh.points[mesh.contact]
    ends = np.ptp(corners[:, :, 2], axis=1) < 1e-6
    outward = np.sign(corners[ends][:, :, 2:] - 0.5) * [0.0, 0.0, 1.0]
    np.testing.assert_allclose(mesh.normals[ends], outward, atol=1e-6)
    radial = corners[~ends] * [2.0, 2.0, 0.0]
    assert np.einsum("tki,tki->tk", mesh.normals[~ends], radial).min() > np.cos(np.radians(4.0))
    assert 50 < ends.sum() < len(ends) - 100
