"""Selection of the points to split and to merge, so that each cell keeps about `soil.points_per_axis` points an axis.

Along the spatial axis i a point with initial half-widths l and deformation F has the width ratio

    r_i = 2 n_i √Σ_j (F_ij l_j)² / h_i

relative to an initial point, n_i of which lie in a cell of size h_i. A point is split along its material axis
j = argmax |F_ij| l_j where r_i >= COARSE. Two halves along j are merged where both of them, and the merged point, have
2 r_i <= FINE, i being the direction of F e_j. Between the two limits nothing changes, so that points are not split and
merged alternately.

Points are not split if F stretches them by more than DISTORTION_LIMIT along j, as their halves would lie far apart, or
if one half would lie outside the grid. Halves are neighbours whose initial domains together form the initial domain of
one point of twice their width; they are merged only while their domains are still adjacent. No point becomes narrower
than those of the finest cells, or wider than those of the coarsest.
"""

from dataclasses import dataclass

import numpy as np

from hybrid.grid.axes import cell_sizes
from hybrid.soil.lost_points import DISTORTION_LIMIT
from hybrid.soil.split_merge import concatenate, merge, select, split

COARSE = 1.9  # [-] width ratio at which a point is split; an undeformed point from a cell twice as large has 2
FINE = 1.5    # [-] width ratio at which halves are merged; an undeformed merged point in a cell twice as large has 1
GAP = 0.5     # [-] of their width: largest gap of two halves that are merged
SAME = 1e-6   # [-] of the narrowest points' width: initial coordinates that differ by less are treated as equal


@dataclass(frozen=True)
class PointRefinement:
    """Splits and merges points to fit the cells of a grid.

    axes: material axes along which points may be split and merged; start: (3,) [m] first node of each axis; width: (3,)
    [m] of the narrowest points; per_axis: (3,) points in a cell along each axis; doublings: the widest points have
    2^doublings times that width.
    """

    axes: tuple[int, ...]
    start: np.ndarray
    width: np.ndarray
    per_axis: np.ndarray
    doublings: int

    def adapt(self, population, grid, law, free):
        """(Population that fits the cells of `grid`, previous numbers (n,) of its points, -1 for new points).

        free: (n,) bool, points that may be split or merged.
        """
        current = population, np.arange(len(population)), free
        for change in (self._split, self._merge):
            changed = True
            while changed:
                changed = False
                for j in self.axes:
                    old, new = change(j, current[0], grid, law, current[2])
                    if len(new):
                        current, changed = _exchanged(*current, old, new), True
        return current[:2]

    def family(self, population):
        """(n, 3) [m] initial middles of the widest points that may be split into each point of a Population."""
        place, at = population.constants.position, list(self.axes)
        middle, widest = place.copy(), 2**self.doublings * self.width[at]
        middle[:, at] = self.start[at] + (np.floor((place[:, at] - self.start[at]) / widest) + 0.5) * widest
        return middle

    def _split(self, j, population, grid, law, free):
        """(n,) bool, points to split along the material axis j, and the Population of their halves."""
        share = _shares(population)
        wide = _ratio(share, self.per_axis, grid, population.points.position) >= COARSE
        wide &= share.argmax(axis=2) == j
        mask = wide[:, self.axes].any(axis=1) & free & (2 * population.constants.half_width[:, j] > 1.5 * self.width[j])
        mask &= np.linalg.norm(population.points.deformation[:, :, j], axis=1) <= DISTORTION_LIMIT
        mask &= _halves_within(j, population, grid)
        return mask, split(select(population, mask), j, law)

    def _merge(self, j, population, grid, law, free):
        """(n,) bool, halves along the material axis j to merge, and the Population of the merged points."""
        share, half = _shares(population), population.constants.half_width
        direction = share[:, :, j].argmax(axis=1)                       # the spatial axis closest to F e_j
        share[:, :, j] *= 2
        ratio = _ratio(share, self.per_axis, grid, population.points.position)
        narrow = free & (np.take_along_axis(ratio, direction[:, None], 1)[:, 0] <= FINE)
        narrow &= 2 * half[:, j] < 0.75 * 2**self.doublings * self.width[j]
        ids = np.flatnonzero(narrow)
        a, b = self._pairs(j, population.constants.position[ids], half[ids])
        a, b = ids[a], ids[b]
        parallel = direction[a] == direction[b]
        a, b = a[parallel], b[parallel]
        fit = self._side_by_side(j, population, grid, a, b, direction[a])
        a, b = a[fit], b[fit]
        merged = np.zeros(len(population), bool)
        merged[a] = merged[b] = True
        return merged, merge(select(population, a), select(population, b), j, law, grid.collapsed)

    def _pairs(self, j, position, half):
        """Numbers of the lower and of the upper half of each pair of points that are halves along j.

        position, half: (n, 3) [m], initial positions and half-widths.
        """
        low = np.rint((position - half - self.start) / (SAME * self.width)).astype(np.int64)
        size = np.rint(2 * half / (SAME * self.width)).astype(np.int64)
        number = np.rint((position[:, j] - half[:, j] - self.start[j]) / (2 * half[:, j])).astype(np.int64)
        low[:, j] = number // 2
        _, group, count = np.unique(np.column_stack([low, size]), axis=0, return_inverse=True, return_counts=True)
        group = group.ravel()
        order = np.lexsort((number, group))
        order = order[count[group[order]] == 2]
        return order[::2], order[1::2]

    def _side_by_side(self, j, population, grid, a, b, direction):
        """(pairs,) bool, pairs whose domains are still adjacent and whose merged point is not too wide for its cell."""
        points, half = population.points, population.constants.half_width
        mean = 0.5 * (points.deformation[a, :, j] + points.deformation[b, :, j])
        width = 2 * half[a, j]
        gap = points.position[b] - points.position[a] - mean * width[:, None]
        touch = np.linalg.norm(gap, axis=1) <= GAP * width
        share = 0.5 * (_shares(population)[a] + _shares(population)[b])
        share[:, :, j] *= 2
        ratio = _ratio(share, self.per_axis, grid, 0.5 * (points.position[a] + points.position[b]))
        return touch & (np.take_along_axis(ratio, direction[:, None], 1)[:, 0] <= FINE)


def _halves_within(j, population, grid):
    """(n,) bool, points of which both halves along j lie inside the grid."""
    position = population.points.position
    offset = np.abs(0.5 * population.constants.half_width[:, j, None] * population.points.deformation[:, :, j])
    within = np.ones(len(position), bool)
    for axis, nodes in enumerate(grid.axes):
        if len(nodes) > 1:
            within &= (position[:, axis] - offset[:, axis] >= nodes[0])
            within &= (position[:, axis] + offset[:, axis] <= nodes[-1])
    return within


def _shares(population):
    """|F_ij| l_j (n, 3, 3) [m]: contribution of material axis j to the half-width along spatial axis i."""
    return np.abs(population.points.deformation) * population.constants.half_width[:, None, :]


def _ratio(share, per_axis, grid, position):
    """Width ratios r_i (n, 3) [-]."""
    return 2 * np.asarray(per_axis) * np.sqrt((share**2).sum(axis=2)) / cell_sizes(grid.axes, position)


def _exchanged(population, origin, free, old, new):
    """Population, origin and `free` with the points `old` (n,) bool replaced by the Population `new` at the end."""
    stay = np.flatnonzero(~old)
    return (concatenate(select(population, stay), new), np.concatenate([origin[stay], np.full(len(new), -1)]),
            np.concatenate([free[stay], np.ones(len(new), bool)]))
