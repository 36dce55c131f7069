"""From a gmsh geometry file to the tetrahedra and the contact surface of a rigid body.

A geometry declares its parameters with DefineConstant under the name "Parameters/..." (lengths in metres), a
physical volume "body", a physical surface "contact", and where a body is cut by a symmetry plane a physical
surface "symmetry". Physical points are named places, such as the point where a body is pulled.
`hybrid.body.solid` checks the mesh.
"""

import difflib
import inspect
import math
from contextlib import contextmanager
from pathlib import Path

import gmsh
import numpy as np

from hybrid.body.solid import TetMesh, oriented, smoothed, validate
from hybrid.runtime.errors import GeometryError

PREFIX = "Parameters/"
TRIANGLE, TETRAHEDRON = 2, 4  # gmsh's numbers of the linear element types
SEAM = 1e-3                   # between two normals of one node on one surface
WRAPPERS = {  # by suffix: .geo statements that make a volume of a file without physical groups
    **dict.fromkeys((".step", ".stp", ".iges", ".igs", ".brep"),
                    'SetFactory("OpenCASCADE"); Geometry.OCCTargetUnit = "M"; Merge "{name}"; '
                    'Physical Volume("body") = {{1}}; Physical Surface("contact") = Abs(Boundary{{ Volume{{1}}; }});'),
    ".stl": 'Merge "{name}"; Surface Loop(1) = {{1}}; Volume(1) = {{1}}; '
            'Physical Volume("body") = {{1}}; Physical Surface("contact") = {{1}};',
}


def generate(path, parameters=None, size=None):
    """Mesh the geometry file at `path` and return a validated TetMesh.

    `parameters` maps names declared by the file to numbers [SI units; angles in the unit that the file states]; `size`
    [m] is the edge length of the tetrahedra, short for the parameter of that name.
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
    return smoothed(mesh)


def parameter_names(path):
    """Parameters the geometry file at `path` declares: name -> default. GeometryError if unreadable."""
    with session(Path(path), {}):
        found = gmsh.onelab.getNames(f"{PREFIX}.*")
        values = {name[len(PREFIX) :]: gmsh.onelab.getNumber(name) for name in found}
        return {name: float(value[0]) for name, value in values.items() if len(value)}


@contextmanager
def session(path, parameters):
    """Open the file in a gmsh session of its own, without terminal output, closed at the end even after an error.

    A failed open leaves gmsh 4.8 refusing all further work, and its parameter store survives finalize: hence
    a fresh session for every file, with the store cleared at both ends. A caller's own session is closed too.
    """
    if not path.is_file():
        raise GeometryError(f"geometry {path} cannot be read: there is no such file; check its name and folder")
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
    """Raise the first error of gmsh's log: some failures are only logged."""
    errors = [line.split(":", 1)[1].strip() for line in gmsh.logger.get() if line.startswith("Error")]
    if errors:
        raise GeometryError(f"geometry {path}: gmsh reports: {errors[0]}")


def check_parameters(path, parameters):
    """Refuse parameters that the file does not declare, and values that are not finite numbers."""
    known = parameter_names(path)
    for name, value in parameters.items():
        if name not in known:
            raise GeometryError(f"geometry {path} has no parameter '{name}'" + _parameter_remedy(path, name, known))
        number = isinstance(value, (int, float, np.number)) and not isinstance(value, bool)
        if not number or not math.isfinite(value):
            raise GeometryError(f"geometry {path}: parameter '{name}' = {value!r} must be a finite number")
    if parameters.get("size", 1.0) <= 0.0:
        raise GeometryError(f"geometry {path}: size = {parameters['size']} m must be positive")


def _parameter_remedy(path, name, known):
    """End of the message on a parameter that the file does not declare: the nearest one, or how to declare it."""
    if path.suffix != ".geo":
        return f": {path.suffix or 'its'} files declare none; remove '{name}', or use a .geo file"
    if known:
        nearest = difflib.get_close_matches(name, known, n=1, cutoff=0.0)[0]
        return f"; did you mean '{nearest}'? (declared: {', '.join(sorted(known))})"
    return (f' (declared: none); a parameter must be named "{PREFIX}{name}" in the file: '
            f'DefineConstant[ {name} = {{1.0, Name "{PREFIX}{name}"}} ];')


def groups(dim):
    """Physical groups of one dimension: name -> entities."""
    tags = [tag for _, tag in gmsh.model.getPhysicalGroups(dim)]
    return {gmsh.model.getPhysicalName(dim, t): gmsh.model.getEntitiesForPhysicalGroup(dim, t) for t in tags}


