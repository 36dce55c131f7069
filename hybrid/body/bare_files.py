"""Files that have no physical groups, read by gmsh in the child of `hybrid.body.mesh`: solids of CAD (.step, .iges, .brep),
triangles (.stl) and meshes (.msh). Groups are made for the user:

| group               | of a solid                              | of triangles and meshes               |
|---------------------|-----------------------------------------|---------------------------------------|
| body                | all volumes                             | all volumes, or the one in the shell  |
| a volume's own name | its label in the file, else its number  | its physical volume                   |
| contact             | all outer faces but the cut             | (`hybrid.body.mesh`: outer triangles) |
| symmetry            | faces in the plane that the body is cut | (`hybrid.body.half`)                  |
|                     | in, by gmsh                             |                                       |

A shell with holes has no inside: the message names the place of its open edges.
"""

from collections import Counter

import gmsh
import numpy as np

from hybrid.body.geometry_text import SOLIDS
from hybrid.body.symmetry import AXES, check_halves
from hybrid.runtime.errors import GeometryError

SEWN = 1e-6             # of the size of a shell: gaps between its faces that are closed
IN_PLANE = 1e-6         # of the size of a body: faces nearer to the plane of symmetry than this are its cap
OVERLAP = 1e-6          # of a solid's volume that may lie in another one
ROUND, FEWEST, FINEST = 18, 20, 200     # edges around a full circle; along the diagonal of a body, and at most
NO_LABEL = "Open CASCADE STEP translator"   # what that program writes where there is no label
SHOWN = 3               # places of holes in a message


def make_groups(path, request):
    """Give gmsh's current model the groups of the table, before it is meshed. GeometryError with the place of a hole."""
    if path.suffix.lower() in SOLIDS:
        _solids(path, request)
    elif "body" not in _names(3):
        _shell(path, request["scale"])


def _names(dim):
    return {gmsh.model.getPhysicalName(*group) for group in gmsh.model.getPhysicalGroups(dim)}


def _group(dim, tags, name):
    gmsh.model.setPhysicalName(dim, gmsh.model.addPhysicalGroup(dim, [int(tag) for tag in tags]), name)


# ------------------------------------------------------------------ solids


def _solids(path, request):
    """Cut, fragment, group and size the solids of a file of CAD."""
    if not gmsh.model.getEntities(3):
        _sew()
    volumes = {tag: [_name(tag, number)] for number, (_, tag) in enumerate(gmsh.model.getEntities(3), 1)}
    if not volumes:
        _refuse_open_faces(path, request["scale"])
    axis = request["symmetry"]
    whole = _volume(volumes)
    if axis:
        of_whole = _moments(volumes, request["scale"])
        volumes = _derived(volumes, [(3, _half_space(axis))], gmsh.model.occ.intersect)
        check_halves(of_whole, _moments(volumes, request["scale"]), axis, f"geometry {path}")
    if len(volumes) > 1:
        volumes = _derived(volumes, [], gmsh.model.occ.fragment)
        _refuse_overlaps(path, volumes, whole)
    gmsh.model.occ.synchronize()
    _group(3, volumes, "body")
    for name in dict.fromkeys(name for names in volumes.values() for name in names):
        if name != "body":
            _group(3, [tag for tag, names in volumes.items() if name in names], name)
    faces = [abs(tag) for _, tag in gmsh.model.getBoundary([(3, tag) for tag in volumes], True, False)]
    cap = [tag for tag in faces if axis and _in_plane(tag, AXES[axis])]
    _group(2, [tag for tag in faces if tag not in cap], "contact")
    if cap:
        _group(2, cap, "symmetry")
    _set_sizes(request)


def _name(tag, number):
    """Label of a solid in its file, without the names of the assemblies around it; its number without one."""
    name = gmsh.model.getEntityName(3, tag).split("/")[-1].strip()
    return str(number) if not name or name.startswith(NO_LABEL) else name


def _size():
    """Diagonal of the bounding box of the model, in its own units."""
    box = np.array(gmsh.model.getBoundingBox(-1, -1))
    return float(np.linalg.norm(box[3:] - box[:3]))


def _sew():
    """Make solids of shells whose faces nearly meet."""
    gmsh.model.occ.healShapes([], SEWN * _size(), True, True, True, True, True)
    gmsh.model.occ.synchronize()


def _volume(volumes):
    return sum(gmsh.model.occ.getMass(3, tag) for tag in volumes)


def _moments(volumes, scale):
    """(4, 4) ∫ X Xᵀ dV of volumes, with X = (1, x, y, z), in metres of `scale` units."""
    total = np.zeros((4, 4))
    for tag in volumes:
        volume, centre = gmsh.model.occ.getMass(3, tag), np.array([1.0, *gmsh.model.occ.getCenterOfMass(3, tag)])
        inertia = np.reshape(gmsh.model.occ.getMatrixOfInertia(3, tag), (3, 3))
        total += volume * np.outer(centre, centre)
        total[1:, 1:] += 0.5 * np.trace(inertia) * np.eye(3) - inertia
    unit = np.array([1.0, scale, scale, scale])
    return scale**3 * np.outer(unit, unit) * total


def _half_space(axis):
    """Tag of a box that holds all of the model on the positive side of the plane."""
    box = np.array(gmsh.model.getBoundingBox(-1, -1)).reshape(2, 3)
    margin = np.ptp(box, axis=0).max()
    low, high = box[0] - margin, box[1] + margin
    low[AXES[axis]] = 0.0
    return gmsh.model.occ.addBox(*low, *np.maximum(high - low, margin))


