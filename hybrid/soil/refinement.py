"""Which points are halved and joined so that every cell has the points it is meant to have.

Along the spatial axis i a point of initial half-widths l and deformation F is as wide as the width a cell of h_i with
n_i points gives a point at the start times

    r_i = 2 n_i √Σ_j (F_ij l_j)² / h_i

It is halved along its material axis j = argmax |F_ij| l_j where r_i >= COARSE, and joined with the other half along j
where both and the whole have 2 r_i <= FINE, i being the direction of F e_j. Between the two limits points are left as
they are, so nothing flickers, and so are points that F stretches by more than LIMIT along j: their halves would be
thrown far apart, and those at the end of the grid of which a half would leave it. Halves are neighbours that at the
start shared the box of one point of twice their width; they are joined only while they still lie side by side. No point
gets narrower than those of the finest cells or wider than those of the widest.
"""

from dataclasses import dataclass

import numpy as np

from hybrid.soil.lost_points import LIMIT
from hybrid.soil.split_merge import concatenate, merge, select, split

COARSE = 1.9  # a point of a cell twice as large, at rest, has r = 2
FINE = 1.5    # the point two halves make, at rest in a cell that is twice as large, has r = 1
APART = 0.5   # of their width that two halves may be off the place side by side
GRAIN = 1e-6  # of the narrowest points: coordinates at the start that differ by less are the same


@dataclass(frozen=True)
class Resolution:
    """axes: those along which points may change; start: (3,) [m] where the lattice begins; width: (3,) [m] of the
    narrowest points; per_axis: (3,) points to a cell; doublings: times a width may double."""

    axes: tuple[int, ...]
    start: np.ndarray
    width: np.ndarray
    per_axis: np.ndarray
    doublings: int

    def adapt(self, population, grid, law, free):
        """(Population fit for the cells of `grid`, numbers (n,) that its points had before, -1 for new ones).

        free: (n,) bool, points that may change.
        """
        flock = population, np.arange(len(population)), free
        for change in (self._halve, self._join):
            changed = True
            while changed:
                changed = False
                for j in self.axes:
                    gone, new = change(j, flock[0], grid, law, flock[2])
                    if len(new):
                        flock, changed = _exchanged(*flock, gone, new), True
        return flock[:2]

    def _halve(self, j, population, grid, law, free):
        """Which points (n,) bool are too wide along the material axis j, and their halves."""
        share = _shares(population)
        wide = _ratio(share, self.per_axis, grid, population.points.position) >= COARSE
        wide &= share.argmax(axis=2) == j
        mask = wide[:, self.axes].any(axis=1) & free & (2 * population.constants.half_width[:, j] > 1.5 * self.width[j])
        mask &= np.linalg.norm(population.points.deformation[:, :, j], axis=1) <= LIMIT     # else thrown far apart
        mask &= _halves_within(j, population, grid)
        return mask, split(select(population, mask), j, law)

    def _join(self, j, population, grid, law, free):
        """Which points (n,) bool are halves along j that had better be one, and what they make."""
        share, half = _shares(population), population.constants.half_width
        toward = share[:, :, j].argmax(axis=1)                          # the spatial axis that F e_j goes along
        share[:, :, j] *= 2
        ratio = _ratio(share, self.per_axis, grid, population.points.position)
        some = free & (np.take_along_axis(ratio, toward[:, None], 1)[:, 0] <= FINE)
        some &= 2 * half[:, j] < 0.75 * 2**self.doublings * self.width[j]
        ids = np.flatnonzero(some)
        a, b = self._pairs(j, population.constants.position[ids], half[ids])
        a, b = ids[a], ids[b]
        near = toward[a] == toward[b]
        a, b = a[near], b[near]
        fit = self._side_by_side(j, population, grid, a, b, toward[a])
        a, b = a[fit], b[fit]
        gone = np.zeros(len(population), bool)
        gone[a] = gone[b] = True
        return gone, merge(select(population, a), select(population, b), j, law)

    def _pairs(self, j, position, half):
        """Numbers of the lower and of the upper half of each pair of points that were halves along j at the start."""
        low = np.rint((position - half - self.start) / (GRAIN * self.width)).astype(np.int64)
        size = np.rint(2 * half / (GRAIN * self.width)).astype(np.int64)
        number = np.rint((position[:, j] - half[:, j] - self.start[j]) / (2 * half[:, j])).astype(np.int64)
        low[:, j] = number // 2
        _, group, count = np.unique(np.column_stack([low, size]), axis=0, return_inverse=True, return_counts=True)
        group = group.ravel()
        order = np.lexsort((number, group))
        order = order[count[group[order]] == 2]
        return order[::2], order[1::2]

    def _side_by_side(self, j, population, grid, a, b, toward):
        """(pairs,) bool, those that still touch, and whose whole is not too wide for the cell that it is in."""
        points, half = population.points, population.constants.half_width
        mean = 0.5 * (points.deformation[a, :, j] + points.deformation[b, :, j])
        width = 2 * half[a, j]
        apart = points.position[b] - points.position[a] - mean * width[:, None]
        touch = np.linalg.norm(apart, axis=1) <= APART * width
        share = 0.5 * (_shares(population)[a] + _shares(population)[b])
        share[:, :, j] *= 2
        ratio = _ratio(share, self.per_axis, grid, 0.5 * (points.position[a] + points.position[b]))
        return touch & (np.take_along_axis(ratio, toward[:, None], 1)[:, 0] <= FINE)


def _halves_within(j, population, grid):
    """(n,) bool, points whose halves along j the grid holds: at the end of a window one would be put beyond it."""
    position = population.points.position
    away = np.abs(0.5 * population.constants.half_width[:, j, None] * population.points.deformation[:, :, j])
    within = np.ones(len(position), bool)
    for axis, nodes in enumerate(grid.axes):
        if len(nodes) > 1:
            within &= (position[:, axis] - away[:, axis] >= nodes[0]) & (position[:, axis] + away[:, axis] <= nodes[-1])
    return within


def cell_sizes(grid, position):
    """Edges (n, 3) [m] of the cells that hold positions (n, 3) [m]; infinite along collapsed axes."""
    sizes = np.full(position.shape, np.inf)
    for axis, nodes in enumerate(grid.axes):
        if len(nodes) > 1:
            cell = np.clip(np.searchsorted(nodes, position[:, axis], side="right") - 1, 0, len(nodes) - 2)
            sizes[:, axis] = np.diff(nodes)[cell]
    return sizes


def _shares(population):
    """|F_ij| l_j (n, 3, 3) [m]: what each material axis contributes to the width along each spatial one."""
    return np.abs(population.points.deformation) * population.constants.half_width[:, None, :]


def _ratio(share, per_axis, grid, position):
    return 2 * np.asarray(per_axis) * np.sqrt((share**2).sum(axis=2)) / cell_sizes(grid, position)


def _exchanged(population, origin, free, gone, new):
    """Population, numbers and freedom with the points `gone` (n,) bool replaced by the `new` ones at the end."""
    stay = np.flatnonzero(~gone)
    return (concatenate(select(population, stay), new), np.concatenate([origin[stay], np.full(len(new), -1)]),
            np.concatenate([free[stay], np.ones(len(new), bool)]))
