"""The process that reads one geometry with gmsh and meshes it, confined: the child of `hybrid.body.mesh`.

It answers with arrays, or with the text of an error, in a file that it opens before it is confined. A process has one
task, and ends; gmsh is imported nowhere else.
"""

import difflib
import inspect
import io
import json
import os
import zipfile  # noqa: F401  numpy imports it when it writes, which is too late in a confined process
from contextlib import contextmanager
from pathlib import Path

import gmsh
import numpy as np
import numpy.ctypeslib  # noqa: F401  used by gmsh; numpy 2 imports it at its first use, too late as well

from hybrid.body.bare_files import make_groups
from hybrid.body.geometry_text import SOLIDS
from hybrid.runtime.errors import GeometryError
from hybrid.runtime.sandbox import confine, limit

PREFIX = "Parameters/"
NO_REASON = "gmsh gives no reason, which is so when it needs more than {:.3g} GiB of memory, the limit; {}"
FULL = "meshing needed more than {:.3g} GiB of memory, the limit; {}"
LARGEST_ANSWER = 1 << 30       # [bytes]
TRIANGLE, TETRAHEDRON = 2, 4  # gmsh's numbers of the linear element types
SEAM = 1e-3                   # between two normals of one node on one surface
AROUND, BESIDE, ALIKE = 8, 1e-3, 0.02   # of a pole: normals, their distance as a share of the surface, and most difference


def main(request):
    """Do the task of a request, a text in JSON, in the working folder; write answer.npz there."""
    request = json.loads(request)
    limit(request["seconds"], request["memory"], LARGEST_ANSWER)
    geometry = Path("geometry").resolve()
    np.savez(io.BytesIO(), np.zeros(1), text=np.array([""]))    # loads what writing needs
    with open("answer.npz", "wb") as file:
        confine(geometry)
        try:
            with session(geometry / request["file"], request):
                answer = {"version": gmsh.option.getString("General.Version"), **mesh(request)}
        except GeometryError as error:
            answer = {"error": str(error)}
        np.savez(file, **{name: np.asarray(value) for name, value in answer.items()})
        file.flush()
        os._exit(0)     # whatever gmsh would still do at its end


def mesh(request):
    """Arrays of the mesh: the fields of TetMesh, and its named points as two arrays."""
    path = Path(request["path"])
    check_names(path, request["parameters"])
    if path.suffix.lower() != ".geo":
        make_groups(path, request)
    require_groups(path, request["volumes"])
    gmsh.model.mesh.generate(3)
    check_log(path)
    check_size(path, request["tetrahedra"], request["remedy"])
    return read_mesh(path, request["volumes"])


@contextmanager
def session(file, request):
    """Open the file in gmsh with the parameters of the request; errors of gmsh become GeometryErrors."""
    # newer gmsh would reset the Ctrl-C handler of the whole program
    known = inspect.signature(gmsh.initialize).parameters
    gmsh.initialize([], False, **({"interruptible": False} if "interruptible" in known else {}))
    try:
        gmsh.logger.start()
        gmsh.option.setNumber("General.Terminal", 0)
        if file.suffix.lower() in SOLIDS:
            gmsh.option.setString("Geometry.OCCTargetUnit", "M")    # a .geo file says it by itself
        for name, value in request["parameters"].items():
            given = {"type": "number", "name": PREFIX + name, "values": [float(value)], "clients": {"given": 31}}
            gmsh.onelab.set(json.dumps(given))
        gmsh.open(str(file))
        check_log(request["path"])
        yield
    except Exception as error:
        full = "Out of memory" in str(error)    # gmsh's own words for some of its allocations; others end it
        if type(error) is not Exception and not full:  # gmsh raises the bare class, nothing else does
            raise
        silent = (FULL if full else NO_REASON).format(request["memory"] / 2**30, request["remedy"])
        reason = reported(error) if str(error) and not full else silent
        raise GeometryError(f"geometry {request['path']}: {reason}") from error


def declared():
    """Names of the parameters that the file declares: gmsh is a client of those that it has met in the file."""
    found = gmsh.onelab.getNames(f"{PREFIX}.*")
    return [name[len(PREFIX) :] for name in found if '"Gmsh":' in gmsh.onelab.get(name)]


def check_names(path, given):
    """Refuse parameters that the file does not declare."""
    known = ["size"] if path.suffix.lower() in SOLIDS else declared()
    for name in given:
        if name not in known:
            raise GeometryError(f"geometry {path} has no parameter '{name}'" + _parameter_remedy(path, name, known))


def check_size(path, most, remedy):
    """Refuse a mesh of more than so many tetrahedra."""
    count = sum(map(len, gmsh.model.mesh.getElements(3)[1]))
    if count > most:
        raise GeometryError(f"geometry {path}: {count} tetrahedra, above the limit of {most}; {remedy}")


def check_log(path):
    """Raise the first error of gmsh's log: some failures are only logged."""
    errors = [line.split(":", 1)[1].strip() for line in gmsh.logger.get() if line.startswith("Error")]
    if errors:
        raise GeometryError(f"geometry {path}: {reported(errors[0])}")


