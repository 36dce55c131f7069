"""The background grid of a scene: nodes along each axis, held faces, and how the grid moves with a body."""

from functools import partial
from itertools import chain

import numpy as np

from hybrid.body import rigid
from hybrid.body.paths import path_along
from hybrid.grid.axes import FACES, graded_nodes, make_grid, uniform_nodes
from hybrid.grid.carried_axis import CarriedAxis
from hybrid.grid.moving_axis import MovingAxis
from hybrid.scene.soil import laws
from hybrid.setup.size import refuse_size
from hybrid.setup.soil import count_points, lay_out
from hybrid.step.carried_grid import CarriedGrid
from hybrid.step.moving_grid import MovingGrid


def build_grid(scene, placed=()):
    """(Grid with its held faces, MovingGrid or None, its layouts) for bodies `placed`, each a RigidBody and BodyState.

    The MovingGrid and its layouts are None if the grid does not move.
    """
    described = scene.grid.axes
    extent = np.array([(axis.start, axis.end) for axis in described])
    axes = [None if axis.moves else axis_nodes(axis) for axis in described]
    moving = {number: build_moving_axis(axis) for number, axis in enumerate(described) if axis.moves}
    faces = {face: getattr(scene.grid.faces, face) for face in FACES}
    if not moving:
        return make_grid(axes, extent, faces, scene.soil.held), None, None
    names = [body.name for body, _ in placed]
    followed = names.index(scene.grid.follow) if scene.grid.follow else 0
    moving_grid = MovingGrid(followed, moving, axes, extent, faces, np.broadcast_to(scene.soil.points_per_axis, 3),
                             scene.grid.behind == "freeze", partial(count_points, scene.soil),
                             partial(lay_out, scene.soil, gravity=np.array(scene.gravity, float)))
    layouts = moving_grid.layouts_for(rigid.bounding_box(*placed[followed]))
    refuse_size(scene, [moving[a].coordinates(moving[a].node_numbers(layouts[a])) if a in moving else nodes
                        for a, nodes in enumerate(axes)])
    return moving_grid.grid(layouts), moving_grid, layouts


def build_carried_grid(scene, grid, placed, moving_grid):
    """CarriedGrid, None where there is no axis along which all bodies go the same way, more than a cell, without inertia,
    through cells of one size, or that follow a body, and soil that may yield; bodies `placed`, each a RigidBody and
    BodyState; moving_grid: MovingGrid or None."""
    yields = not scene.soil.held and laws(scene.soil) != {"hencky"}
    if scene.time.inertia or not yields or scene.method == "published" or not placed:
        return None
    boxes = np.array([rigid.bounding_box(*one) for one in placed])
    low, high = boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)
    axes = {}
    for axis in np.flatnonzero(~grid.collapsed):
        paths = [path_along(scene, described, "xyz"[axis]) for described in scene.bodies]
        ways = [0.0, *chain.from_iterable(paths[0])]
        if any(path != paths[0] for path in paths) or np.ptp(ways) <= grid.smallest_cell:
            continue
        if moving_grid and axis in moving_grid.moving_axes:
            axes[axis] = None
            continue
        carried = CarriedAxis.around(grid.lines[axis], (low[axis], high[axis]),
                                     (low[axis] + min(ways), high[axis] + max(ways)))
        if carried is not None:
            axes[axis] = carried
    return CarriedGrid(axes, placed[0][1].position.copy(), moving_grid) if axes else None


def axis_nodes(axis):
    """Coordinates [m] of the nodes along an axis that does not move; a collapsed axis has one node."""
    if axis.collapsed:
        return np.array([0.5 * (axis.start + axis.end)])
    if axis.nodes is not None:
        return np.array(axis.nodes)
    if axis.fine is not None:
        return graded_nodes(axis.start, axis.end, axis.size, axis.fine, axis.growth)
    return uniform_nodes(axis.start, axis.end, axis.size)


def build_moving_axis(axis):
    """Axis that moves with a body."""
    cells, per = round((axis.end - axis.start) / axis.size), max(1, round(np.log(2) / np.log(axis.growth)))
    return MovingAxis(axis.start, axis.end, cells, axis.around, axis.window, axis.doublings, per)
