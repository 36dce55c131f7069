"""Tensor-product rectilinear background grid.

Node v = (i ny + j) nz + k. An axis with a single node is *collapsed*: its basis function is the constant 1, its
displacement is fixed, and points on it represent a given thickness (plane strain, one-dimensional columns).
The grid has no state of its own and is never modified; a moving grid replaces it by another one.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hybrid.runtime.errors import SceneError
from hybrid.scene.grid import ROUNDED, cells_between

FACES = ("x_min", "x_max", "y_min", "y_max", "z_min", "z_max")


def uniform_nodes(start, end, size):
    """Nodes [m] from start to end with equal cells no larger than `size`, but for its last digit."""
    cells = cells_between(start, end, size)
    return np.linspace(start, end, cells + 1)


def graded_nodes(start, end, size, fine, growth):
    """Nodes [m] with cells of `size` inside the interval `fine`; outwards, each is at most `growth` times the last."""
    inner = uniform_nodes(*fine, size)
    size = inner[1] - inner[0]
    left = fine[0] - np.cumsum(_growing_cells(fine[0] - start, size, growth))[::-1]
    right = fine[1] + np.cumsum(_growing_cells(end - fine[1], size, growth))
    nodes = np.concatenate([left, inner, right])
    nodes[0], nodes[-1] = start, end
    return nodes


def cells_that_grow(distance, size, growth):
    """Number [-], not rounded, of cells size·r, size·r², ... with r = growth that fill `distance` [m]."""
    return np.log1p(distance / size * (growth - 1) / growth) / np.log(growth)


def _growing_cells(distance, size, growth):
    """Fewest cells size·r, size·r², ... that fill `distance` with r <= growth."""
    if distance <= ROUNDED * size:
        return np.empty(0)

    def length(ratio, count):
        return size * np.sum(ratio ** np.arange(1, count + 1))

    count = max(1, int(cells_that_grow(distance, size, growth)) - 1)
    while length(growth, count) < distance:
        count += 1
    from scipy.optimize import brentq  # imported only if a grid is graded

    ratio = brentq(lambda r: length(r, count) - distance, 1e-3, growth, xtol=1e-15)
    return size * ratio ** np.arange(1, count + 1)


def node_widths(axes, extent):
    """Widths [m] along each axis of the boxes around its nodes, which end halfway to their neighbours."""
    return [np.ptp(ends) * np.ones(1) if len(nodes) == 1 else
            0.5 * (np.diff(nodes, prepend=nodes[0]) + np.diff(nodes, append=nodes[-1])) for nodes, ends in zip(axes, extent)]


def smallest_cell(axes):
    """Edge [m] of the smallest cell between the nodes of three axes."""
    return min(np.diff(nodes).min() for nodes in axes if len(nodes) > 1)


def cells_of(position, lines):
    """(n, 3) cell of each position (n, 3) [m] on a grid of nodes `lines`, the nearest one outside."""
    return np.stack([np.clip(np.searchsorted(nodes, x, side="right") - 1, 0, max(0, len(nodes) - 2))
                     for nodes, x in zip(lines, position.T)], axis=1)


def cell_sizes(axes, position):
    """Edges (n, 3) [m] of the cells that contain positions (n, 3) [m] on a grid of nodes `axes`; infinite along collapsed
    ones."""
    return np.stack([np.diff(nodes)[at] if len(nodes) > 1 else np.full(len(at), np.inf)
                     for nodes, at in zip(axes, cells_of(position, axes).T)], axis=1)


def cell_numbers(position, grid):
    """((n,) number of the cell of each position (n, 3) [m], (3,) shape of the cells) of a whole grid, given as a Grid or
    a Block of it."""
    return np.ravel_multi_index(cells_of(position, grid.lines).T, grid.cell_counts), grid.cell_counts


@dataclass(frozen=True)
class Grid:
    """Background grid.

    axes: three increasing arrays of node coordinates [m]; length 1 when collapsed.
    extent: (3, 2) lower and upper end of each axis [m]; a collapsed axis keeps its thickness here.
    fixed: (N, 3) bool, displacement components of the nodes that the boundary conditions of the faces fix.
    """

    axes: tuple[np.ndarray, np.ndarray, np.ndarray]
    extent: np.ndarray
    fixed: np.ndarray

    @property
    def shape(self):
        """Number of nodes along each axis."""
        return tuple(len(a) for a in self.axes)

    @property
    def node_count(self):
        return int(np.prod(self.shape))

    @cached_property
    def collapsed(self):
        return np.array([len(a) == 1 for a in self.axes])

    @cached_property
    def volumes(self):
        """(N,) [m³] volume of the box around each node, which ends halfway to its neighbours."""
        return np.einsum("i,j,k->ijk", *node_widths(self.axes, self.extent)).ravel()

    @cached_property
    def smallest_cell(self):
        """Edge [m] of the smallest cell."""
        return smallest_cell(self.axes)

    @cached_property
    def resolution(self):
        """Edge [m] of the smallest cells along the axis on which they are largest."""
        return max(np.diff(nodes).min() for nodes in self.lines if len(nodes) > 1)

    @property
    def lines(self):
        """Nodes [m] along each axis of the whole grid, of which this one may be a block."""
        return self.axes

    @cached_property
    def planes(self):
        """(n, 3) bool of each axis: components that are fixed in a whole plane of nodes. Faces fix planes, so a node has the
        fixed components of its three planes."""
        fixed = self.fixed.reshape(*self.shape, 3)
        return tuple(fixed.all(axis=tuple({0, 1, 2} - {axis})) for axis in range(3))

    @property
    def cell_counts(self):
        """(3,) number of cells along each axis of the whole grid, one along a collapsed axis."""
        return np.array([max(1, len(nodes) - 1) for nodes in self.lines])

    # -------------------------------------------------------------- values of several processes (hybrid.grid.blocks)

    nodes = None    # how nodes are exchanged; None where one process has them all

    def summed(self, values):
        """Nodal values (N, ...), of which each process has added its part, with the parts of all; may be changed."""
        return values

    def from_owners(self, values):
        """Nodal values (N, ...) with those of copies from their owners; may be changed."""
        return values

    def summed_cells(self, values):
        """`summed` for values (a, b, c) of the cells."""
        return values

    def cells_from_owners(self, values):
        """Values (a, b, c) of the cells with those of copies from their owners; may be changed."""
        return values

    @property
    def owned_nodes(self):
        """Index of the nodes that belong to this process."""
        return ...

    @property
    def owned_cells(self):
        """Cells (a, b, c) bool that belong to this process."""
        return True

    def own_unknowns(self, free):
        """Index of the unknowns that belong to this process among those of the `free` (N, 3) components."""
        return ...

    def count_unknowns(self, free):
        """Number of `free` (N, 3) components of all nodes, over all processes."""
        return int(np.count_nonzero(free))


def make_grid(axes, extent, faces, all_fixed=False):
    """Grid from node arrays [m], axis extents (3, 2) [m] and a dict face -> "free" | "roller" | "fixed".

    all_fixed: fix all components of all nodes. Raises SceneError when the sizes of neighbouring cells differ by more
    than a factor of two: the domain of a point may be as wide as its cell and must not reach beyond the next cell.
    """
    axes = tuple(np.ascontiguousarray(a, dtype=float) for a in axes)
    for name, nodes in zip("xyz", axes):
        cells = np.diff(nodes)
        if len(cells) > 1:
            jump = np.max(np.maximum(cells[1:] / cells[:-1], cells[:-1] / cells[1:]))
            if jump > 2 * (1 + 1e-9):
                raise SceneError(f"grid.{name}: the sizes of neighbouring cells differ by a factor of {jump:.3g}, the "
                                 f"limit is 2; lower grid.{name}.growth, move grid.{name}.fine away from the ends, or add "
                                 f"grid.{name}.nodes between them")
    shape = tuple(len(a) for a in axes)
    fixed = np.zeros(shape + (3,), dtype=bool)
    for axis in range(3):
        if shape[axis] == 1:
            fixed[..., axis] = True
            continue
        for side, face in ((0, FACES[2 * axis]), (-1, FACES[2 * axis + 1])):
            layer = np.take(np.arange(shape[axis]), side)
            index = (slice(None),) * axis + (layer,)
            if faces[face] == "roller":
                fixed[index + (Ellipsis, axis)] = True
            elif faces[face] == "fixed":
                fixed[index] = True
    if all_fixed:
        fixed[...] = True
    return Grid(axes, np.asarray(extent, dtype=float), fixed.reshape(-1, 3))