def _derived(volumes, tools, operation):
    """{tag: names} of what an operation makes of the volumes; a piece of two volumes has both names."""
    objects = [(3, tag) for tag in volumes]
    if not tools:
        objects, tools = objects[:1], objects[1:]
    _, pieces = operation(objects, tools)
    gmsh.model.occ.synchronize()
    found = {}
    for names, made in zip(volumes.values(), pieces):
        for dim, tag in made:
            if dim == 3:
                found.setdefault(tag, []).extend(names)
    return found


def _refuse_overlaps(path, volumes, whole):
    for tag, names in volumes.items():
        if len(names) > 1 and gmsh.model.occ.getMass(3, tag) > OVERLAP * whole:
            place = gmsh.model.occ.getCenterOfMass(3, tag)
            raise GeometryError(f"geometry {path}: solids '{names[0]}' and '{names[1]}' overlap, about {_place(place)}; "
                                "cut one of them by the other in the drawing")


def _in_plane(face, a):
    box = gmsh.model.getBoundingBox(2, face)
    return max(abs(box[a]), abs(box[a + 3])) < max(IN_PLANE * _size(), 2e-7)


def _set_sizes(request):
    """Edge lengths [units of the file]: the parameter `size` [m], else a share of the body's diagonal, shorter where the
    body is round."""
    size, diagonal = request["parameters"].get("size"), _size()
    if size:
        gmsh.option.setNumber("Mesh.MeshSizeMin", size / request["scale"])
        gmsh.option.setNumber("Mesh.MeshSizeMax", size / request["scale"])
        return
    gmsh.option.setNumber("Mesh.MeshSizeMax", diagonal / FEWEST)
    gmsh.option.setNumber("Mesh.MeshSizeMin", diagonal / FINEST)
    gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", ROUND)
    if gmsh.option.getString("General.Version").startswith("4.8"):      # there a switch, beside the number
        gmsh.option.setNumber("Mesh.MinimumElementsPerTwoPi", ROUND)


def _refuse_open_faces(path, scale):
    """The error of CAD without a solid: where the edges of its faces are open."""
    faces = gmsh.model.getEntities(2)
    if not faces:
        raise GeometryError(f"geometry {path}: has no faces; export the solid, not its edges or a drawing of it")
    edges = gmsh.model.getBoundary(faces, True, False)
    boxes = [np.array(gmsh.model.getBoundingBox(dim, abs(tag))).reshape(2, 3) for dim, tag in edges]
    _refuse_holes(path, "edges of faces", [box.mean(axis=0) * scale for box in boxes], len(boxes))


# ------------------------------------------------------------------ triangles and meshes


def _shell(path, scale):
    """The body of a mesh: its volume elements, or the inside of its triangles."""
    entities = [tag for dim, tag in gmsh.model.getEntities(3) if len(gmsh.model.mesh.getElements(dim, tag)[0])]
    if not entities:
        surfaces = [tag for _, tag in gmsh.model.getEntities(2)]
        triangles = gmsh.model.mesh.getElementsByType(2)[1].astype(np.int64).reshape(-1, 3)
        if not len(triangles):
            raise GeometryError(f"geometry {path}: has no triangles; export the surface of the body as triangles")
        _refuse_leaks(path, triangles, scale)
        entities = [gmsh.model.geo.addVolume([gmsh.model.geo.addSurfaceLoop(surfaces)])]
        gmsh.model.geo.synchronize()
    _group(3, entities, "body")


def _refuse_leaks(path, triangles, scale):
    """Refuse triangles (t, 3) of node tags that are no closed surface, with the places of its holes."""
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    unique, count = np.unique(edges, axis=0, return_counts=True)
    loose = unique[count == 1]
    if len(loose):
        holes = _holes(loose.tolist())
        places = [np.mean([_node(n) for n in hole], axis=0) * scale for hole in holes]
        _refuse_holes(path, "edges of triangles", places, len(loose))
    crowded = np.flatnonzero(count > 2)
    if len(crowded):
        k = crowded[0]
        place = np.mean([_node(n) for n in unique[k]], axis=0) * scale
        raise GeometryError(f"geometry {path}: {len(crowded)} edges join more than two triangles, which no surface of a "
                            f"solid has; the first joins {count[k]}, at {_place(place)}; remove inner walls and "
                            "triangles that are there twice")


def _node(tag):
    return gmsh.model.mesh.getNode(int(tag))[0]


def _holes(edges):
    """Nodes of the connected parts of `edges` [(i, j)], the one of most nodes first."""
    hole = {}
    for i, j in edges:
        one, two = hole.setdefault(i, {i}), hole.setdefault(j, {j})
        if one is not two:
            small, large = sorted((one, two), key=len)
            large |= small
            hole.update(dict.fromkeys(small, large))
    return sorted({id(part): part for part in hole.values()}.values(), key=len, reverse=True)


def _refuse_holes(path, what, places, edges):
    counted = Counter(map(_place, places))
    shown = ", ".join(list(counted)[:SHOWN]) + (f" and {len(counted) - SHOWN} more" if len(counted) > SHOWN else "")
    raise GeometryError(f"geometry {path} is not closed: {edges} {what} have a face on one side only, about {shown}; close "
                        "the surface there, in the program that made it")


def _place(point):
    return "({:.4g}, {:.4g}, {:.4g}) m".format(*(x + 0.0 for x in point))