def reported(error):
    """What gmsh says, with a remedy where it leaves a volume empty."""
    too_large = "No elements in volume" in str(error)
    remedy = "; elements are too large for the shape: give smaller ones (parameter size, Mesh.MeshSizeMax)"
    return f"gmsh reports: {str(error).strip()}{remedy if too_large else ''}"


def _parameter_remedy(path, name, known):
    """End of the message on a parameter that the file does not declare: the nearest one, or how to declare it."""
    if path.suffix.lower() != ".geo" and not known:
        return f": {path.suffix} files declare none; remove '{name}', or use a .geo file"
    if known:
        nearest = difflib.get_close_matches(name, known, n=1, cutoff=0.0)[0]
        return f"; did you mean '{nearest}'? (declared: {', '.join(sorted(known))})"
    return (f' (declared: none); a parameter must be named "{PREFIX}{name}" in the file: '
            f'DefineConstant[ {name} = {{1.0, Name "{PREFIX}{name}"}} ];')


def groups(dim):
    """Physical groups of one dimension: name -> entities."""
    tags = [tag for _, tag in gmsh.model.getPhysicalGroups(dim)]
    return {gmsh.model.getPhysicalName(dim, t): gmsh.model.getEntitiesForPhysicalGroup(dim, t) for t in tags}


def require_groups(path, volumes):
    """Refuse a geometry without its groups, with volumes that belong to no body, or without the `volumes` named."""
    wanted = [(3, "Volume", "body")] * (not groups(3)) + [(2, "Surface", "contact")] * has_surface(path)
    for dim, kind, name in wanted:
        if name not in groups(dim):
            found = ", ".join(f"'{n}'" for n in groups(dim)) or "none"
            remedy = " to the .geo file that the mesh was made from" if path.suffix.lower() == ".msh" else ""
            raise GeometryError(f"geometry {path} has no physical {kind.lower()} '{name}' (found: {found}); "
                                f'add Physical {kind}("{name}") = {{...}};{remedy}')
    check_volumes_named(path, volumes)
    outside = {tag for _, tag in gmsh.model.getEntities(3)} - {tag for tags in body_groups(volumes) for tag in tags}
    if outside:
        names = ", ".join(groups(3))
        one = (f"the physical volumes {', '.join(volumes)} of body.density" if volumes else "the physical volume 'body'"
               if "body" in groups(3) else f"the physical volumes {names}")
        raise GeometryError(f"geometry {path}: volumes {sorted(outside)} are not in {one}; "
                            "delete them, fuse them or add them to " + ("one of them" if volumes else "the group"))


def has_surface(path):
    """Whether the contact surface is a group: of triangles and meshes it is all of the outside unless they have one."""
    return path.suffix.lower() in (".geo", *SOLIDS) or "contact" in groups(2)


def body_groups(volumes):
    """Volumes [(tag, ...)] of each physical volume that a body consists of: those named, else `body`, else all."""
    if volumes or "body" in groups(3):
        return [tuple(map(int, groups(3)[name])) for name in volumes or ["body"]]
    return [tuple(sorted({int(tag) for tags in groups(3).values() for tag in tags}))]


def check_volumes_named(path, volumes):
    """Refuse names that are no physical volumes, and volumes that have two of the names."""
    known = [name for name in groups(3) if name != "body"] or list(groups(3))
    for name in volumes:
        if name not in groups(3):
            nearest = difflib.get_close_matches(name, known, n=1, cutoff=0.0)
            raise GeometryError(f"geometry {path} has no physical volume '{name}', which density names"
                                + (f"; did you mean '{nearest[0]}'? (it has: {', '.join(known)})" if known else
                                   ": its volumes have no names; give one number as density"))
    tags = [tag for group in body_groups(volumes) for tag in group] if volumes else []
    twice = sorted({tag for tag in tags if tags.count(tag) > 1})
    if twice:
        raise GeometryError(f"geometry {path}: volumes {twice} are in several of the physical volumes that density names "
                            f"({', '.join(volumes)}); a volume has one density")


