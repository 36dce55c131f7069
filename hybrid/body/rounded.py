"""A body with its sharp edges rounded off: the surface that soil which deforms is in contact with.

Every vertex on a sharp edge is split into one for each of the faces that meet there. These move into their faces until they
are the inset d away from the edge, and the other vertices of a face follow as in a stretched skin:

    min Σ w_ij |u_i - u_j|²      w_ij cotangent weights
    u·N = 0                      on the face
    u·m = d, 0                   beside a sharp edge, on the rim of a cut; m in the face, away from the edge

Between the two vertices X_1, X_2 that one of an edge became, the body is closed by a parabola with the tangents of both
faces, which begin on the edge, at Q:

    x(s) = (1 - s)² X_1 + 2 s (1 - s) Q + s² X_2

Its parts carry curved patches (`hybrid.body.patches`), so the normal is continuous from face to face. Where several edges
meet, triangles around a point between them close the body. Where a single edge ends, its last vertex stays one.

The patches have the curvatures of the surface that parabolas sweep along the edge. Those that follow from the normals alone
stand out of a plane face whose edge is curved, because they take the arc along the edge for one across the face. With d from
end to end, c_0 and d_0 of the edge itself, a and b its start and its end, and 0 and 1 two steps of the parabola,

    along the edge    c = |d|/|d_0| c_0, and along N_a + N_b what its tangent planes want (`hybrid.body.smooth`)
    across            c = (X_1 - 2 Q + X_2)/PARTS²
    b_0 to a_1        c = mean of c across at a, b + mean of c along at 0, 1 + (b_0 + a_1 - a_0 - b_1)/2

The height over a plane face is then s² times that of the parabola's end, and nowhere below it.
"""

import numpy as np
from scipy.sparse import coo_matrix, diags, identity, kron
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import spsolve

from hybrid.body.closest import closest
from hybrid.body.smooth import CREASE, shared_edges, unit
from hybrid.body.surface import build_surface

PARTS = 4                       # of a parabola
CONDITION, FREE = 1e9, 1e-9     # weights of conditions, and of no displacement where nothing else determines it, beside 1
OBTUSE = 0.05                   # smallest cotangent: an obtuse triangle would have negative weights
FOLDED = 1e-4                   # (twice area)/(longest edge)² at which a triangle counts as folded over
SMALLER, TRIES = 0.7, 12        # factor on all insets as long as a triangle folds


def round_off(surface, edges):
    """ContactSurface of a body with the SharpEdges `edges` of its `surface` rounded off; the surface as it is, if its
    triangles fold however small the insets are."""
    split, origin = _split(surface.triangles, edges)
    for _ in range(TRIES if len(edges.triangle) else 0):
        moved = _onto(surface, surface.vertices[origin] + _displacements(surface, split, edges), split)
        if not _folded(moved[split], surface.normals).any():
            return _Skin(surface, split, moved, edges).close()
        edges = edges._replace(inset=SMALLER * edges.inset)
    return surface


def _split(triangles, edges):
    """Vertex (t, 3) after the split at every corner of the triangles, and the vertex (n,) that each was before."""
    (t, other), (k, j) = (side.T for side in shared_edges(triangles))
    sharp = np.zeros(triangles.shape, bool)
    sharp[edges.triangle, edges.number] = True
    t, k, other, j = (values[~sharp[t, k]] for values in (t, k, other, j))
    first = np.concatenate([3 * t + k, 3 * t + (k + 1) % 3])
    second = np.concatenate([3 * other + (j + 1) % 3, 3 * other + j])
    links = coo_matrix((np.ones(len(first)), (first, second)), shape=(triangles.size,) * 2)
    split = connected_components(links, directed=False)[1].reshape(-1, 3)
    origin = np.zeros(split.max() + 1, int)
    origin[split] = triangles
    return split, origin


def _ends(split, edges):
    """Vertices (2, e, 2) after the split at the start and the end of every edge, on its first and on its second side."""
    (t, other), (k, j) = edges.triangle.T, edges.number.T
    return np.array([[split[t, k], split[other, (j + 1) % 3]],
                     [split[t, (k + 1) % 3], split[other, j]]]).swapaxes(1, 2)


