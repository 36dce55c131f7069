"""From a gmsh geometry file to the tetrahedra and the contact surface of a rigid body.

A geometry declares its parameters with DefineConstant under the name "Parameters/..." (lengths in metres), a
physical volume "body", a physical surface "contact", and where a body is cut by a symmetry plane a physical
surface "symmetry". Physical points give names to places, such as the end where a body is pulled.

| field          | what                                                     | shape  | unit |
|----------------|----------------------------------------------------------|--------|------|
| points         | nodes of the tetrahedra, in the geometry's coordinates   | (n, 3) | m    |
| tets           | corners of each tetrahedron, positively oriented         | (m, 4) | -    |
| contact        | triangles the soil may touch, seen counter-clockwise     | (t, 3) | -    |
| symmetry       | triangles of the cut face, seen counter-clockwise        | (s, 3) | -    |
| named_points   | name -> coordinates                                      | (3,)   | m    |
"""

import difflib
import inspect
import math
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

import gmsh
import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from hybrid.errors import GeometryError

PREFIX = "Parameters/"
TRIANGLE, TETRAHEDRON = 2, 4  # gmsh's numbers of the linear element types
FLAT = 1e-12  # volume over cubed longest edge below which a tetrahedron counts as flat
# Faces of a positively oriented tetrahedron, counter-clockwise from outside; face k is opposite corner k.
FACES = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])


@dataclass(frozen=True)
class TetMesh:
    """Tetrahedra of one solid and the groups of its surface; fields in the module's table."""

    points: np.ndarray
    tets: np.ndarray
    contact: np.ndarray
    symmetry: np.ndarray = field(default_factory=lambda: np.zeros((0, 3), dtype=np.int64))
    named_points: dict[str, np.ndarray] = field(default_factory=dict)
    name: str = ""


def generate(path, parameters=None, size=None):
    """Mesh the geometry file at `path` and return a validated TetMesh.

    `parameters` maps names declared by the file to numbers [SI units; angles as the file says]; `size` [m] is
    the edge length of the tetrahedra, short for the parameter of that name.
    Raises GeometryError with the reason when the file, a parameter, a group or the mesh is unusable.
    """
    path = Path(path)
    parameters = dict(parameters or {})
    if size is not None:
        parameters["size"] = size
    if parameters:
        check_parameters(path, parameters)
    with session(path, parameters):
        require_groups(path)
        gmsh.model.mesh.generate(3)
        check_log(path)
        mesh = read_mesh(path)
    mesh = oriented(mesh)
    validate(mesh)
    return mesh


def parameter_names(path):
    """Parameters the geometry file at `path` declares: name -> default. GeometryError if unreadable."""
    with session(Path(path), {}):
        found = gmsh.onelab.getNames(f"{PREFIX}.*")
        values = {name[len(PREFIX) :]: gmsh.onelab.getNumber(name) for name in found}
        return {name: float(value[0]) for name, value in values.items() if len(value)}


# ---- gmsh --------------------------------------------------------------------------------------------------


@contextmanager
def session(path, parameters):
    """Open the file in a gmsh of its own, quietly; nothing of it outlives the block, not even after an error.

    A failed open leaves gmsh 4.8 refusing all further work, and its parameter store survives finalize: hence
    a fresh session for every file, with the store cleared at both ends. A caller's own session is closed too.
    """
    if not path.is_file():
        raise GeometryError(f"geometry {path} cannot be read: there is no such file")
    # newer gmsh would reset the Ctrl-C handler of the whole program
    known = inspect.signature(gmsh.initialize).parameters
    gmsh.initialize([], False, **({"interruptible": False} if "interruptible" in known else {}))
    try:
        gmsh.logger.start()
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.onelab.clear()
        for name, value in parameters.items():
            gmsh.onelab.setNumber(PREFIX + name, [float(value)])
        gmsh.open(str(path))
        check_log(path)
        yield
    except Exception as error:
        if type(error) is not Exception:  # gmsh raises the bare class, nothing else does
            raise
        raise GeometryError(f"geometry {path}: gmsh reports: {error}") from error
    finally:
        gmsh.logger.stop()
        gmsh.onelab.clear()
        gmsh.finalize()


def check_log(path):
    """Some failures only reach gmsh's log: raise the first one."""
    errors = [line.split(":", 1)[1].strip() for line in gmsh.logger.get() if line.startswith("Error")]
    if errors:
        raise GeometryError(f"geometry {path}: gmsh reports: {errors[0]}")


def check_parameters(path, parameters):
    """Refuse parameters that the file does not declare, and values that are not finite numbers."""
    known = parameter_names(path)
    for name, value in parameters.items():
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1, cutoff=0.0)
            hint = f"; did you mean '{near[0]}'?" if near else ""
            declared = ", ".join(sorted(known)) or "none"
            raise GeometryError(f"geometry {path} has no parameter '{name}'{hint} (declared: {declared})")
        number = isinstance(value, (int, float, np.number)) and not isinstance(value, bool)
        if not number or not math.isfinite(value):
            raise GeometryError(f"geometry {path}: parameter '{name}' = {value!r} must be a finite number")
    if parameters.get("size", 1.0) <= 0.0:
        raise GeometryError(f"geometry {path}: size = {parameters['size']} m must be positive")


