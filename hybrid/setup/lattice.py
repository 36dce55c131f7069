"""The lattice of the points of soil that fills a grid: what is known of them without making them.

Points stand in columns along z. Ground that is not level ends each column somewhere, so the lengths of columns tell how many
points a cell has, and the number of a point in the run. Several processes cut the grid into blocks by these counts, and each
makes the points of its own cells only.

Numbers go along z first, then along y, then along x. A place is the number in a lattice whose columns no ground ends.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hybrid.runtime.errors import SceneError
from hybrid.setup.ground import mean_levels, shares_below
from hybrid.soil.given_ground import SLIVER
from hybrid.soil.points import lines_of_points
from hybrid.state import PointConstants


@dataclass(frozen=True)
class Lattice:
    """Lines of points along the axes: centres, halves (widths): three arrays [m]; cells: three arrays, cell of the grid
    that each line is in; ground: soil.ground, None where it is level."""

    centres: tuple
    halves: tuple
    cells: tuple
    ground: object = None

    @classmethod
    def of(cls, described, grid, lower, upper):
        """Lattice of a scene's soil between two corners (3,) [m] on a Grid. Raises SceneError where no soil is left."""
        found = cls(*lines_of_points(grid, lower, upper, np.broadcast_to(described.points_per_axis, 3)), described.ground)
        if not found.kept.any():
            raise SceneError("soil.ground: no soil lies below it; raise it, or lower grid.z.start")
        return found

    @property
    def height(self):
        """Number of points in a column that no ground ends."""
        return len(self.centres[2])

    @cached_property
    def levels(self):
        """(columns,) [m] mean height of the ground over each column, None where it is level."""
        if self.ground is None:
            return None
        place, half = (np.stack([a.ravel() for a in np.meshgrid(*lines[:2], indexing="ij")], axis=1)
                       for lines in (self.centres, self.halves))
        return mean_levels(self.ground, place, half)

    @cached_property
    def kept(self):
        """(columns,) number of points in each column: the lowest ones."""
        count = np.full(len(self.centres[0]) * len(self.centres[1]), self.height)
        if self.ground is not None:
            count[:] = 0
            for z, half in zip(self.centres[2], self.halves[2]):
                count += shares_below(self.levels, z, half) >= SLIVER
        return count

    def heights(self):
        """Yields arrays [m] with all heights of points, once or more often."""
        if self.ground is None:
            yield self.centres[2]
            return
        for k, (z, half) in enumerate(zip(self.centres[2], self.halves[2])):
            yield z - (1.0 - shares_below(self.levels[self.kept > k], z, half)) * half

    def counts(self, shape):
        """Number of points (a, b, c) in each cell of a grid with `shape` (3,) cells."""
        column = np.add.outer(self.cells[0] * shape[1], self.cells[1]).ravel()
        found = np.zeros((shape[0] * shape[1], shape[2]), np.int64)
        for k, cell in enumerate(self.cells[2]):
            found[:, cell] += np.bincount(column[self.kept > k], minlength=len(found))
        return found.reshape(shape)

    def chosen(self, cells):
        """(n,) places, increasing, of the points in the lattice that are in the `cells` (a, b, c) bool; None: in any."""
        if cells is None:
            return self._of_columns(np.arange(len(self.kept)))
        lines = [np.flatnonzero(cells.any(axis=tuple({0, 1, 2} - {axis}))[own]) for axis, own in enumerate(self.cells)]
        inside = np.nonzero(cells[np.ix_(*(own[line] for own, line in zip(self.cells, lines)))])
        place = np.ravel_multi_index([line[i] for line, i in zip(lines, inside)], [len(own) for own in self.cells])
        return place[place % self.height < self.kept[place // self.height]]

    def pieces(self, place):
        """Yields places of all points in the columns of the points `place` (n,), in whole columns: n at a time and a column
        more."""
        columns = np.unique(place // self.height)
        begins = np.cumsum(self.kept[columns]) - self.kept[columns]
        for part in np.split(columns, 1 + np.flatnonzero(np.diff(begins // max(1, len(place))))):
            yield self._of_columns(part)

    def _of_columns(self, columns):
        count = self.kept[columns]
        return np.repeat(columns * self.height - np.cumsum(count) + count, count) + np.arange(count.sum())

    def points(self, place):
        """PointConstants, of density 1, at places (n,) in the lattice, before the ground cuts any."""
        at = np.unravel_index(place, [len(line) for line in self.centres])
        position, half = (np.stack([line[i] for line, i in zip(lines, at)], axis=1) for lines in (self.centres, self.halves))
        volume = np.prod(2 * half, axis=1)
        return PointConstants(position, half, volume, volume.copy())

    def numbers(self, place):
        """Numbers (n,) in the run of the points at places (n,) in the lattice."""
        column, k = np.divmod(place, self.height)
        return (np.cumsum(self.kept) - self.kept)[column] + k
