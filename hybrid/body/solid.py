"""Tetrahedra of one solid and the groups of its surface: orientation and checks.

| field          | what                                                     | shape  | unit |
|----------------|----------------------------------------------------------|--------|------|
| points         | nodes of the tetrahedra, in the geometry's coordinates   | (n, 3) | m    |
| tets           | corners of each tetrahedron, positively oriented         | (m, 4) | -    |
| contact        | triangles the soil may touch, counter-clockwise outside  | (t, 3) | -    |
| normals        | of the geometry at the corners of these, outward; nan or | (t,3,3)| -    |
|                | None where it has none                                   |        |      |
| symmetry       | triangles of the cut face, counter-clockwise outside     | (s, 3) | -    |
| named_points   | name -> coordinates                                      | (3,)   | m    |
| regions        | names of the physical volumes that share the tetrahedra  | -      | -    |
| region         | number in `regions` of the one of each tetrahedron; None | (m,)   | -    |
|                | where the volumes have no names                          |        |      |
| parts          | names of the physical surfaces that share `contact`      | -      | -    |
| part           | number in `parts` of the one of each triangle; None      | (t,)   | -    |
|                | where the surfaces have no names                         |        |      |
"""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from hybrid.body.smooth import area_vectors, corner_normals, unit
from hybrid.runtime.errors import GeometryError

FLAT = 1e-12  # volume over cubed longest edge at or below which a tetrahedron counts as flat
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
    normals: np.ndarray | None = None
    regions: tuple[str, ...] = ()
    region: np.ndarray | None = None
    parts: tuple[str, ...] = ()
    part: np.ndarray | None = None

    def region_volumes(self):
        """{name of a physical volume: its volume [m³]}."""
        volumes = signed_volumes(self.points, self.tets)
        return dict(zip(self.regions, np.bincount(self.region, volumes, len(self.regions)).tolist()))


def boundary_faces(tets):
    """Faces (b, 3) that belong to one tetrahedron only, seen counter-clockwise from outside.

    Raises GeometryError when more than two tetrahedra share a face.
    """
    faces, n = tets[:, FACES].reshape(-1, 3), tets.max(initial=0) + 1
    low, middle, high = np.sort(faces, axis=1).astype(np.int64).T
    _, first, count = np.unique((low * n + middle) * n + high, return_index=True, return_counts=True)
    if count.max() > 2:
        bad = faces[first[np.argmax(count)]]
        raise GeometryError(f"{count.max()} tetrahedra share the face of nodes {bad.tolist()}, but at most 2 can; "
                            "remove tetrahedra that are there twice")
    return faces[first[count == 1]]


