"""Contact of a body beside its sharp edges with elastic soil: springs that are as soft there as the soil of a cell.

The displacement of the grid bends at nodes only, so that the rigid base of a body carries soil beyond its edges along: with
stiff springs up to the edge a strip is as stiff as one 0.36 to 0.5 cells wider on each side, by where the edge lies in its
cell. At a distance d from a sharp edge contact has

    1/p = 1/p_f + h/6 max(0, 1 - d/h)       h width of the smallest cells

Over converged finite elements (smooth strip on 8 cells, E = 10 MPa, ν = 0.3, under its weight, a load and a moment; rough
square on 6 cells in space), edges on a line of the grid, 1/4, 1/2 and 3/4 of a cell beside it:

    strip                              settlement                     rocking
    stiff up to the edge               1.03, 1.05, 1.08, 1.06         1.10, 1.17, 1.27, 1.21
    edges rounded off from h/2 on      1.01, 0.99, 0.96, 0.98         1.01, 0.97, 0.86, 0.93
    here                               1.01, 1.00, 1.01, 1.02         1.03, 1.00, 1.04, 1.06

    square                             settlement           torsion              rocking
    stiff up to the edge               1.08, 1.17, 1.25     1.18, 1.34, 1.46     1.17, 1.38, 1.56
    edges rounded off                  1.00, 0.93, 0.85     0.91, 0.82, 0.71     0.96, 0.83, 0.69
    here                               1.00, 1.00, 1.00     0.89, 0.88, 0.85     1.01, 1.01, 1.01

A body that tips is still held at its edge, where one that is rounded off has lost half a cell of its lever arm. Soil that
flows around edges, or comes to lie inside a body that slides along, needs rounded ones (`hybrid.body.rounded`).
"""

from typing import NamedTuple

import numpy as np

from hybrid.runtime.jit import njit

SOFT = 1 / 6        # of a cell: compression of the springs at an edge, over the pressure over E
PARTS = 4           # straight ones that stand for the edge of a triangle on a rim


class SoftEdges(NamedTuple):
    """Sharp edges with ends (e, 2, 3) [m] in the body frame; cell [m], the distance within which springs are softer;
    compliance [-], what an edge adds to that of a spring, over that of a spring far from edges."""

    ends: np.ndarray
    cell: float
    compliance: float

    def shares(self, points):
        """Stiffness (m,) [-] of points (m, 3) [m] in the body frame, over that far from edges."""
        near = 1.0 - _distance(points, self.ends) / self.cell
        return 1.0 / (1.0 + self.compliance * np.maximum(near, 0.0))


def soft_edges(ends, penalty, cell):
    """SoftEdges of a body with a `penalty` p_f [1/m] on cells of `cell` [m], its edges with ends (e, 2, 3) [m]; None without
    edges."""
    return SoftEdges(np.ascontiguousarray(ends), cell, SOFT * penalty * cell) if len(ends) else None


def ends_of(surface, edges):
    """Ends (p, 2, 3) [m] of the straight parts of the SharpEdges of a ContactSurface."""
    t, k = edges.triangle[:, 0], edges.number[:, 0]
    start, end = (surface.vertices[surface.triangles[t, (k + i) % 3]] for i in (0, 1))
    s = np.linspace(0.0, 1.0, PARTS + 1)[:, None, None]
    points = start + s * (end - start) - s * (1.0 - s) * surface.curvature[t, k]
    straight = ~surface.curvature[t, k].any(axis=1)
    parts = np.stack([points[:-1], points[1:]], axis=2)[:, ~straight].reshape(-1, 2, 3)
    return np.concatenate([np.stack([start, end], axis=1)[straight], parts])


@njit(cache=True)
def _distance(points, ends):
    """(m,) [m] of points (m, 3) from the nearest of the segments with `ends` (e, 2, 3)."""
    distance = np.full(len(points), np.inf)
    for i in range(len(points)):
        for e in range(len(ends)):
            along = way = rest = 0.0
            for k in range(3):
                d = ends[e, 1, k] - ends[e, 0, k]
                along += d * d
                way += d * (points[i, k] - ends[e, 0, k])
            s = min(max(way / along, 0.0), 1.0)
            for k in range(3):
                rest += (points[i, k] - ends[e, 0, k] - s * (ends[e, 1, k] - ends[e, 0, k])) ** 2
            distance[i] = min(distance[i], np.sqrt(rest))
    return distance
