"""Blocks of a grid: each process holds one block of cells, with the nodes and points in it.

    own cells    low <= (i, j, k) < high, disjoint, together all cells
    own nodes    those with the numbers of own cells; the last node of an axis belongs to the block of the last cell
    local box    own cells and one layer of cells around them, or more, with all of their nodes: the others are copies

A domain reaches no farther than the cells next to that of its point. So points in own cells give to local nodes only, and a
process has whole fields around its points once it has exchanged those of its copies with their owners. Contact points may
drift farther from the domain that they are on: then there are more layers. Numbers of nodes and cells are local ones
everywhere else: kernels see a smaller grid.

Blocks are found by cutting the grid again and again at a plane of nodes, so that both sides have their share of the loads,
which are numbers of points, or the work on them.
"""

from dataclasses import dataclass

import numpy as np

from hybrid.grid.axes import Grid, cells_of, node_widths
from hybrid.runtime import comm
from hybrid.runtime.errors import SceneError


def cut_into_blocks(loads, parts):
    """Boxes (parts, 2, 3) of cells [low, high) with nearly equal shares of the `loads` (a, b, c), whole numbers, of all
    cells.

    Raises SceneError where there are not enough layers of cells.
    """
    return np.array(_cut(loads, np.zeros(3, int), parts))


def _cut(loads, low, parts):
    if parts == 1:
        return [(low, low + loads.shape)]
    filled = [np.flatnonzero(loads.sum(axis=tuple({0, 1, 2} - {axis}))) for axis in range(3)]
    length = [np.ptp(layers) if len(layers) else 0 for layers in filled]
    axis = int(np.argmax(np.where(np.array(loads.shape) > 1, length, -1)))
    below = parts // 2
    if loads.shape[axis] < 2:
        raise SceneError(f"--ranks: the grid has too few cells with soil for so many processes (one of {parts} parts is a "
                         "single cell); run on one rank, or on fewer")
    layers = np.cumsum(loads.sum(axis=tuple({0, 1, 2} - {axis})))
    at = 1 + int(np.argmin(np.abs(layers[:-1] - layers[-1] * below / parts)))
    first, second = np.split(loads, [at], axis=axis)
    above = low.copy()
    above[axis] += at
    return _cut(first, low, below) + _cut(second, above, parts - below)


class Exchange:
    """Plan by which copies on a lattice get the values of their owners, or give theirs to be added up.

    own: boxes (ranks, 2, 3) that belong to each process; local: boxes that each has; rank: of this process
    copies, given: {other process: numbers of what it owns and this one has copies of, and the other way round}
    shared: {other process: numbers that both have, in an order that is the same in both}
    """

    def __init__(self, own, local, rank):
        low, high = local[rank]
        self._shape, self.owned = high - low, np.zeros(high - low, bool)
        self.owned[_within(own[rank], low)] = True
        self.owned = self.owned.ravel()
        others = [other for other in range(len(own)) if other != rank]
        self.copies = {other: self._numbers(_common(local[rank], own[other]), low) for other in others}
        self.given = {other: self._numbers(_common(own[rank], local[other]), low) for other in others}
        self.shared = {other: self._numbers(_common(local[rank], local[other]), low) for other in others}
        self.copies, self.given, self.shared = ({other: at for other, at in found.items() if len(at)}
                                                for found in (self.copies, self.given, self.shared))

    def _numbers(self, box, low):
        numbers = np.arange(self._shape.prod()).reshape(self._shape)
        return numbers[_within(box, low)].ravel() if (box[1] > box[0]).all() else np.zeros(0, int)

    def from_owners(self, values):
        """Fill the copies of `values` (n, ...) in place."""
        self._move(values, self.given, self.copies, add=False)
        return values

    def summed(self, values):
        """Add up `values` (n, ...) over all processes in place."""
        self._move(values, self.copies, self.given, add=True)
        return self.from_owners(values)

    def _move(self, values, out, into, add):
        arrived = comm.neighbours({other: values[at] for other, at in out.items()},
                                  {other: len(at) for other, at in into.items()}, values.shape[1:], values.dtype)
        for other, at in into.items():
            if add:
                values[at] += arrived[other]
            else:
                values[at] = arrived[other]


