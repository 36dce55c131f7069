"""An axis of the grid whose nodes go along with a body, by half a cell at most.

The force on a body that is pushed far through soil follows its place within the cells, with the period of a cell. In a
grid that goes along its place there stays the same. Cells of equal size h look alike after every whole cell, so the nodes
need not go farther than half a cell to either side of their place at the start:

    x_i(d) = x_i + w_i s,      s = d - h round(d / h)          d  displacement of the body [m]

w = 1 in the cells of size h around the body, and falls to 0 at the ends of the axis, which stay, over the cells of other
sizes or the last cells. It does not depend on how far the body will go, so that a run may be continued.
"""

from dataclasses import dataclass

import numpy as np

EQUAL = 1e-3    # of a cell: sizes that differ by less are the same
PAST = 1.4e-3   # cells: just past half a cell, where steps end by chance alone, the nodes go back, whatever the round-off
# Cells at an end over which w falls, so that none becomes smaller by more than an eighth; one, which becomes half as large,
# where the body is at that end
LAST = 4


@dataclass(frozen=True)
class CarriedAxis:
    """nodes (n,) [m] at the start; size h [m] of the cells where the body goes; weight w (n,) [-]"""

    nodes: np.ndarray
    size: float
    weight: np.ndarray

    @classmethod
    def around(cls, nodes, place, way):
        """That of a body from place[0] to place[1] [m] at the start, which will have been from way[0] to way[1] [m]; None
        where the cells on its way are not of one size."""
        sizes, inside = np.diff(nodes), np.clip(np.mean(place), nodes[0], nodes[-1])
        at = min(np.searchsorted(nodes, inside, side="right"), len(sizes)) - 1
        other = np.flatnonzero(np.abs(sizes - sizes[at]) > EQUAL * sizes[at])
        first, last = other[other < at].max(initial=-1) + 1, other[other > at].min(initial=len(sizes))
        if first and way[0] < nodes[first] or last < len(sizes) and way[1] > nodes[last]:
            return None
        size = (nodes[last] - nodes[first]) / (last - first)
        low = min(max(nodes[first], nodes[1], min(nodes[0] + LAST * size, place[0])), nodes[-2])
        high = max(min(nodes[last], nodes[-2], max(nodes[-1] - LAST * size, place[1])), low)
        return cls(nodes, size, np.interp(nodes, [nodes[0], low, high, nodes[-1]], [0.0, 1.0, 1.0, 0.0]))

    def at(self, displacement):
        """Nodes (n,) [m] for a `displacement` [m] of the body."""
        whole = np.copysign(np.ceil(abs(displacement) / self.size - 0.5 - PAST), displacement)
        return self.nodes + self.weight * (displacement - self.size * whole)
