"""Half of a body of tetrahedra: what lies on the positive side of a plane through the origin, with the cap recognised.

A tetrahedron that the plane passes through leaves a convex polyhedron. Its faces are those of the tetrahedron, clipped,
and the cap; each polygon is split into triangles from its corner with the lowest number, and the polyhedron into
tetrahedra from its own one, to the faces that do not have it. Neighbours split the face that they share in the same way.

Meshes and triangles have no surface behind them that gmsh could cut; it cuts solids (`hybrid.body.bare_files`).
"""

from dataclasses import replace

import numpy as np

from hybrid.body.solid import FACES, boundary_faces, label, signed_volumes
from hybrid.body.symmetry import AXES, check_halves
from hybrid.runtime.errors import GeometryError

ON = 1e-5   # of the body's size: nodes nearer to the plane than this are moved onto it


def half_of(mesh, axis):
    """The part of a TetMesh on the positive side of the plane `axis` = 0 ("x" or "y"), its cut face as `symmetry`.

    Raises GeometryError where nothing lies there, where the two sides differ, or where the mesh has a cut face already.
    """
    if len(mesh.symmetry):
        raise GeometryError(f"{label(mesh)} has a physical surface 'symmetry', so it is cut already: leave "
                            f"symmetry = '{axis}' out")
    a = AXES[axis]
    points = mesh.points.copy()
    points[np.abs(points[:, a]) < ON * np.ptp(points, axis=0).max(), a] = 0.0
    whole, (points, tets, parents, cuts) = signed_volumes(points, mesh.tets).sum(), _clipped(points, mesh.tets, a)
    kept = signed_volumes(points, tets).sum()
    check_halves(whole, kept, axis, label(mesh))
    used = np.unique(tets)
    outer = boundary_faces(tets)
    on_plane = (points[outer, a] == 0.0).all(axis=1)
    number = np.zeros(len(points), np.int64)
    number[used] = np.arange(len(used))
    contact = outer[~on_plane]
    return replace(
        mesh, points=points[used], tets=number[tets], contact=number[contact], symmetry=number[outer[on_plane]],
        normals=None if mesh.normals is None else _normals(mesh, contact, cuts),
        region=None if mesh.region is None else mesh.region[parents],
        named_points={name: x for name, x in mesh.named_points.items() if x[a] >= -ON * np.ptp(points[:, a])})


def _clipped(points, tets, a):
    """(points, tets, their former numbers, {number of a new point: the ends of its edge}) at coordinate `a` >= 0."""
    above, below = points[tets, a] > 0.0, points[tets, a] < 0.0
    crossed = above.any(axis=1) & below.any(axis=1)
    whole = np.flatnonzero(above.any(axis=1) & ~crossed)
    new, places, pieces, parents = {}, [], [], []

    def crossing(i, j):
        edge = (min(i, j), max(i, j))
        if edge not in new:
            new[edge] = len(points) + len(places)
            p, q = points[edge[0]], points[edge[1]]
            place = p + p[a] / (p[a] - q[a]) * (q - p)
            place[a] = 0.0
            places.append(place)
        return new[edge]

    for t in np.flatnonzero(crossed):
        polygons = [_clipped_polygon(tets[t][face].tolist(), points[:, a], crossing) for face in FACES]
        split = _tetrahedra([polygon for polygon in polygons if len(polygon) > 2])
        pieces += split
        parents += [t] * len(split)
    points = np.vstack([points, *places]) if places else points
    tets = np.vstack([tets[whole], np.array(pieces, np.int64).reshape(-1, 4)])
    return points, tets, np.concatenate([whole, np.array(parents, np.int64)]), {c: edge for edge, c in new.items()}


def _clipped_polygon(polygon, height, crossing):
    """Corners of a polygon at `height` >= 0; crossing: gives the number of the point where an edge is cut."""
    kept = []
    for i, j in zip(polygon, polygon[1:] + polygon[:1]):
        if height[i] >= 0.0:
            kept.append(i)
        if height[i] * height[j] < 0.0:
            kept.append(crossing(i, j))
    return kept


def _tetrahedra(polygons):
    """Tetrahedra of a convex polyhedron; `polygons`: all of its faces but the cap, counter-clockwise from outside."""
    edges = {(i, j) for polygon in polygons for i, j in zip(polygon, polygon[1:] + polygon[:1])}
    ahead = {j: i for i, j in edges if (j, i) not in edges}     # the cap's edges run the other way
    cap = [min(ahead)]
    while ahead[cap[-1]] != cap[0]:
        cap.append(ahead[cap[-1]])
    apex = min(min(polygon) for polygon in polygons)
    found = []
    for polygon in (*polygons, cap):
        if apex not in polygon:
            k = polygon.index(min(polygon))
            first, *rest = polygon[k:] + polygon[:k]
            found += [(apex, first, i, j) for i, j in zip(rest, rest[1:])]
    return found


def _normals(mesh, contact, cuts):
    """Normals (t, 3, 3) at the corners of the triangles `contact` (t, 3) that are left: those of the triangles of `mesh`
    that they are part of, at corners from `cuts` between those at the ends of the edge."""
    ends = np.array([cuts.get(node, (node, node)) for node in contact.ravel().tolist()]).reshape(-1, 3, 2)
    former = {tuple(sorted(triangle)): k for k, triangle in enumerate(mesh.contact.tolist())}
    normals = np.full((*contact.shape, 3), np.nan)
    for t, corners in enumerate(ends):
        nodes = sorted(set(corners.ravel().tolist()))
        if len(nodes) == 3 and tuple(nodes) in former:
            k = former[tuple(nodes)]
            of = dict(zip(mesh.contact[k].tolist(), mesh.normals[k]))
            between = np.array([of[i] + of[j] for i, j in corners.tolist()])
            normals[t] = between / np.linalg.norm(between, axis=1, keepdims=True)   # nan stays nan
    return normals