def _within(box, low):
    return tuple(slice(a, b) for a, b in zip(box[0] - low, box[1] - low))


def _common(a, b):
    return np.array([np.maximum(a[0], b[0]), np.minimum(a[1], b[1])])


@dataclass(frozen=True)
class Block(Grid):
    """The local box of one process. extent, volumes and smallest_cell are those of the whole grid.

    lines: nodes [m] of the whole grid by axis; planes: its planes with fixed components, by axis
    boxes: (ranks, 2, 3) of own cells of all processes; rank: of this one; layers: of cells around them
    fullest: share of the fullest block in all loads when they were cut; nodes, cells: Exchange
    """

    lines: tuple = ()
    planes: tuple = ()
    boxes: np.ndarray | None = None
    rank: int = 0
    layers: int = 1
    fullest: float = 0.0
    nodes: Exchange | None = None
    cells: Exchange | None = None

    def summed(self, values):
        return self.nodes.summed(values)

    def from_owners(self, values):
        return self.nodes.from_owners(values)

    def summed_cells(self, values):
        return self.cells.summed(values.reshape(-1)).reshape(values.shape)

    def cells_from_owners(self, values):
        return self.cells.from_owners(values.reshape(-1)).reshape(values.shape)

    @property
    def owned_nodes(self):
        return self.nodes.owned

    @property
    def owned_cells(self):
        return self.cells.owned.reshape([max(1, n - 1) for n in self.shape])

    def own_unknowns(self, free):
        return np.broadcast_to(self.nodes.owned[:, None], free.shape)[free]

    def count_unknowns(self, free):
        return comm.count(free[self.nodes.owned])

    def layers_for(self, position):
        """Number of layers around the own cells that reach to all positions (n, 3) [m], at least 1."""
        low, high = self.boxes[self.rank]
        cell = cells_of(position, self.lines)
        return int(np.maximum(low - cell, cell + 1 - high).max(initial=1))

    def owner(self, position):
        """(n,) rank of the process in whose cells positions (n, 3) [m] lie, or that is nearest along the axes."""
        cell = cells_of(position, self.lines)
        found = np.zeros(len(position), int)
        for rank, (low, high) in enumerate(self.boxes):
            found[((cell >= low) & (cell < high)).all(axis=1)] = rank
        return found


def cut_block(grid, loads, parts, rank):
    """Block of the process `rank` of `parts` with nearly equal shares of the `loads` (a, b, c) of cells, from the whole
    Grid or from another Block of it."""
    boxes = cut_into_blocks(loads, parts)
    fullest = max(loads[_within(box, np.zeros(3, int))].sum() for box in boxes)
    return block_of(grid, boxes, rank, fullest / max(loads.sum(), 1))


def block_of(grid, boxes, rank, fullest, layers=1):
    """Block of the process `rank`, one of those with `boxes` (parts, 2, 3) of cells, from the whole Grid or from another
    Block of it."""
    lines, planes = grid.lines, grid.planes
    shape = np.array([len(nodes) for nodes in lines])
    cells, more = np.maximum(1, shape - 1), shape > 1       # one more node than cells, but on a collapsed axis
    around = np.stack([np.maximum(boxes[:, 0] - layers, 0), np.minimum(boxes[:, 1] + layers, cells)], axis=1)
    with_nodes = around + np.array([np.zeros(3, int), more])
    own = boxes.copy()
    own[:, 1] += (boxes[:, 1] == cells) & more
    part = _within(with_nodes[rank], np.zeros(3, int))
    x, y, z = (plane[one] for plane, one in zip(planes, part))
    fixed = (x[:, None, None] | y[:, None] | z).reshape(-1, 3)
    block = Block(tuple(np.ascontiguousarray(nodes[one]) for nodes, one in zip(lines, part)), grid.extent, fixed,
                  lines=lines, planes=planes, boxes=boxes, rank=rank, layers=layers, fullest=fullest,
                  nodes=Exchange(own, with_nodes, rank), cells=Exchange(boxes, around, rank))
    widths = [each[one] for each, one in zip(node_widths(lines, grid.extent), part)]
    block.__dict__.update(volumes=np.einsum("i,j,k->ijk", *widths).ravel(), smallest_cell=grid.smallest_cell)
    return block