def owners(mesh):
    """Number (t,) of the tetrahedron under each contact triangle."""
    faces = np.sort(mesh.tets[:, FACES].reshape(-1, 3), axis=1).tolist()
    of = {tuple(face): k // 4 for k, face in enumerate(faces)}
    return np.array([of[face] for face in map(tuple, np.sort(mesh.contact, axis=1).tolist())], np.int64)


def oriented(mesh):
    """The mesh with those of its contact and symmetry triangles that lie on the boundary oriented outward."""
    outward = {tuple(sorted(face)): face for face in boundary_faces(mesh.tets).tolist()}

    def orient(triangles):
        oriented_triangles = [outward.get(tuple(sorted(t)), t) for t in triangles.tolist()]
        return np.array(oriented_triangles, dtype=np.int64).reshape(-1, 3)

    contact, normals = orient(mesh.contact), mesh.normals
    if normals is not None:
        place = (mesh.contact[:, None, :] == contact[:, :, None]).argmax(axis=2)    # of each corner, before
        normals = np.take_along_axis(normals, place[:, :, None], axis=1)
    return replace(mesh, contact=contact, normals=normals, symmetry=orient(mesh.symmetry))


def smoothed(mesh):
    """The mesh with outward normals of the smooth surface at all corners of its contact triangles."""
    symmetry = None
    if len(mesh.symmetry):
        symmetry = unit(area_vectors(mesh.points[mesh.symmetry]).sum(axis=0))
    return replace(mesh, normals=corner_normals(mesh.points, mesh.contact, mesh.normals, symmetry))


def signed_volumes(points, tets):
    """Signed volumes (m,) [m³]; positive when corner 3 is on the side that the triangle 0, 1, 2 faces."""
    a, b, c, d = (points[tets[:, k]] for k in range(4))
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6.0


def moments(points, tets):
    """(4, 4) ∫ X Xᵀ dV of tetrahedra, with X = (1, x, y, z) [m]."""
    corners = np.concatenate([np.ones((*tets.shape, 1)), points[tets]], axis=2)
    total = corners.sum(axis=1)
    each = np.einsum("tki,tkj->tij", corners, corners) + total[:, :, None] * total[:, None]
    return np.tensordot(signed_volumes(points, tets) / 20.0, each, axes=1)


def validate(mesh):
    """Raise GeometryError unless `mesh` is one closed, correctly oriented solid covered by its groups."""
    places = dict(enumerate(mesh.points)) | {f"'{name}'": point for name, point in mesh.named_points.items()}
    for name, point in places.items():
        if not np.isfinite(point).all():
            raise GeometryError(f"{label(mesh)}: point {name} has coordinates {point.tolist()}, not finite numbers")
    if not len(mesh.tets):
        raise GeometryError(f"{label(mesh)} has no volume elements: mesh it in three dimensions")
    check_volumes(mesh)
    check_pieces(mesh)
    boundary = boundary_faces(mesh.tets)
    check_watertight(mesh, boundary)
    check_edges(mesh, boundary)
    check_flat(mesh)


def label(mesh):
    return f"geometry '{mesh.name}'" if mesh.name else "geometry"


def middle(corners):
    """Text of the mean of points (., 3) [m], for messages."""
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
            f"first, number {k}, has a {kind} one of {volumes[k]:.3g} m³, at {middle(corners[k])}; "
            "try another size, or repair the geometry there"
        )


def check_pieces(mesh):
    """Solids that overlap without being fused are meshed separately, and the overlap would be counted twice."""
    n = len(mesh.points)
    first, second = mesh.tets[:, [0, 0, 0]].ravel(), mesh.tets[:, 1:].ravel()
    joined = coo_matrix((np.ones(len(first)), (first, second)), shape=(n, n))
    piece = connected_components(joined, directed=False)[1]
    pieces = len(np.unique(piece[mesh.tets[:, 0]]))
    if pieces > 1:
        raise GeometryError(f"{label(mesh)} is in {pieces} pieces, but a body is one solid: fuse with BooleanUnion, or "
                            "with BooleanFragments where the parts differ in density")


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
            f"boundary, {twice} are listed twice; the first at {middle(mesh.points[list(bad)])}; "
            "every outer face belongs to exactly one of the two groups"
        )
    inward = sum(not same_orientation(t, wanted[key]) for t, key in zip(grouped, given))
    if inward:
        raise GeometryError(f"{label(mesh)}: {inward} surface triangles face inward: use oriented()")


def same_orientation(a, b):
    """Whether two triangles of the same nodes have the same sense of rotation."""
    k = b.index(a[0])
    return a[1] == b[(k + 1) % 3]


def check_edges(mesh, boundary):
    edges = np.sort(boundary[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    unique, count = np.unique(edges, axis=0, return_counts=True)
    bad = np.flatnonzero(count != 2)
    if len(bad):
        raise GeometryError(
            f"{label(mesh)} is not watertight: {len(bad)} edges of its surface join other than two "
            f"triangles; the first joins {count[bad[0]]} at {middle(mesh.points[unique[bad[0]]])}; "
            "parts must not touch along an edge only"
        )


def check_flat(mesh):
    """The cut face must be plane, because the model is mirrored in it."""
    if not len(mesh.symmetry):
        return
    points = mesh.points[np.unique(mesh.symmetry)]
    spread = points - points.mean(axis=0)
    out_of_plane = np.abs(spread @ np.linalg.svd(spread, full_matrices=False)[2][-1]).max()
    if out_of_plane > 1e-6 * np.abs(spread).max():
        raise GeometryError(
            f"{label(mesh)}: nodes of the physical surface 'symmetry' are up to {out_of_plane:.3g} m off its mean plane; "
            "a symmetry surface is one plane: put only the cut face into this group. For a quarter model draw the whole "
            "body without this group, with its middle at the corner of the grid: it is cut by itself"
        )
