"""Half of a body of tetrahedra: what lies on the positive side of a plane through the origin, with the cap recognised.

A tetrahedron that the plane passes through leaves a convex polyhedron. Its faces are those of the tetrahedron, clipped,
and the cap; each polygon is split into triangles from its corner with the lowest number, and the polyhedron into
tetrahedra from its own one, to the faces that do not have it. Neighbours split the face that they share in the same way.

Where an edge of the contact surface is smooth, its normals n_i, n_j say how it is curved. It is cut at

    x = x_c + h m      h = s (1 - s) (n_j - n_i)·d / 2      m = (n_i + n_j) / |n_i + n_j|

with x_c the cut of the chord d = x_j - x_i at its share s, moved along the chord back into the plane.
Meshes and triangles have no surface behind them that gmsh could cut; it cuts solids (`hybrid.body.bare_files`).
"""

from dataclasses import replace

import numpy as np

from hybrid.body.solid import FACES, boundary_faces, label, moments
from hybrid.body.symmetry import AXES, check_halves
from hybrid.runtime.errors import GeometryError

SMOOTH = 1e-3   # between the normals of two triangles at a node of their common edge
UPRIGHT = 0.2   # of the normal of a surface along that of the plane, up to which they are at right angles in truth
ON = 1e-5       # of the body's size: nodes nearer to the plane than this are moved onto it


def half_of(mesh, axis):
    """The part of a TetMesh with normals on the positive side of the plane `axis` = 0 ("x" or "y"), its cut face as
    `symmetry`.

    Raises GeometryError where nothing lies there, where the two sides differ, or where the mesh has a cut face already.
    """
    if len(mesh.symmetry):
        raise GeometryError(f"{label(mesh)} has a physical surface 'symmetry', so it is cut already: leave "
                            f"symmetry = '{axis}' out")
    a = AXES[axis]
    points = mesh.points.copy()
    points[np.abs(points[:, a]) < ON * np.ptp(points, axis=0).max(), a] = 0.0
    whole, (points, tets, parents, cuts) = moments(points, mesh.tets), _clipped(mesh, points, a)
    check_halves(whole, moments(points, tets), axis, label(mesh))
    used = np.unique(tets)
    outer = boundary_faces(tets)
    on_plane = (points[outer, a] == 0.0).all(axis=1)
    number = np.zeros(len(points), np.int64)
    number[used] = np.arange(len(used))
    contact = outer[~on_plane]
    former = _former(mesh, contact, cuts)
    return replace(
        mesh, points=points[used], tets=number[tets], contact=number[contact], symmetry=number[outer[on_plane]],
        normals=_normals(mesh, contact, cuts, former, a),
        part=None if mesh.part is None else mesh.part[former],
        region=None if mesh.region is None else mesh.region[parents],
        named_points={name: x for name, x in mesh.named_points.items() if x[a] >= -ON * np.ptp(points[:, a])})


def _clipped(mesh, points, a):
    """(points, tets, their former numbers, {number of a new point: the ends of its edge}) at coordinate `a` >= 0."""
    tets, curved = mesh.tets, _smooth_edges(mesh, points[:, a])
    above, below = points[tets, a] > 0.0, points[tets, a] < 0.0
    crossed = above.any(axis=1) & below.any(axis=1)
    whole = np.flatnonzero(above.any(axis=1) & ~crossed)
    new, places, pieces, parents = {}, [], [], []

    def crossing(i, j):
        edge = (min(i, j), max(i, j))
        if edge not in new:
            new[edge] = len(points) + len(places)
            places.append(_cut(*points[list(edge)], a, curved.get(edge)))
        return new[edge]

    for t in np.flatnonzero(crossed):
        polygons = [_clipped_polygon(tets[t][face].tolist(), points[:, a], crossing) for face in FACES]
        split = _tetrahedra([polygon for polygon in polygons if len(polygon) > 2])
        pieces += split
        parents += [t] * len(split)
    points = np.vstack([points, *places]) if places else points
    tets = np.vstack([tets[whole], np.array(pieces, np.int64).reshape(-1, 4)])
    return points, tets, np.concatenate([whole, np.array(parents, np.int64)]), {c: edge for edge, c in new.items()}


def _smooth_edges(mesh, height):
    """{(i, j): normals (2, 3) at its ends} of the smooth edges of the contact surface from one side to the other."""
    found = {}
    crossed = (height[mesh.contact] > 0.0).any(axis=1) & (height[mesh.contact] < 0.0).any(axis=1)
    for triangle, normals in zip(mesh.contact[crossed].tolist(), mesh.normals[crossed]):
        for k, m in ((0, 1), (1, 2), (2, 0)):
            if height[triangle[k]] * height[triangle[m]] < 0.0:
                k, m = (k, m) if triangle[k] < triangle[m] else (m, k)
                found.setdefault((triangle[k], triangle[m]), []).append(normals[[k, m]])
    return {edge: sides[0] for edge, sides in found.items()
            if len(sides) == 2 and np.abs(sides[0] - sides[1]).max() < SMOOTH}


def _cut(p, q, a, normals):
    """Point (3,) of the edge from p to q at coordinate `a` = 0; normals (2, 3) at its ends, None of a straight edge."""
    d, share = q - p, p[a] / (p[a] - q[a])
    place = p + share * d
    if normals is not None:
        middle = normals.sum(axis=0) / np.linalg.norm(normals.sum(axis=0))
        bulge = 0.5 * share * (1.0 - share) * (normals[1] - normals[0]) @ d * middle
        if abs(bulge[a]) < UPRIGHT * abs(d[a]):
            place += bulge - bulge[a] / d[a] * d
    place[a] = 0.0
    return place


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


def _former(mesh, contact, cuts):
    """Number (t,) of the triangle of the contact surface of `mesh` that each of the triangles `contact` (t, 3) is part
    of, -1 of none; cuts: {number of a new point: the ends of its edge}."""
    number = {tuple(sorted(triangle)): k for k, triangle in enumerate(mesh.contact.tolist())}
    nodes = ({node for corner in corners for node in cuts.get(corner, (corner,))} for corners in contact.tolist())
    return np.array([number.get(tuple(sorted(found)), -1) for found in nodes], np.int64)


def _normals(mesh, contact, cuts, former, a):
    """Normals (t, 3, 3) at the corners of the triangles `contact` (t, 3) that are left: those of the `former` triangles
    (t,) of `mesh` that they are part of. At corners from `cuts` they lie between those at the ends of the edge, and in
    the plane where the surface crosses it nearly at right angles."""
    ends = np.array([cuts.get(node, (node, node)) for node in contact.ravel().tolist()]).reshape(-1, 3, 2)
    normals = np.full((*contact.shape, 3), np.nan)
    for t in np.flatnonzero(former >= 0):
        of = dict(zip(mesh.contact[former[t]].tolist(), mesh.normals[former[t]]))
        between = np.array([of[i] + of[j] for i, j in ends[t].tolist()])
        normals[t] = between / np.linalg.norm(between, axis=1, keepdims=True)
    upright = np.isin(contact, list(cuts)) & (np.abs(normals[:, :, a]) < UPRIGHT)
    normals[upright, a] = 0.0
    normals[upright] /= np.linalg.norm(normals[upright], axis=1, keepdims=True)
    return normals
