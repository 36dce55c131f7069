"""Contact points on the faces of soil that a body in place has exposed, or that end at a body without a cut, such as behind
a wall, from the start in equilibrium with it.

The ends of the boxes that a cut leaves follow the body in steps. Contact points on faces that the cut has exposed therefore
start at the surface of the body itself, overlapping it by what gives the pressure of the soil that was there,

    y = y_s - N δ      δ = max(0, -N·σ N) / (p_f E)

Equations: FORMULATION (54).
"""

import numpy as np

from hybrid.body.closest import NO_SIDE, closest
from hybrid.contact.search import distances
from hybrid.grid.axes import cells_of
from hybrid.runtime.comm import gathered, largest
from hybrid.runtime.jit import njit
from hybrid.setup.cut_boxes import Boxes, chunks, in_frame, near_surface
from hybrid.state import ContactHistory

OUTSIDE = 1e-3      # of a half-width: distance from a face at which it is seen what covers it
FLUSH = 1e-3        # half diagonals of a box, within which it ends at a body
NOTHING = 1e-6      # of the largest stress there: round-off of the pressure at the top of the soil
AROUND = 6.0        # half diagonals of the largest box near a body: no box that covers a face near it is farther from it


def first_contact_points(body, motion, soil, stress, before, boxes, flush=False):
    """ContactHistory of the contact points on faces exposed by the cut, touching the body with the stress of the soil.

    stress: (n, 3) [Pa], principal, of the points of `boxes`; before: Boxes of the soil without the body; flush: of points on
    faces that end at the surface of the body without a cut, such as those of soil behind a wall, and bear a pressure there.
    """
    collapsed, places = soil.grid.collapsed, body.places
    near = _within(2 * boxes.radii(collapsed), boxes, body, motion, collapsed)
    reach = AROUND * largest(before[boxes.parent[near]].radii(collapsed))
    old, new = (_Cells(_of_all(each, reach, body, motion, soil.grid), soil.grid) for each in (before, boxes))
    face = places.normal[places.group_of(np.arange(len(places)))]
    found = [(np.zeros(0, int), np.zeros(0, int), *np.zeros((2, 0, 3)))]
    for ids in chunks(near, len(places)):
        point, number = np.repeat(ids, len(places)), np.tile(np.arange(len(places)), len(ids))
        place = boxes.position[point] + places.flat[number] * boxes.half[point]
        beyond = place + OUTSIDE * face[number] * boxes.half[point]
        exposed = np.flatnonzero(~new.contain(beyond) & (True if flush else old.contain(beyond)))
        point, number, y = point[exposed], number[exposed], in_frame(place[exposed], motion, collapsed)
        distance, normal = distances(y, body.surface)
        size = before[boxes.parent[point]].radii(collapsed)
        reached = np.abs(distance) < (FLUSH if flush else 2.0) * size
        in_space = normal @ motion.rotation.T
        stay = np.flatnonzero((places.projected_share(number, in_space) > 0.0) & reached)
        closest_point = np.empty((len(stay), 3))
        _closest(np.ascontiguousarray(y[stay]), body.surface.tree, closest_point)
        point, number, in_space = point[stay], number[stay], in_space[stay]
        principal = stress[point]
        if soil.constants.geostatic_gradient is not None:
            rise = motion.position[2] + closest_point @ motion.rotation[2] - boxes.position[point, 2]
            principal = principal + soil.constants.geostatic_gradient[point] * rise[:, None]
        pressure = np.maximum(0.0, -np.einsum("ci,ci->c", in_space**2, principal))
        bears = slice(None) if not flush else pressure > NOTHING * np.abs(principal).max(axis=1)
        squeezed = pressure / body.contact_pressure[point]
        start = closest_point - squeezed[:, None] * normal[stay]
        found.append([each[bears] for each in (point, number, start, normal[stay])])
    point, number, y, side = (np.concatenate(column) for column in zip(*found))
    order = np.lexsort((number, point))
    y, side = y[order], side[order]
    return ContactHistory(point[order], number[order], motion.position + y @ motion.rotation.T, np.ones(len(y), bool), y,
                          side, np.zeros(len(y)))


def _within(size, boxes, body, motion, collapsed):
    """Numbers of the boxes nearer to the surface of a body than `size` (n,) [m]."""
    ids, distance = near_surface(boxes, size, body.surface, motion, collapsed)
    return ids[np.abs(distance) < size[ids]]


def _of_all(boxes, reach, body, motion, grid):
    """Boxes of all processes within `reach` [m] of the surface of a body; all boxes of one process."""
    if grid.nodes is None:
        return boxes
    ids = _within(np.full(len(boxes.parent), reach), boxes, body, motion, grid.collapsed)
    return Boxes(*(gathered(each[ids]) for each in (boxes.parent, boxes.position, boxes.half)))


class _Cells:
    """Boxes by the cells of a grid that they lie in, each in one."""

    def __init__(self, boxes, grid):
        self.boxes, self.axes, self.collapsed = boxes, grid.axes, grid.collapsed
        self.lower, self.upper = grid.extent.T
        self.counts = [max(1, len(nodes) - 1) for nodes in grid.axes]
        cell = np.ravel_multi_index(cells_of(boxes.position, grid.axes).T, self.counts)
        self.order = np.argsort(cell, kind="stable")
        self.first = np.searchsorted(cell[self.order], np.arange(np.prod(self.counts) + 1))

    def contain(self, place):
        """(m,) bool, whether places (m, 3) [m] are in a box."""
        out = np.zeros(len(place), np.bool_)
        inside = (((place > self.lower) & (place < self.upper)) | self.collapsed).all(axis=1)
        cell = np.ravel_multi_index(cells_of(np.clip(place, self.lower, self.upper), self.axes).T, self.counts)
        half = np.where(self.collapsed, np.inf, self.boxes.half)
        _contained(place, cell, self.first, self.order, self.boxes.position, half, out)
        return out & inside


@njit(cache=True)
def _contained(place, cell, first, order, position, half, out):
    for n in range(len(place)):
        for k in range(first[cell[n]], first[cell[n] + 1]):
            b = order[k]
            out[n] = out[n] or (abs(place[n, 0] - position[b, 0]) <= half[b, 0] and
                                abs(place[n, 1] - position[b, 1]) <= half[b, 1] and
                                abs(place[n, 2] - position[b, 2]) <= half[b, 2])


@njit(cache=True)
def _closest(y, tree, closest_point):
    """Fill the points (n, 3) of the surface closest to y (n, 3), body frame."""
    for n in range(len(y)):
        _, _, x, _, _ = closest((y[n, 0], y[n, 1], y[n, 2]), np.inf, tree, NO_SIDE)
        for i in range(3):
            closest_point[n, i] = x[i]
