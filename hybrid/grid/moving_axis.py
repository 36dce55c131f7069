"""Nodes of a grid that goes with a body, laid on a lattice that stays where it is.

Along a travelling axis every node lies on a lattice of the finest cells, x_i = start + i h. Cells of h surround the
body; away from it they double, h, 2h, 4h ..., up to 2^D h, and a cell of 2^k h starts at a multiple of 2^k. Two grids
for two places of the body therefore differ only in that cells are halved or joined in pairs, and points that tile the
cells of the one tile those of the other once they are halved or joined too (`hybrid.soil.split_merge`): soil at rest
stays in equilibrium to round-off however often the grid is laid anew.

    | 4h | 2h | 2h |h|h|h|h| 2h | 2h |  4h  |  4h  |          D = 2, two cells of a size before they double
                     body

Soil outside a window around the body need not be there at all. A window ends at multiples of 2^D, in blocks.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Lattice:
    """One axis of a travelling grid.

    start, end  [m]; cells: how many of the finest fit between them, a multiple of `block`
    around      (low, high) [m] distance of fine cells from the body's box; None: all cells are fine
    window      (low, high) [m] distance of the window's ends from the body's box; None: all of the axis
    doublings   D; per: cells of a size before they double
    """

    start: float
    end: float
    cells: int
    around: tuple[float, float] | None
    window: tuple[float, float] | None
    doublings: int
    per: int

    @property
    def size(self):
        """Edge of the finest cells [m]."""
        return (self.end - self.start) / self.cells

    @property
    def block(self):
        """Finest cells to a block."""
        return 2**self.doublings

    def fit(self, low, high, before=None):
        """Layout for a body whose box reaches from `low` to `high` [m]. The one `before` is kept while it is wide
        enough and at most a snap too wide, lest it flicker."""
        before = before or Layout((None, None), (None, None))
        window = self._span(low, high, self.window, self.block, before.window)
        fine = self._span(low, high, self.around, 2 if self.doublings else 1, before.fine)
        return Layout(tuple(np.clip(fine, *window).tolist()), window)

    def _span(self, low, high, margin, snap, before):
        """Cells (first, last) of the box with its margins, in multiples of `snap`, inside the axis."""
        if margin is None:
            return 0, self.cells
        first = (low - margin[0] - self.start) / (snap * self.size)
        last = (high + margin[1] - self.start) / (snap * self.size)
        span = []
        for needed, old, sign in ((first, before[0], -1), (last, before[1], 1)):
            ends = sign * int(np.ceil(sign * needed - 1e-9)) * snap
            if old is not None and 0 <= sign * (old - ends) <= snap:
                ends = old
            span.append(min(max(ends, 0), self.cells))
        return tuple(span)

    def nodes(self, layout):
        """Lattice numbers (m,) of the nodes, increasing."""
        (low, high), (first, last) = layout.fine, layout.window
        below = _outwards(-low, -first, self.doublings, self.per)
        above = _outwards(high, last, self.doublings, self.per)
        return np.concatenate([-below[::-1], np.arange(low, high + 1), above]).astype(np.int64)

    def place(self, number):
        """Coordinates [m] of lattice numbers: the same bits whatever the layout."""
        return self.start + (self.end - self.start) * (np.asarray(number) / self.cells)


@dataclass(frozen=True)
class Layout:
    """fine: (first, last) lattice number of the fine cells; window: the same of all cells."""

    fine: tuple
    window: tuple


def _outwards(place, end, doublings, per):
    """Nodes beyond `place` up to `end` in the positive direction; both multiples of what their cells need."""
    level, laid, out = 0, per, []
    while place < end:
        if level < doublings and laid >= per and place % 2 ** (level + 1) == 0:
            level, laid = level + 1, 0
        place, laid = place + 2**level, laid + 1
        out.append(place)
    return np.array(out, np.int64)
