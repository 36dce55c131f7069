"""From a gmsh geometry file to the tetrahedra and the contact surface of a rigid body.

A geometry declares its parameters with DefineConstant under the name "Parameters/..." (lengths in metres), a
physical volume "body", a physical surface "contact", and where a body is cut by a symmetry plane a physical
surface "symmetry". Physical points give names to places, such as the end where a body is pulled.
`hybrid.body.solid` tells what the mesh has to be.
"""

import difflib
import inspect
import math
from contextlib import contextmanager
from pathlib import Path

import gmsh
import numpy as np

from hybrid.body.solid import TetMesh, oriented, validate
from hybrid.runtime.errors import GeometryError

PREFIX = "Parameters/"
TRIANGLE, TETRAHEDRON = 2, 4  # gmsh's numbers of the linear element types


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
