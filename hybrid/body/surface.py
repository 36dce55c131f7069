"""Contact surface of a rigid body: closest point, signed gap and normal, in the body frame.

    closest point  y_s(y) = argmin |y - x| over the triangles, found in a tree of bounding boxes
    gap            g = ± |y - y_s|, negative inside: the sign is that of (y - y_s)·n̂
    normal         N = (y - y_s)/g = ∂g/∂y
    derivative     G = ∂N/∂y = 0 on a face, (I - e e^T - N N^T)/g on an edge, (I - N N^T)/g at a vertex

Where the body is curved, triangles carry curved patches between the normals of its surface at their corners, and gap,
normal and G are those of the patches (`hybrid.body.patches`; the normals are those of `hybrid.body.smooth`).

| symbol | meaning                                                     | shape     | unit |
|--------|-------------------------------------------------------------|-----------|------|
| y      | query point, from the centre of mass                        | (3,)      | m    |
| y_s    | closest point of the surface                                | (3,)      | m    |
| n̂      | pseudo-normal of a feature: of the face, of an edge (mean   | (t, 7, 3) | -    |
|        | of its faces), of a vertex (mean weighted by face angles)   |           |      |
| e      | direction of an edge                                        | (t, 7, 3) | -    |

Features of triangle (v0, v1, v2): 0 face; 1, 2, 3 edge v0v1, v1v2, v2v0; 4, 5, 6 vertex v0, v1, v2. What
matters to contact is the shape, not its triangulation: an edge between coplanar triangles, and a vertex with
only such edges, count as face, because there the closest point slides freely. A vertex along a straight edge keeps its
number but has that edge's direction; at a true corner e = 0, and A = I - e e^T = I.

Triangles and tree never change; rotating the body is rotating y. The surface may be open: the edge of a cut
has the normal of its one triangle.

Sources: J. A. Baerentzen and H. Aanaes, IEEE Trans. Vis. Comput. Graph. 11 (2005) 243-253 (sign by
pseudo-normals); C. Ericson, Real-Time Collision Detection (2005), sec. 5.1.5 (regions of a triangle).
"""

from dataclasses import dataclass

import numpy as np

from hybrid.body.facet_tree import SECOND, Tree
from hybrid.body.smooth import area_vectors, build_patches
from hybrid.runtime.errors import GeometryError

LEAF = 4               # triangles in a leaf of the tree, at most
STRAIGHT = 0.02        # sine of the angle between a prism's surface and its axis
FLAT = 1e-6            # two directions closer than this [rad] are the same
DEGENERATE = 1e-6      # smallest (twice area)/(longest edge)²; its square must stand out of round-off


@dataclass(frozen=True)
class ContactSurface:
    """Oriented triangles with their pseudo-normals; lengths in m, body frame, about the centre of mass.

    vertices (V, 3); triangles (t, 3) counter-clockwise seen from outside; normals (t, 3); lower, upper (3,) bounds;
    radius [m] of a ball about the centre of mass around it. The bounds and the ball include what patches stand out of the
    facets.
    """

    vertices: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    radius: float
    tree: Tree

    @property
    def areas(self):
        """(t,) [m²] of the triangles."""
        return np.linalg.norm(area_vectors(self.vertices[self.triangles]), axis=1)

    @property
    def curved(self):
        """Whether each triangle (t,) carries a curved patch."""
        return self.tree.kind[:, SECOND] == 1

    @property
    def turning(self):
        """Whether the normal turns on each triangle (t,). A curved patch may lie in a plane, up to the round rim of it."""
        cosine = np.einsum("tki,ti->tk", self.corner_normals, self.normals).min(axis=1)
        return self.curved & (cosine < 1.0 - FLAT**2)

    @property
    def corner_normals(self):
        """Normals (t, 3, 3) of the surface at the corners of its triangles."""
        nodes = self.tree.patches.nodes
        if not len(nodes):
            return np.repeat(self.normals[:, None], 3, axis=1)
        return nodes[:, [3, 3, 3]] + nodes[:, [3, 4, 5]] * np.array([0.0, 1.0, 1.0])[:, None]

    @property
    def curvature(self):
        """c (t, 3, 3) [m] of the edges v0v1, v1v2, v2v0, as in `hybrid.body.smooth`."""
        nodes = self.tree.patches.nodes
        return nodes[:, 6:] if len(nodes) else np.zeros((len(self.triangles), 3, 3))

    def extent(self, direction):
        """Largest product [m] of a point of the surface with `direction` (3,)."""
        flat, nodes = float((self.vertices @ direction).max()), self.tree.patches.nodes
        return max(flat, _extent(nodes @ direction)) if len(nodes) else flat

    def is_prism(self, axis):
        """Whether all sections across the unit vector `axis` (3,) are equal: faces are along it or across it."""
        nodes = self.tree.patches.nodes
        slope = np.abs((nodes[:, 3] if len(nodes) else self.normals) @ axis)
        return not ((slope > STRAIGHT) & (slope < 1 - STRAIGHT)).any()