def read_mesh(path, volumes):
    """Arrays of TetMesh of gmsh's current model: only nodes of the tetrahedra, triangles as gmsh orients them. Without
    `contact` where all of the outside is that."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    index = np.full(int(tags.max()) + 1 if len(tags) else 1, -1, dtype=np.int64)
    skins = groups(2)
    solids = [tag for group in body_groups(volumes) for tag in group]
    parts = [elements([tag], 3, TETRAHEDRON, path) for tag in solids]
    tets = np.vstack(parts)
    if not len(tets):
        raise GeometryError(f"geometry {path}: the physical volume 'body' has no volume elements; "
                            "check that its surface is closed, or try another size")
    used = np.unique(tets)
    index[used] = np.arange(len(used))
    row = np.zeros(len(index), dtype=np.int64)
    row[tags.astype(np.int64)] = np.arange(len(tags))
    symmetry = elements(skins.get("symmetry", []), 2, TRIANGLE, path)
    points = read_points(path)
    regions, region = named_volumes(volumes, solids)
    return dict(
        points=np.asarray(coordinates).reshape(-1, 3)[row[used]],
        tets=index[tets],
        **contact_surface(path, skins, index),
        **named_parts(path, skins, index),
        symmetry=index[symmetry],
        point_names=np.array(list(points), str),
        point_places=np.array(list(points.values()), float).reshape(-1, 3),
        regions=np.array(regions, str),
        **({"region": np.repeat(region, [len(part) for part in parts])} if regions else {}),
    )


def contact_surface(path, skins, index):
    """Triangles and normals of the group `contact`; nothing without one."""
    if not has_surface(path):
        return {}
    contact = elements(skins["contact"], 2, TRIANGLE, path)
    return {"contact": index[contact], "normals": read_normals(skins["contact"])}


def named_parts(path, skins, index):
    """Physical surfaces of other names: these, their triangles (k, 3) and the number (k,) of the surface of each."""
    names = [name for name in skins if name and name not in ("contact", "symmetry")]
    seen = {}
    for name, tag in ((name, int(tag)) for name in names for tag in skins[name]):
        if seen.setdefault(tag, name) != name:
            raise GeometryError(f"geometry {path}: surface {tag} is in the physical surfaces '{seen[tag]}' and '{name}', "
                                "whose forces are reported apart; keep it in one of them")
    triangles = [elements(skins[name], 2, TRIANGLE, path) for name in names]
    return {"parts": np.array(names, str),
            "part_triangles": index[np.vstack([np.zeros((0, 3), np.int64), *triangles])],
            "part_numbers": np.repeat(np.arange(len(names)), [len(found) for found in triangles])}


def named_volumes(volumes, solids):
    """Names of the physical volumes that share the `solids`, and the number of that of each; ([], []) if they do not."""
    names = list(volumes) or [name for name in groups(3) if name != "body"]
    of = {int(tag): k for k, name in enumerate(names) for tag in groups(3)[name]}
    counted = sum(len(groups(3)[name]) for name in names)
    return (names, [of[tag] for tag in solids]) if counted == len(of) == len(solids) else ([], [])


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


def read_normals(entities):
    """Normals (t, 3, 3) of the surfaces at the corners of their triangles, one surface after the other as `elements` gives
    them; of either sign, nan where the surface has none (a mesh, the apex of a cone)."""
    parts = [np.zeros((0, 3, 3))]
    for entity in map(int, entities):
        tags = elements([entity], 2, TRIANGLE, None)
        parts.append(np.full((*tags.shape, 3), np.nan))
        if "discrete" in gmsh.model.getType(2, entity).lower() or not len(tags):
            continue
        nodes, _, place = gmsh.model.mesh.getNodes(2, entity, includeBoundary=True, returnParametricCoord=True)
        normals = surface_normals(entity, np.asarray(place).reshape(-1, 2))
        nodes, first, row = np.unique(np.asarray(nodes, dtype=np.int64), return_index=True, return_inverse=True)
        # a node on a seam of the surface is listed with both its parameters; at a pole it may have any normal
        agree = np.linalg.norm(np.cross(normals, normals[first][row.reshape(-1)]), axis=1) < SEAM
        agree &= np.abs(np.linalg.norm(normals, axis=1) - 1.0) < SEAM
        sound = np.ones(len(nodes), bool)
        np.logical_and.at(sound, row.reshape(-1), agree)
        parts[-1] = np.where(sound[:, None], normals[first], np.nan)[np.searchsorted(nodes, tags)]
    return np.concatenate(parts)


def surface_normals(entity, place):
    """Normals (n, 3) of a surface at parameters `place` (n, 2). At a pole, where all of a parameter is one point, gmsh's may
    be off, by 63 degrees on a mirrored sphere: there one that differs from the mean of those beside it is replaced by that,
    and by nan where these differ among themselves, as around an apex."""
    normals = np.asarray(gmsh.model.getNormal(entity, place.ravel())).reshape(-1, 3)
    low, high = (np.asarray(ends) for ends in gmsh.model.getParametrizationBounds(2, entity))
    slopes = np.linalg.norm(np.asarray(gmsh.model.getDerivative(2, entity, place.ravel())).reshape(-1, 2, 3), axis=2)
    slopes *= high - low
    for n in np.flatnonzero(slopes.min(axis=1) < SEAM * slopes.max(initial=0.0)):
        pole = int(slopes[n].argmin())      # the parameter that is one point
        around = np.repeat(place[n:n + 1], AROUND, axis=0)
        around[:, pole] = np.linspace(low[pole], high[pole], AROUND, endpoint=False)
        inwards = 0.5 * (low + high)[1 - pole] - place[n, 1 - pole]
        around[:, 1 - pole] += BESIDE * inwards
        near = np.asarray(gmsh.model.getNormal(entity, around.ravel())).reshape(-1, 3)
        mean = near.mean(axis=0)
        if np.linalg.norm(near - mean, axis=1).max() > ALIKE:
            normals[n] = np.nan
        elif np.linalg.norm(normals[n] - mean) > ALIKE:
            normals[n] = mean / np.linalg.norm(mean)
    return normals


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