def groups(dim):
    """Physical groups of one dimension: name -> entities."""
    tags = [tag for _, tag in gmsh.model.getPhysicalGroups(dim)]
    return {gmsh.model.getPhysicalName(dim, t): gmsh.model.getEntitiesForPhysicalGroup(dim, t) for t in tags}


def require_groups(path):
    """Refuse a geometry without the two groups, or with volumes that belong to no body."""
    for dim, kind, name in ((3, "Volume", "body"), (2, "Surface", "contact")):
        if name not in groups(dim):
            have = ", ".join(f"'{n}'" for n in groups(dim)) or "none"
            raise GeometryError(
                f"geometry {path} has no physical {kind.lower()} '{name}' (found: {have}); "
                f'add Physical {kind}("{name}") = {{...}};'
            )
    outside = {tag for _, tag in gmsh.model.getEntities(3)} - set(map(int, groups(3)["body"]))
    if outside:
        raise GeometryError(
            f"geometry {path}: volumes {sorted(outside)} are not in the physical volume 'body'; "
            "delete them, fuse them or add them to the group"
        )


def read_mesh(path):
    """The mesh gmsh holds: nodes compacted to those of the tetrahedra, triangles oriented as they come."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    index = np.full(int(tags.max()) + 1 if len(tags) else 1, -1, dtype=np.int64)
    solids, skins = groups(3), groups(2)
    tets = elements(solids["body"], 3, TETRAHEDRON, path)
    if not len(tets):
        raise GeometryError(f"geometry {path}: the physical volume 'body' holds no volume elements")
    used = np.unique(tets)
    index[used] = np.arange(len(used))
    row = np.zeros(len(index), dtype=np.int64)
    row[tags.astype(np.int64)] = np.arange(len(tags))
    contact = elements(skins["contact"], 2, TRIANGLE, path)
    symmetry = elements(skins.get("symmetry", []), 2, TRIANGLE, path)
    return TetMesh(
        points=np.asarray(coordinates).reshape(-1, 3)[row[used]],
        tets=index[tets],
        contact=index[contact],
        symmetry=index[symmetry],
        named_points=read_points(path),
        name=path.stem,
    )


def elements(entities, dim, kind, path):
    """Node tags (m, k) of all elements on the entities; anything but the linear simplex is refused."""
    width = dim + 1
    parts = [np.zeros((0, width), dtype=np.int64)]
    for entity in entities:
        types, _, nodes = gmsh.model.mesh.getElements(dim, int(entity))
        for element_type, tags in zip(types, nodes):
            if element_type != kind:
                found = gmsh.model.mesh.getElementProperties(int(element_type))[0]
                raise GeometryError(f"geometry {path}: elements of type '{found}', only linear simplices do")
            parts.append(np.asarray(tags).astype(np.int64).reshape(-1, width))
    return np.vstack(parts)


def read_points(path):
    """Physical points: name -> coordinates (3,) [m]."""
    named = {}
    for name, entities in groups(0).items():
        if len(entities) != 1:
            count = len(entities)
            raise GeometryError(f"geometry {path}: physical point '{name}' has {count} points, expected 1")
        named[name] = np.array(gmsh.model.getValue(0, int(entities[0]), []), dtype=float)
    return named


# ---- pure numpy --------------------------------------------------------------------------------------------


def boundary_faces(tets):
    """Faces (b, 3) that belong to one tetrahedron only, seen counter-clockwise from outside.

    Raises GeometryError when more than two tetrahedra share a face.
    """
    faces = tets[:, FACES].reshape(-1, 3)
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    if count.max() > 2:
        bad = faces[first[np.argmax(count)]]
        raise GeometryError(f"{count.max()} tetrahedra share the face of nodes {bad.tolist()}, at most 2 can")
    return faces[first[count == 1]]


def oriented(mesh):
    """The mesh with its contact and symmetry triangles turned outward, where they lie on the boundary."""
    outward = {tuple(sorted(face)): face for face in boundary_faces(mesh.tets).tolist()}

    def turn(triangles):
        turned = [outward.get(tuple(sorted(t)), t) for t in triangles.tolist()]
        return np.array(turned, dtype=np.int64).reshape(-1, 3)

    return replace(mesh, contact=turn(mesh.contact), symmetry=turn(mesh.symmetry))


def signed_volumes(points, tets):
    """Signed volumes (m,) [m³]; positive when corner 3 is on the side that the triangle 0, 1, 2 faces."""
    a, b, c, d = (points[tets[:, k]] for k in range(4))
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6.0


def validate(mesh):
    """Raise GeometryError unless `mesh` is one closed, correctly oriented solid covered by its groups."""
    places = dict(enumerate(mesh.points)) | {f"'{name}'": point for name, point in mesh.named_points.items()}
    for name, point in places.items():
        if not np.isfinite(point).all():
            raise GeometryError(f"{label(mesh)}: point {name} has coordinates {point.tolist()}, not finite")
    if not len(mesh.tets):
        raise GeometryError(f"{label(mesh)}: no volume elements")
    check_volumes(mesh)
    check_pieces(mesh)
    boundary = boundary_faces(mesh.tets)
    check_watertight(mesh, boundary)
    check_edges(mesh, boundary)
    check_flat(mesh)


def label(mesh):
    return f"geometry '{mesh.name}'" if mesh.name else "geometry"


def place(corners):
    """Middle of some points, to be read by a person."""
    return "({:.4g}, {:.4g}, {:.4g}) m".format(*np.mean(corners, axis=0))


def check_volumes(mesh):
    volumes = signed_volumes(mesh.points, mesh.tets)
    corners = mesh.points[mesh.tets]
    longest = np.linalg.norm(corners[:, :, None] - corners[:, None, :], axis=3).max(axis=(1, 2))
    bad = np.flatnonzero(~(volumes > FLAT * longest**3))
    if len(bad):
        k = bad[0]
        kind = "negative" if volumes[k] < 0.0 else "zero"
        raise GeometryError(
            f"{label(mesh)}: {len(bad)} of {len(volumes)} tetrahedra have negative or zero volume: the "
            f"first, number {k}, has a {kind} one of {volumes[k]:.3g} m³, at {place(corners[k])}; "
            "try another size, or repair the geometry there"
        )


def check_pieces(mesh):
    """Solids that merely overlap are meshed each on its own and would count twice: they must be fused."""
    n = len(mesh.points)
    first, second = mesh.tets[:, [0, 0, 0]].ravel(), mesh.tets[:, 1:].ravel()
    joined = coo_matrix((np.ones(len(first)), (first, second)), shape=(n, n))
    piece = connected_components(joined, directed=False)[1]
    pieces = len(np.unique(piece[mesh.tets[:, 0]]))
    if pieces > 1:
        raise GeometryError(f"{label(mesh)} is in {pieces} pieces; a body is one solid: use BooleanUnion")


def check_watertight(mesh, boundary):
    """Contact and symmetry triangles together are the boundary of the tetrahedra, each once, outward."""
    grouped = np.vstack([mesh.contact, mesh.symmetry]).tolist()
    wanted = {tuple(sorted(face)): face for face in boundary.tolist()}
    given = [tuple(sorted(face)) for face in grouped]
    missing, extra = wanted.keys() - set(given), set(given) - wanted.keys()
    twice = len(given) - len(set(given))
    if missing or extra or twice:
        bad = min(missing or extra or {face for face in given if given.count(face) > 1})
        raise GeometryError(
            f"{label(mesh)} is not watertight: of {len(wanted)} faces around the tetrahedra {len(missing)} "
            f"are in neither 'contact' nor 'symmetry', {len(extra)} triangles of these groups are not on the "
            f"boundary, {twice} are there twice; the first at {place(mesh.points[list(bad)])}; "
            "every outer face belongs to exactly one of the two groups"
        )
    inward = sum(not same_turn(t, wanted[key]) for t, key in zip(grouped, given))
    if inward:
        raise GeometryError(f"{label(mesh)}: {inward} surface triangles face inward: use oriented()")


def same_turn(a, b):
    """Whether two triangles of the same nodes run round in the same sense."""
    k = b.index(a[0])
    return a[1] == b[(k + 1) % 3]


def check_edges(mesh, boundary):
    edges = np.sort(boundary[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    unique, count = np.unique(edges, axis=0, return_counts=True)
    bad = np.flatnonzero(count != 2)
    if len(bad):
        raise GeometryError(
            f"{label(mesh)} is not watertight: {len(bad)} edges of its surface join other than two "
            f"triangles; the first joins {count[bad[0]]} at {place(mesh.points[unique[bad[0]]])}; "
            "parts must not touch along an edge only"
        )


def check_flat(mesh):
    """The cut face must be plane: the model is mirrored in it."""
    if not len(mesh.symmetry):
        return
    points = mesh.points[np.unique(mesh.symmetry)]
    spread = points - points.mean(axis=0)
    out_of_plane = np.abs(spread @ np.linalg.svd(spread, full_matrices=False)[2][-1]).max()
    if out_of_plane > 1e-6 * np.abs(spread).max():
        raise GeometryError(
            f"{label(mesh)}: nodes of the physical surface 'symmetry' are up to {out_of_plane:.3g} m off "
            "its mean plane; a symmetry surface is one plane"
        )
