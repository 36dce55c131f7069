"""Shape of a body beside its travel: which faces lead, how wide it is across, on which feet it presses, whether it is round.
"""

from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull

from hybrid.body.smooth import area_vectors

PLANE, LEADING = 0.99, 0.5  # cosine between a face and the travel; share of what the body covers that such faces are
ALIKE = 0.05                # of unit normals: their components along a travel and upwards differ by less
ACROSS = 0.1                # cosine between a travel and an axis of the grid that is across it
ROUND = 1.25                # largest over smallest distance of a round body's surface from its middle
SIDES = 12                  # different normals of a round body


def leads(body, place, travel):
    """Whether faces across the travel are most of what a body covers in its direction."""
    normal, area = faces(body, place)
    covered = normal @ (travel / np.linalg.norm(travel))
    ahead = covered > 0.0
    return covered[covered > PLANE * area].sum() > LEADING * covered[ahead].sum() > 0.0


def leading_normal(body, place, travel):
    """Unit normal (3,) of the plane face that is most of what a body covers in the direction of its travel, across it or
    inclined; None of a round one."""
    return _most(place, body, travel, lambda units, unit: units @ unit > PLANE)


def bow(body, place, travel):
    """The mean of the normals of plane faces that are alike inclined to a travel and to the ground, as both sides of a V."""
    along = travel / np.linalg.norm(travel)

    def alike(units, unit):
        return np.maximum(np.abs(units @ along - unit @ along), np.abs(units[:, 2] - unit[2])) < ALIKE

    return _most(place, body, travel, alike)


def _most(place, body, travel, alike):
    """Mean (3,) of the normals of the faces that are most of what a body covers in the direction of its travel, of those
    that are `alike`, or None; alike: function of unit normals (n, 3) and one of them (3,)."""
    normal, area = faces(body, place)
    covered = normal @ (travel / np.linalg.norm(travel))
    ahead = covered > 0.0
    normal, area, covered = normal[ahead], area[ahead], covered[ahead]
    units = normal / area[:, None]
    for unit in np.unique(units.round(2), axis=0):
        same = alike(units, unit / np.linalg.norm(unit))
        if covered[same].sum() > LEADING * covered.sum():
            mean = normal[same].sum(axis=0)
            return mean / np.linalg.norm(mean)
    return None


def faces(body, place):
    """Outward normals (T, 3) of the triangles of a body, as long as their areas (T,) [m²]."""
    normal = area_vectors(place[body.surface.triangles])
    return normal, np.linalg.norm(normal, axis=1)


def feet(body, place, travel, top):
    """[(Area [m²], length [m] of its edges, places (V, 3) [m] of the vertices)] of the plane parts, apart from each other,
    that lead a body across its travel and are in soil below `top` [m] in the end: one of a block, one of each leg of a
    table."""
    normal, area = faces(body, place)
    triangles = body.surface.triangles[normal @ travel > PLANE * area * np.linalg.norm(travel)]
    _, part = np.unique(place.round(9), axis=0, return_inverse=True)     # vertices of a surface may be there twice
    corners = part.ravel()[triangles]
    edges = np.sort(np.concatenate([corners[:, :2], corners[:, 1:], corners[:, ::2]]), axis=1)
    _, first, count = np.unique(edges, axis=0, return_index=True, return_counts=True)
    outer, at = edges[first[count == 1]], np.zeros((len(place), 3))
    at[part.ravel()] = place
    for mirror in body.mirrors:     # a cut is no edge
        outer = outer[(np.abs(at[outer][:, :, "xyz".index(mirror.axis)] - mirror.at) > 1e-6 * body.radius).any(axis=1)]
    number, group = connected_components(coo_matrix((np.ones(len(edges)), edges.T), (len(place), len(place))), False)
    found = []
    for each in range(number):
        mine = triangles[group[corners[:, 0]] == each]
        vertices = place[np.unique(mine)]
        if len(mine) and (vertices[:, 2] + min(travel[2], 0.0)).min() < top:
            own = outer[group[outer[:, 0]] == each]
            length = float(np.linalg.norm(at[own[:, 1]] - at[own[:, 0]], axis=1).sum())
            found.append((float(np.linalg.norm(area_vectors(place[mine]), axis=1).sum()), length, vertices))
    return found


def is_round(outline, distance):
    """Whether a body is, by distances (V,) [m] of its vertices from its middle and the SIDES of its `outline`, a
    ContactSurface: the corners of a box are all as far from its middle. A tube is as round as its outside."""
    outer = distance[ConvexHull(outline.vertices).vertices]
    return outer.max() <= ROUND * outer.min() and len(np.unique(outline.normals.round(3), axis=0)) >= SIDES


def heading(travel):
    """Words such as "down" or "along x" about the main direction of a travel (3,)."""
    axis = int(np.argmax(np.abs(travel)))
    return ("down", "up")[int(travel[2] > 0.0)] if axis == 2 else f"along {'xy'[axis]}"


class Side(NamedTuple):
    """Extent of a body across its path: width [m]; places [m] of both ends along a unit `direction` (3,); axis of the grid,
    None of a direction that is along none."""

    width: float
    ends: np.ndarray
    direction: np.ndarray
    axis: int | None


def sides(grid, place, travel):
    """Sides across the travel; an end on a face of the grid, or beyond it, mirrors the other."""
    unit = travel / np.linalg.norm(travel)
    along = np.flatnonzero(~grid.collapsed & (np.abs(unit) >= ACROSS))
    for axis in np.flatnonzero(~grid.collapsed & (np.abs(unit) < ACROSS)):
        ends, limits = np.array([place[:, axis].min(), place[:, axis].max()]), grid.extent[axis]
        inside = np.abs(ends - limits.mean()) < (0.5 - 1e-6) * np.ptp(limits)
        if inside.sum() == 1:
            end, middle = ends[inside][0], limits[~inside][0]
            yield Side(2 * abs(end - middle), np.array([end, end]), np.eye(3)[axis], axis)
        elif inside.any():
            yield Side(np.ptp(ends), ends, np.eye(3)[axis], axis)
    if len(along) == 2:     # in the plane of the travel
        direction = np.zeros(3)
        direction[along] = -unit[along[1]], unit[along[0]]
        ends = np.array([(place @ direction).min(), (place @ direction).max()])
        yield Side(np.ptp(ends), ends, direction, None)


def narrowest(grid, place, travel):
    """Smallest width [m] across the travel, 0 where there is none."""
    return min((side.width for side in sides(grid, place, travel)), default=0.0)