def _rim_edges(surface):
    """(triangles (r,), numbers (r,)) of the edges that only one triangle has: the rim of a cut."""
    rim = np.ones(surface.triangles.shape, bool)
    rim[shared_edges(surface.triangles)] = False
    return np.nonzero(rim)


def _rim(surface, split):
    """(n,) bool, vertices after the split on the rim of a cut."""
    t, k = _rim_edges(surface)
    rim = np.zeros(split.max() + 1, bool)
    rim[split[t, k]] = rim[split[t, (k + 1) % 3]] = True
    return rim


def _displacements(surface, split, edges):
    """(n, 3) [m] of the vertices after the split."""
    count, away = split.max() + 1, _away(surface)
    rim = _rim_edges(surface)
    t, k = (np.concatenate([sharp.ravel(), cut]) for sharp, cut in zip((edges.triangle, edges.number), rim))
    inset = np.concatenate([edges.inset.ravel(), np.zeros(len(rim[0]))])
    vertex = np.concatenate([split.ravel(), split[t, k], split[t, (k + 1) % 3]])
    direction = np.concatenate([surface.corner_normals.reshape(-1, 3), away[t, k], away[t, k]])
    value = np.concatenate([np.zeros(split.size), inset, inset])
    start_end = _ends(split, edges)
    still = np.unique(start_end[start_end[..., 0] == start_end[..., 1]])
    stays = np.isin(vertex, still, invert=True)
    vertex = np.concatenate([vertex[stays], np.repeat(still, 3)])
    direction = np.concatenate([direction[stays], np.tile(np.eye(3), (len(still), 1))])
    value = np.concatenate([value[stays], np.zeros(3 * len(still))])
    row, column = np.repeat(np.arange(len(vertex)), 3), (3 * vertex[:, None] + np.arange(3)).ravel()
    conditions = coo_matrix((direction.ravel(), (row, column)), shape=(len(vertex), 3 * count)).tocsr()
    skin = kron(_laplacian(surface, split, count) + FREE * identity(count), identity(3))
    found = spsolve((skin + CONDITION * conditions.T @ conditions).tocsc(), CONDITION * conditions.T @ value)
    return found.reshape(-1, 3)


def _onto(surface, points, split):
    """Vertices after the split at `points` (n, 3) [m], on the tangent planes of the surface, moved onto it."""
    if not len(surface.tree.patches.nodes):
        return points
    normals = np.zeros_like(points)
    np.add.at(normals, split, surface.corner_normals)
    return np.array([closest(point, np.inf, surface.tree, tuple(side))[2] for point, side in zip(points, unit(normals))])


def _away(surface):
    """Unit vectors (t, 3, 3) in the triangles, away from their edges."""
    corners = surface.vertices[surface.triangles]
    return unit(np.cross(surface.normals[:, None], np.roll(corners, -1, axis=1) - corners))


def _laplacian(surface, split, count):
    """Σ w_ij |u_i - u_j|² as a matrix (count, count)."""
    corners = surface.vertices[surface.triangles]
    edge = np.roll(corners, -1, axis=1) - corners
    before = -np.roll(edge, 1, axis=1)                      # from each corner, its two edges
    sine = np.linalg.norm(np.cross(edge, before), axis=2)
    cotangent = np.maximum(np.einsum("tki,tki->tk", edge, before) / sine, OBTUSE)
    weight = np.roll(cotangent, -2, axis=1).ravel()         # of the corner opposite to each edge
    i, j = split.ravel(), np.roll(split, -1, axis=1).ravel()
    couplings = coo_matrix((weight, (i, j)), shape=(count, count))
    couplings = couplings + couplings.T
    return diags(np.asarray(couplings.sum(axis=1)).ravel()) - couplings


def _folded(corners, normals):
    """Which triangles (t,) with `corners` (t, 3, 3) have turned over, or nearly, from their `normals` (t, 3)."""
    twice = np.einsum("ti,ti->t", np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), normals)
    return twice < FOLDED * np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max(axis=1) ** 2