def require_groups(path):
    """Refuse a geometry without the two groups, or with volumes that belong to no body."""
    for dim, kind, name in ((3, "Volume", "body"), (2, "Surface", "contact")):
        if name not in groups(dim):
            found = ", ".join(f"'{n}'" for n in groups(dim)) or "none"
            raise GeometryError(f"geometry {path} has no physical {kind.lower()} '{name}' (found: {found}); "
                                + _group_remedy(path, kind, name))
    outside = {tag for _, tag in gmsh.model.getEntities(3)} - set(map(int, groups(3)["body"]))
    if outside:
        raise GeometryError(
            f"geometry {path}: volumes {sorted(outside)} are not in the physical volume 'body'; "
            "delete them, fuse them or add them to the group"
        )


def _group_remedy(path, kind, name):
    """End of the message on a missing group: what can be done for this type of file."""
    wrapper = WRAPPERS.get(path.suffix.lower())
    if wrapper:
        return (f"a {path.suffix} file has no physical groups: write a .geo file next to it and use that as geometry: "
                + wrapper.format(name=path.name))
    if path.suffix.lower() == ".msh":
        return f'add Physical {kind}("{name}") = {{...}}; to the .geo file that the mesh was made from'
    return f'add Physical {kind}("{name}") = {{...}};'


def read_mesh(path):
    """TetMesh of gmsh's current model: only the nodes of the tetrahedra, triangles as gmsh orients them."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    index = np.full(int(tags.max()) + 1 if len(tags) else 1, -1, dtype=np.int64)
    solids, skins = groups(3), groups(2)
    tets = elements(solids["body"], 3, TETRAHEDRON, path)
    if not len(tets):
        raise GeometryError(f"geometry {path}: the physical volume 'body' has no volume elements; "
                            "check that its surface is closed, or try another size")
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
        normals=read_normals(skins["contact"], contact),
        symmetry=index[symmetry],
        named_points=read_points(path),
        name=path.stem,
    )


def elements(entities, dim, kind, path):
    """Node tags (m, dim + 1) of all elements on the entities. GeometryError unless all are of type `kind`."""
    width = dim + 1
    parts = [np.zeros((0, width), dtype=np.int64)]
    for entity in entities:
        types, _, nodes = gmsh.model.mesh.getElements(dim, int(entity))
        for element_type, tags in zip(types, nodes):
            if element_type != kind:
                found = gmsh.model.mesh.getElementProperties(int(element_type))[0]
                raise GeometryError(f"geometry {path}: elements of type '{found}', but only linear triangles and "
                                    "tetrahedra can be used; remove Mesh.ElementOrder and Recombine")
            parts.append(np.asarray(tags).astype(np.int64).reshape(-1, width))
    return np.vstack(parts)


def read_normals(entities, triangles):
    """Normals (t, 3, 3) of the surfaces at the corners of their `triangles` (t, 3) of node tags, one surface after the
    other as `elements` gives them; of either sign, nan where the surface has none (a mesh, the apex of a cone)."""
    parts = [np.zeros((0, 3, 3))]
    for entity in map(int, entities):
        tags = elements([entity], 2, TRIANGLE, None)
        parts.append(np.full((*tags.shape, 3), np.nan))
        if "discrete" in gmsh.model.getType(2, entity).lower() or not len(tags):
            continue
        nodes, _, place = gmsh.model.mesh.getNodes(2, entity, includeBoundary=True, returnParametricCoord=True)
        normals = np.asarray(gmsh.model.getNormal(entity, place)).reshape(-1, 3)
        nodes, first, row = np.unique(np.asarray(nodes, dtype=np.int64), return_index=True, return_inverse=True)
        # a node on a seam of the surface is listed with both its parameters; at a pole it may have any normal
        agree = np.linalg.norm(np.cross(normals, normals[first][row.reshape(-1)]), axis=1) < SEAM
        agree &= np.abs(np.linalg.norm(normals, axis=1) - 1.0) < SEAM
        sound = np.ones(len(nodes), bool)
        np.logical_and.at(sound, row.reshape(-1), agree)
        parts[-1] = np.where(sound[:, None], normals[first], np.nan)[np.searchsorted(nodes, tags)]
    return np.concatenate(parts)


def read_points(path):
    """Physical points: name -> coordinates (3,) [m]."""
    named = {}
    for name, entities in groups(0).items():
        if len(entities) != 1:
            count = len(entities)
            raise GeometryError(f"geometry {path}: physical point '{name}' has {count} points, expected 1; "
                                "name each point with a group of its own")
        named[name] = np.array(gmsh.model.getValue(0, int(entities[0]), []), dtype=float)
    return named
