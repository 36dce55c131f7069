"""The background grid of a scene: axes, faces, and the body that they move with."""

from itertools import pairwise
from math import ceil
from typing import Literal

from hybrid.scene.table import key, table

ROUNDED = 1e-4      # of a cell: what a size written with a few digits, 0.0833333 for 1/12, may add up to in a length
Condition = Literal["free", "roller", "fixed"]


@table
class Axis:
    """One axis of the background grid: uniform, graded around `fine`, by `nodes`, collapsed, or moving with a body.

    An axis needs `start`, `end` and `size`, or `nodes`; a collapsed axis needs no `size`.
    """

    start: float | None = key("lower end; left out: the first of `nodes`", "m", default=None)
    end: float | None = key("upper end; left out: the last of `nodes`", "m", default=None)
    size: float | None = key("largest size of the cells, which are equal and fill the axis; with `fine`, of those "
                             "inside", "m", default=None, above=0, remedy="choose a size that resolves the body",
                             also=("cell_size", "cells", "spacing", "dx", "h"))
    fine: tuple[float, float] | None = key("(low, high): cells of `size` in between, growing away from it", "m",
                                           default=None)
    growth: float = key("largest ratio of neighbouring cells outside `fine` or `around`", "-", default=1.3, above=1,
                        at_most=2, remedy="1.3 lets each cell grow by 30 %; leave out `fine` for a uniform axis")
    collapsed: bool = key("one constant basis function and no displacement along this axis; end - start is the "
                          "thickness", default=False)
    nodes: tuple[float, ...] | None = key("increasing coordinates of all nodes, instead of `size`", "m", default=None)
    around: tuple[float, float] | None = key(
        "(below, above): cells of `size` from this far below to this far above the bounding box of the body that "
        "grid.follow names; they move with it and double away from it as `growth` allows", "m", default=None)
    window: tuple[float, float] | None = key(
        "(below, above): soil farther than this from that box is left out; along z no soil above the body is left out. "
        "Ahead of a body that is pushed through soil at least its height there, twice that in sand", "m", default=None)
    doublings: int = key(
        "largest number of doublings of the cells, with `around`; windows, and the axis with one, end at multiples of the "
        "widest cells, also without `around`", "-", default=3, at_least=1, at_most=8, remedy="3 is usual")

    @property
    def moves(self):
        """Whether the nodes move with a body."""
        return self.around is not None or self.window is not None

    @property
    def smallest(self):
        """Size [m] of the smallest cells."""
        return self.size if self.nodes is None else min(b - a for a, b in pairwise(self.nodes))

    def __post_init__(self):
        if self.nodes is not None and len(self.nodes):
            for name, node in (("start", self.nodes[0]), ("end", self.nodes[-1])):
                if getattr(self, name) is None:
                    object.__setattr__(self, name, node)


_FACE = "soil at the {} end of {}: free, held normal to the face (roller), or held in all directions (fixed)"


@table
class Faces:
    """What holds the soil at the six faces of the grid."""

    x_min: Condition = key(_FACE.format("lower", "x"), default="roller")
    x_max: Condition = key(_FACE.format("upper", "x"), default="roller")
    y_min: Condition = key(_FACE.format("lower", "y"), default="roller")
    y_max: Condition = key(_FACE.format("upper", "y"), default="roller")
    z_min: Condition = key(_FACE.format("lower", "z"), default="roller")
    z_max: Condition = key(_FACE.format("upper", "z"), default="free")

    def of(self, axis, side):
        """Condition of the face across axis 0, 1 or 2 at its lower (side 0) or upper end (1)."""
        return getattr(self, f"{'xyz'[axis]}_{('min', 'max')[side]}")


@table
class Grid:
    """The background grid: the tensor product of three axes."""

    x: Axis = key("axis along x")
    y: Axis = key("axis along y")
    z: Axis = key("axis along z, upwards")
    faces: Faces = key("what holds the soil at the faces of the grid", default=Faces())
    follow: str | None = key("name of the body that the axes with `around` or `window` move with; left out: the first",
                             default=None)
    behind: Literal["freeze", "remove"] = key(
        "soil that a window leaves behind keeps its state and is solved again if the body returns (freeze), "
        "or is deleted",
        default="freeze")

    @property
    def axes(self):
        """(x, y, z), a tuple of Axis."""
        return self.x, self.y, self.z

    @property
    def moves(self):
        """Whether an axis moves with a body."""
        return any(axis.moves for axis in self.axes)


def cells_between(start, end, size):
    """Number of equal cells of at most `size` [m] between two coordinates [m]; ROUNDED of a cell makes no other one."""
    return max(1, ceil((end - start) / size - ROUNDED))
