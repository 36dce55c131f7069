"""One axis of a grid that moves with a body.

The nodes of a moving axis are numbered in units of the finest cell, x_i = start + i h, and that numbering is fixed in
space. Cells of size h surround the body. Away from it the cell size doubles, h, 2h, 4h, ..., up to 2^D h, and a cell of
size 2^k h starts at a multiple of 2^k. Two grids for two positions of the body therefore differ only in that cells are
split or merged in pairs. Points that tile the cells of one grid tile the cells of the other one after they have been
split or merged in the same way (`hybrid.soil.split_merge`), so soil at rest stays in equilibrium to round-off, however
often the grid is laid out again.

    | 4h | 2h | 2h |h|h|h|h| 2h | 2h |  4h  |  4h  |          D = 2, two cells of each size before it doubles
                     body

The grid may be limited to a window around the body. A window ends at multiples of 2^D, in whole blocks.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class MovingAxis:
    """One axis of a moving grid.

    start, end      [m]
    cells           number of finest cells between them, a multiple of `block`
    around          (low, high) [m] distance of the ends of the fine cells from the body's box; None: all cells are fine
    window          (low, high) [m] distance of the ends of the window from the body's box; None: the whole axis
    doublings       D, how often the cell size may double
    cells_per_size  cells of one size before it doubles
    """

    start: float
    end: float
    cells: int
    around: tuple[float, float] | None
    window: tuple[float, float] | None
    doublings: int
    cells_per_size: int

    @property
    def size(self):
        """Edge of the finest cells [m]."""
        return (self.end - self.start) / self.cells

    @property
    def block(self):
        """Number of finest cells in a block, which is as wide as the coarsest cell."""
        return 2**self.doublings

    def layout_for(self, low, high, previous=None):
        """AxisLayout for a body whose box reaches from `low` to `high` [m].

        An end of the `previous` layout is kept while it is wide enough and at most one block (for the fine cells: two
        cells) too wide, so that a body that oscillates does not make the grid alternate.
        """
        previous = previous or AxisLayout((None, None), (None, None))
        window = self._interval(low, high, self.window, self.block, previous.window)
        fine = self._interval(low, high, self.around, 2 if self.doublings else 1, previous.fine)
        return AxisLayout(tuple(np.clip(fine, *window).tolist()), window)

    def _interval(self, low, high, margin, multiple, previous):
        """Node numbers (first, last) of the box with its margins, rounded outwards to a `multiple`, inside the axis."""
        if margin is None:
            return 0, self.cells
        first = (low - margin[0] - self.start) / (multiple * self.size)
        last = (high + margin[1] - self.start) / (multiple * self.size)
        ends = []
        for needed, old, sign in ((first, previous[0], -1), (last, previous[1], 1)):
            end = sign * int(np.ceil(sign * needed - 1e-9)) * multiple
            if old is not None and 0 <= sign * (old - end) <= multiple:
                end = old
            ends.append(min(max(end, 0), self.cells))
        return tuple(ends)

    def node_numbers(self, layout):
        """Numbers (m,) of the nodes of an AxisLayout, increasing."""
        (low, high), (first, last) = layout.fine, layout.window
        below = _coarsening(-low, -first, self.doublings, self.cells_per_size)
        above = _coarsening(high, last, self.doublings, self.cells_per_size)
        return np.concatenate([-below[::-1], np.arange(low, high + 1), above]).astype(np.int64)

    def coordinates(self, number):
        """Coordinates [m] of node numbers: bitwise the same in every layout."""
        return self.start + (self.end - self.start) * (np.asarray(number) / self.cells)


@dataclass(frozen=True)
class AxisLayout:
    """Where an axis has cells: node numbers (first, last) of the `fine` cells, and of all cells, the `window`."""

    fine: tuple
    window: tuple


def _coarsening(number, end, doublings, cells_per_size):
    """Node numbers beyond `number` up to `end` in the positive direction, with cells that double in size.

    Both are multiples of the size of the cell that starts or ends there.
    """
    level, count, out = 0, cells_per_size, []
    while number < end:
        if level < doublings and count >= cells_per_size and number % 2 ** (level + 1) == 0:
            level, count = level + 1, 0
        number, count = number + 2**level, count + 1
        out.append(number)
    return np.array(out, np.int64)
