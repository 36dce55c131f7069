"""The surface between the faces of a body that have drawn back from its sharp edges (`hybrid.body.rounded`).

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
Where the body is cut, what goes around a corner in the plane of the cut is closed as if its mirror image went on.
"""

import numpy as np

from hybrid.body.smooth import CREASE, rim_edges, unit
from hybrid.body.surface import build_surface

PARTS = 4       # of a parabola
FLAT = 1e-6     # of the size of a body: distance from the plane of a cut that is none


def ends_of(split, edges):
    """Vertices (2, e, 2) after the split at the start and the end of every edge, on its first and on its second side."""
    (t, other), (k, j) = edges.triangle.T, edges.number.T
    return np.array([[split[t, k], split[other, (j + 1) % 3]],
                     [split[t, (k + 1) % 3], split[other, j]]]).swapaxes(1, 2)


def away_from(surface):
    """Unit vectors (t, 3, 3) in the triangles, away from their edges."""
    corners = surface.vertices[surface.triangles]
    return unit(np.cross(surface.normals[:, None], np.roll(corners, -1, axis=1) - corners))


def cuts_of(surface):
    """(Distance [m] that counts as none, [(axis, coordinate [m])] of the planes in which the rim of a cut lies)."""
    t, k = rim_edges(surface.triangles)
    first, last = surface.vertices[surface.triangles[t, k]], surface.vertices[surface.triangles[t, (k + 1) % 3]]
    flat, found, left = FLAT * np.ptp(surface.vertices, axis=0).max(), [], np.ones(len(t), bool)
    while left.any():       # the plane with most of what is left of the rim
        lies = [(axis, at, left & (np.abs(np.stack([first, last])[..., axis] - at) < flat).all(axis=0))
                for axis in range(3) for at in np.unique(first[left, axis].round(9))]
        axis, at, inside = max(lies, key=lambda each: np.count_nonzero(each[2]))
        if not inside.any():
            break
        found, left = [*found, (axis, at)], left & ~inside
    return flat, found


class Skin:
    """Vertices, their normals, and triangles of the rounded body: first those of the faces, then those between them."""

    def __init__(self, surface, split, moved, edges):
        self.faces, self.face_normals = split, surface.corner_normals
        self.points, self.triangles = list(moved), []
        normals = np.zeros_like(moved)
        np.add.at(normals, split, self.face_normals)
        self.normals = list(unit(normals))
        self.edges, self.ends = edges, ends_of(split, edges)
        self.flat, self.cuts = cuts_of(surface)
        self.meeting, self.direction = self._tangents(surface, moved)
        self.curves, self.curvature = {}, {}
        self.arcs = self._arcs(surface)

    def _tangents(self, surface, moved):
        """By pair of vertices: Q, and the direction of the edge, means over the edges that end there."""
        meeting, direction, away = {}, {}, away_from(surface)
        start, end = surface.vertices[surface.triangles[self.edges.triangle[:, 0], self.edges.number[:, 0]]], (
            surface.vertices[surface.triangles[self.edges.triangle[:, 0], (self.edges.number[:, 0] + 1) % 3]])
        begin = self.edges.inset[..., None] * away[self.edges.triangle, self.edges.number]
        in_cut = np.array([np.abs(moved[:, axis] - at) < self.flat for axis, at in self.cuts]).reshape(-1, len(moved))
        for ends, last in zip(self.ends, (start, end)):
            # in the plane of a cut, which the edge may meet at an angle, vertices have moved along the edge as well
            on_edge = np.where(in_cut[:, ends].all(axis=2).any(axis=0)[:, None], last, (moved[ends] - begin).mean(axis=1))
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
            planes = self._planes(loop)
            if planes is not None:
                self._cover(loop, planes)
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
        starts = [i for i in following if i not in set(following.values())]     # of those that are not closed
        while following:
            loop = [starts.pop() if starts else next(iter(following))]
            while loop[-1] in following:
                loop.append(following.pop(loop[-1]))
            yield loop

    def _planes(self, loop):
        """Axes of the planes of cuts from one to the other of which a loop goes around a corner in them: none of a closed
        one. None of a parabola in a plane, which is the rim of a cut."""
        if loop[0] == loop[-1]:
            return ()
        places = np.array([self.points[i] for i in loop])
        planes = {axis for axis, at in self.cuts for end in (places[0], places[-1]) if abs(end[axis] - at) < self.flat}
        inside = any(np.abs(places[:, axis] - places[0, axis]).max() < self.flat for axis in planes)
        return None if inside or not planes else tuple(planes)

    def _cover(self, loop, planes):
        """Triangles from a loop of parabolas to a point between them, the middle of the quadratic patch over the loop, whose
        tangents there are those of the polygon of the means of X, Q before and Q after it; planes: axes of the cuts in
        which this is, across which the loop goes on as its mirror image."""
        pairs = [pair for pair, curve in self.curves.items() if curve[1] in loop]
        ends = [i for i in dict.fromkeys(loop) if any(i in pair for pair in pairs)]
        around = np.array([np.mean([self.points[i], *(self.meeting[pair] for pair in pairs if i in pair)], axis=0)
                           for i in ends])
        middle, last = around.mean(axis=0), len(around) - bool(planes)
        for axis, at in self.cuts:
            middle[axis] = at if axis in planes else middle[axis]
        normal = np.sum(np.cross(around - middle, np.roll(around, -1, axis=0) - middle)[:last], axis=0)
        normal = unit(np.where(np.isin(np.arange(3), planes), 0.0, normal))
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