def build_surface(vertices, triangles, corner_normals=None, curvature=None):
    """ContactSurface of `triangles` (t, 3) int into `vertices` (n, 3) [m]; unused vertices are dropped.

    corner_normals: (t, 3, 3) outward unit normals, at the corners of the triangles, of the smooth surface that these
    approximate (body.smooth.corner_normals); None: the triangles are the surface.
    curvature: (t, 3, 3) [m] c of their edges v0v1, v1v2, v2v0 (body.smooth), nan where it follows from the normals; None:
    everywhere.

    Triangles are connected where they share vertex numbers, so coinciding vertices must have been merged. Raises
    GeometryError for no triangles, coordinates that are not finite, numbers out of range, a triangle
    without area, an edge of more than two triangles, or neighbours of opposite orientation.
    """
    vertices = np.asarray(vertices, dtype=float)
    triangles = np.asarray(triangles, dtype=np.int64)
    _check_arrays(vertices, triangles)
    used, compact = np.unique(triangles, return_inverse=True)
    vertices, triangles = vertices[used], compact.reshape(-1, 3)

    corners = vertices[triangles]
    normals = _face_normals(corners)
    edges = np.roll(corners, -1, axis=1) - corners
    edges /= np.linalg.norm(edges, axis=2)[:, :, None]
    edge_normals, sharp = _edge_normals(triangles, normals)
    vertex_normals = _vertex_normals(triangles, normals, edges, len(vertices))
    creases, corner_kind = _creases(triangles, edges, sharp, len(vertices))

    none, face = np.zeros((len(triangles), 1)), normals[:, None]
    patches, curved = build_patches(corners, triangles, normals, corner_normals, curvature)
    tree = _build_tree(corners, normals)._replace(
        normals=np.concatenate((face, edge_normals, vertex_normals, face, 0 * face, edges, creases, 0 * face), axis=1),
        kind=np.hstack((none, sharp, 2 * corner_kind, none, curved, none)).astype(np.int64), patches=patches,
    )
    hull = np.vstack((vertices, _control_points(tree.patches.nodes)))
    return ContactSurface(vertices, triangles, normals, hull.min(axis=0), hull.max(axis=0),
                          float(np.linalg.norm(hull, axis=1).max()), tree)


def _control_points(nodes):
    """Points (3 t, 3) of the edges' quadratic curves whose hull, with the vertices, contains the patches."""
    start, d = nodes[:, [0, 0, 0]], nodes[:, 1:3]
    ends = np.stack((d[:, 0], d[:, 0] + d[:, 1], d[:, 1]), axis=1)
    return (start + 0.5 * (ends - nodes[:, 6:])).reshape(-1, 3)