class _Skin:
    """Vertices, their normals, and triangles of the rounded body: first those of the faces, then those between them."""

    def __init__(self, surface, split, moved, edges):
        self.faces, self.face_normals = split, surface.corner_normals
        self.points, self.triangles = list(moved), []
        normals = np.zeros_like(moved)
        np.add.at(normals, split, self.face_normals)
        self.normals = list(unit(normals))
        self.edges, self.ends = edges, _ends(split, edges)
        self.meeting, self.direction = self._tangents(surface, moved)
        self.curves, self.curvature = {}, {}
        self.arcs = self._arcs(surface)

    def _tangents(self, surface, moved):
        """By pair of vertices: Q, and the direction of the edge, means over the edges that end there."""
        meeting, direction, away = {}, {}, _away(surface)
        start, end = surface.vertices[surface.triangles[self.edges.triangle[:, 0], self.edges.number[:, 0]]], (
            surface.vertices[surface.triangles[self.edges.triangle[:, 0], (self.edges.number[:, 0] + 1) % 3]])
        begin = self.edges.inset[..., None] * away[self.edges.triangle, self.edges.number]
        rim = _rim(surface, self.faces)
        for ends, last in zip(self.ends, (start, end)):
            # in the plane of a cut, which the edge may meet at an angle, vertices have moved along the edge as well
            on_edge = np.where(rim[ends].all(axis=1)[:, None], last, (moved[ends] - begin).mean(axis=1))
            for (a, b), q, along in zip(ends, on_edge, unit(end - start)):
                meeting.setdefault(_pair(a, b), []).append(q)
                direction.setdefault(_pair(a, b), []).append(along if a < b else -along)
        return ({pair: self._in_tangent_planes(pair, np.mean(found, axis=0)) for pair, found in meeting.items()},
                {pair: unit(np.sum(found, axis=0)) for pair, found in direction.items()})

    def _in_tangent_planes(self, pair, q):
        """Place nearest to q (3,) [m] in the tangent planes at a pair of vertices."""
        normals, places = (np.array([values[i] for i in pair]) for values in (self.normals, self.points))
        return q + np.linalg.lstsq(normals, np.einsum("ki,ki->k", normals, places - q), rcond=None)[0]

    def _arcs(self, surface):
        """Curvature (e, 3) of every edge, relative to its length."""
        t, k = self.edges.triangle[:, 0], self.edges.number[:, 0]
        start, end = surface.vertices[surface.triangles[t, k]], surface.vertices[surface.triangles[t, (k + 1) % 3]]
        return surface.curvature[t, k] / np.linalg.norm(end - start, axis=1)[:, None]

    def close(self):
        """ContactSurface of the whole."""
        for first, second, arc in zip(*self.ends, self.arcs):
            self._strip(self._curve(*first), self._curve(*second), arc)
        for loop in self._holes():
            self._cover(loop)
        triangles = np.array(self.triangles)
        return build_surface(np.array(self.points), np.concatenate([self.faces, triangles]),
                             np.concatenate([self.face_normals, np.array(self.normals)[triangles]]),
                             self._curvatures(np.concatenate([self.faces, triangles])))

    def _curvatures(self, triangles):
        """(t, 3, 3) of the edges of triangles, nan where it follows from the normals."""
        free = np.full(3, np.nan)
        return np.array([[self.curvature.get(_pair(t[k], t[(k + 1) % 3]), free) for k in range(3)]
                         for t in triangles.tolist()])

    def _curve(self, a, b):
        """Numbers (PARTS + 1,) of the points of the parabola from vertex a to b."""
        pair = _pair(a, b)
        if a == b:
            return [a] * (PARTS + 1)
        if pair not in self.curves:
            (one, two), q = (self.points[i] for i in pair), self.meeting[pair]
            outward, inner = self.normals[a] + self.normals[b], []
            for s in np.arange(1, PARTS) / PARTS:
                normal = unit(np.cross(self.direction[pair], (1 - s) * (q - one) + s * (two - q)))
                inner.append(self._add((1 - s)**2 * one + 2 * s * (1 - s) * q + s**2 * two,
                                       normal * np.sign(normal @ outward)))
            self.curves[pair] = [pair[0], *inner, pair[1]]
            for ends in zip(self.curves[pair][:-1], self.curves[pair][1:]):
                self.curvature[_pair(*ends)] = (one - 2 * q + two) / PARTS**2
        curve = self.curves[pair]
        return curve if curve[0] == a else curve[::-1]

    def _add(self, point, normal):
        self.points.append(point)
        self.normals.append(normal)
        return len(self.points) - 1

    def _triangle(self, *numbers):
        if len(set(numbers)) == 3:      # not at the end of an edge, where points coincide
            self.triangles.append(numbers)

    def _strip(self, a, b, arc):
        """Triangles between the parabolas at the start, a, and the end, b, of an edge of its first side; arc (3,): curvature
        of the edge relative to its length."""
        along = [self._along(*ends, arc) for ends in zip(a, b)]
        for ends, c in zip(zip(a, b), along):
            self.curvature[_pair(*ends)] = c
        for i in range(PARTS):
            self._triangle(b[i], a[i], a[i + 1])
            self._triangle(b[i], a[i + 1], b[i + 1])
            across = [self.curvature.get(_pair(*ends[i:i + 2]), np.zeros(3)) for ends in (a, b)]
            a0, a1, b0, b1 = (self.points[j] for j in (a[i], a[i + 1], b[i], b[i + 1]))
            self.curvature.setdefault(_pair(b[i], a[i + 1]),
                                      0.5 * (sum(across) + along[i] + along[i + 1] + b0 + a1 - a0 - b1))

    def _along(self, a, b, arc):
        """Curvature (3,) from vertex a to b, along an edge of the curvature `arc` (3,) relative to its length."""
        d = self.points[b] - self.points[a]
        c, total = np.linalg.norm(d) * arc, self.normals[a] + self.normals[b]
        wanted = (self.normals[a] - self.normals[b]) @ d - total @ c
        square = total @ total
        return c + wanted / square * total if square > CREASE**2 else c

    def _holes(self):
        """Closed loops of points that still have triangles on one side only, where edges meet."""
        triangles = np.concatenate([self.faces, np.array(self.triangles)])
        there = set(zip(triangles.ravel().tolist(), np.roll(triangles, -1, axis=1).ravel().tolist()))
        following = {}
        for curve in self.curves.values():
            for a, b in zip(curve[:-1], curve[1:]):
                following.update({x: y for x, y in ((a, b), (b, a)) if (x, y) not in there and (y, x) in there})
        while following:
            loop = [next(iter(following))]
            while loop[-1] in following:
                loop.append(following.pop(loop[-1]))
            if loop[0] == loop[-1]:     # else the rim of a cut
                yield loop

    def _cover(self, loop):
        """Triangles from a closed loop of parabolas to a point between them, the middle of the quadratic patch over the
        loop, whose tangents there are those of the polygon of the means of X, Q before and Q after it."""
        pairs = [pair for pair, curve in self.curves.items() if curve[1] in loop]
        ends = [i for i in loop[:-1] if any(i in pair for pair in pairs)]
        around = [np.mean([self.points[i], *(self.meeting[pair] for pair in pairs if i in pair)], axis=0) for i in ends]
        middle = np.mean(around, axis=0)
        normal = unit(np.sum(np.cross(np.array(around) - middle, np.roll(around, -1, axis=0) - middle), axis=0))
        number = self._add(middle, normal)
        for i in ends:
            self.curvature[_pair(i, number)] = _leaving(middle - self.points[i], self.normals[i], normal)
        for a, b in zip(loop[:-1], loop[1:]):
            self._triangle(a, b, number)


def _leaving(d, first, last):
    """Curvature (3,) over d (3,) [m] that lies in the tangent plane of the normal `first` (3,) at its start, however that of
    the normal `last` at its end is placed, and in this as far as CREASE lets it."""
    height, across = first @ d, unit(last - (first @ last) * first)
    sine = max(last @ across, CREASE)
    return height * first - (last @ d + height * (first @ last)) / sine * across


def _pair(a, b):
    return (a, b) if a < b else (b, a)