def _extent(nodes):
    """Largest value of the quadratic functions over the triangles with `nodes` (t, 9), components of Patches.nodes."""
    x, p, q, _, _, _, a, b, c = nodes.T
    # x + p v + q w - u v a - v w b - w u c, u = 1 - v - w, is stationary inside where H (v, w) = -slope
    slope_v, slope_w = p - a, q - c
    H_vv, H_ww, H_vw = 2 * a, 2 * c, a + c - b
    D = H_vv * H_ww - H_vw**2
    D = np.where(D == 0.0, np.inf, D)
    v, w = (H_vw * slope_w - H_ww * slope_v) / D, (H_vw * slope_v - H_vv * slope_w) / D
    inside = (v > 0.0) & (w > 0.0) & (v + w < 1.0)
    values = [np.where(inside, x + 0.5 * (slope_v * v + slope_w * w), -np.inf)]
    for start, d, curvature in ((x, p, a), (x + p, q - p, b), (x + q, -q, c)):
        s = np.clip(0.5 - 0.5 * d / np.where(curvature == 0.0, np.inf, curvature), 0.0, 1.0)
        values.append(start + s * d - s * (1 - s) * curvature)
    return float(np.max(values))


def _check_arrays(vertices, triangles):
    if triangles.ndim != 2 or triangles.shape[1] != 3 or len(triangles) == 0:
        raise GeometryError(
            f"contact surface: triangles have shape {triangles.shape}, expected (t, 3) with t > 0; "
            'put at least one surface into the physical group "contact"')
    if vertices.ndim != 2 or vertices.shape[1] != 3 or not np.isfinite(vertices).all():
        raise GeometryError(
            f"contact surface: vertices of shape {vertices.shape} must be finite numbers of shape (n, 3); "
            "check the parameters of the geometry")
    if triangles.min() < 0 or triangles.max() >= len(vertices):
        raise GeometryError(
            f"contact surface: vertex numbers run from {triangles.min()} to {triangles.max()}, but there are "
            f"{len(vertices)} vertices, numbered from 0; pass the vertices the triangles refer to")


def _face_normals(corners):
    """Unit normals (t, 3) of `corners` (t, 3, 3), refusing triangles without area."""
    normals = area_vectors(corners)
    area = np.linalg.norm(normals, axis=1)
    longest = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max(axis=1)
    bad = np.flatnonzero(~(area > DEGENERATE / 2 * longest**2))
    if len(bad):
        k = bad[0]
        raise GeometryError(
            f"contact surface: {len(bad)} triangle(s) without area, first number {k} with area "
            f"{area[k]:g} m² near {corners[k].mean(axis=0).tolist()} (limit "
            f"{DEGENERATE / 2 * longest[k]**2:g} m² for its longest edge of {longest[k]:g} m); "
            "change the mesh size or remove slivers from the geometry")
    return normals / area[:, None]


def _edge_normals(triangles, normals):
    """Pseudo-normals (t, 3, 3) of the edges, and whether each is sharp or the rim of a cut, (t, 3) bool."""
    ends = np.stack((triangles, np.roll(triangles, -1, axis=1)), axis=2).reshape(-1, 2)
    _, edge, sharing = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True, return_counts=True)
    edge = edge.reshape(-1)
    forward = np.bincount(edge, weights=np.where(ends[:, 0] < ends[:, 1], 1, -1))
    if (sharing > 2).any():
        a, b = ends[np.flatnonzero(sharing[edge] > 2)[0]]
        raise GeometryError(
            f"contact surface: edge ({a}, {b}) belongs to {sharing.max()} triangles, the limit is 2: inside "
            "and outside are not defined there; fuse or separate the solids that touch along that edge")
    wrong = np.flatnonzero((sharing == 2) & (forward != 0))
    if len(wrong):
        a, b = ends[np.flatnonzero(edge == wrong[0])[0]]
        raise GeometryError(
            f"contact surface: the triangles at {len(wrong)} edge(s), first ({a}, {b}), are oriented against "
            "each other; orient all counter-clockwise seen from outside")

    face_normal = np.repeat(normals, 3, axis=0)
    total = np.zeros((len(sharing), 3))
    np.add.at(total, edge, face_normal)
    # sine of the angle to the edge's normal; where two faces lie on each other it is 0, but there the sum vanishes
    sine = np.linalg.norm(np.cross(face_normal, total[edge]), axis=1)
    length = np.linalg.norm(total, axis=1)[edge]
    if (length < FLAT).any():
        a, b = ends[np.argmin(length)]
        raise GeometryError(
            f"contact surface: its two triangles at edge ({a}, {b}) lie on each other (limit {FLAT:g} rad "
            "between them), so the body has no thickness there; give the body a thickness at that edge")
    sharp = (sine > FLAT) | (sharing[edge] == 1) | (length < 1.0)
    return (total[edge] / length[:, None]).reshape(-1, 3, 3), sharp.reshape(-1, 3)


def _vertex_normals(triangles, normals, edges, count):
    """Pseudo-normals (t, 3, 3) of the vertices: face normals weighted by the angle of the face there."""
    cosine = -np.einsum("tki,tki->tk", edges, np.roll(edges, 1, axis=1))
    sine = np.linalg.norm(np.cross(edges, np.roll(edges, 1, axis=1)), axis=2)
    weighted = np.arctan2(sine, cosine)[:, :, None] * normals[:, None]
    total = np.zeros((count, 3))
    np.add.at(total, triangles.ravel(), weighted.reshape(-1, 3))
    # the sum can only vanish at a saddle, a vertex that is the closest one of no other point
    return (total / np.maximum(np.linalg.norm(total, axis=1), FLAT)[:, None])[triangles]


def _creases(triangles, edges, sharp, count):
    """Direction (t, 3, 3) of the straight edge through each vertex, 0 if none, and (t, 3) 0 flat, 1 not."""
    # of each triangle, the two edges that leave each of its vertices
    leaving = np.stack((edges, -np.roll(edges, 1, axis=1)), axis=2)
    is_sharp = np.stack((sharp, np.roll(sharp, 1, axis=1)), axis=2)
    out_of = np.repeat(triangles[:, :, None], 2, axis=2)[is_sharp]
    into = np.stack((np.roll(triangles, -1, axis=1), np.roll(triangles, 1, axis=1)), axis=2)[is_sharp]
    # once per edge, not once per face
    _, single = np.unique(np.stack((out_of, into), axis=1), axis=0, return_index=True)
    out_of, direction = out_of[single], leaving[is_sharp][single]

    edges_at = np.bincount(out_of, minlength=count)
    one = np.zeros((count, 3))
    one[out_of] = direction
    bend = np.zeros((count, 3))
    np.add.at(bend, out_of, direction)   # opposite directions cancel
    straight = (edges_at == 2) & (np.linalg.norm(bend, axis=1) < FLAT)
    return np.where(straight[:, None], one, 0.0)[triangles], (edges_at > 0)[triangles]


def _build_tree(corners, face):
    """Halve the triangles at the median centroid along the longest axis until LEAF or fewer remain."""
    leaves = 1
    while leaves * LEAF < len(corners):
        leaves *= 2
    centroids, lower, upper = corners.mean(axis=1), corners.min(axis=1), corners.max(axis=1)
    members = [None, np.arange(len(corners))]
    for node in range(1, leaves):
        inside = members[node]
        axis = np.argmax(np.ptp(centroids[inside], axis=0))
        inside = inside[np.argsort(centroids[inside, axis], kind="stable")]
        members += [np.sort(inside[: len(inside) // 2]), np.sort(inside[len(inside) // 2:])]
    boxes = np.zeros((2 * leaves, 6))
    for node in range(1, 2 * leaves):
        boxes[node] = np.hstack((lower[members[node]].min(axis=0), upper[members[node]].max(axis=0)))
    order = np.concatenate(members[leaves:])
    first = np.cumsum([0] + [len(leaf) for leaf in members[leaves:]])
    v0, v1, v2 = (corners[order, k] for k in range(3))
    return Tree(boxes, first, order, np.hstack((v0, v1 - v0, v2 - v0, face[order])), None, None, None)
