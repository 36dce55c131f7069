"""A grid that moves with a body: fine cells around it, coarser ones farther away, none beyond its window.

The grid carries no state, so between two outer steps it may be replaced (`hybrid.grid.moving_axis`). Then

    1. points whose block is no longer in the window are left behind: frozen, or removed; frozen ones take part again
       when the window returns to their block
    2. blocks that enter the window for the first time are filled with points at rest, in geostatic equilibrium
    3. points are split where cells have become finer, merged where coarser (`hybrid.soil.refinement`)
    4. domains are fitted to their new cells, and contact follows its points to their new numbers

On several processes the halves of a point may lie in different blocks, so 3 is done where their initial place is, and the
new grid is cut into new blocks (`hybrid.step.processes`).

Points with a contact point that is followed are neither split nor merged. At an end of the window inside the axis, soil
is held at least along that axis. The energy of soil left behind in 1 and the energy lost in 3 are work "left".
"""

from dataclasses import replace

import numpy as np

from hybrid.body import rigid
from hybrid.grid.axes import FACES, make_grid
from hybrid.grid.carried_axis import CarriedAxis
from hybrid.grid.moving_axis import AxisLayout
from hybrid.runtime import comm
from hybrid.runtime.comm import minimum, number
from hybrid.runtime.errors import StepError
from hybrid.soil.domains import updated_half
from hybrid.soil.points import at_rest, extent
from hybrid.soil.refinement import PointRefinement
from hybrid.soil.split_merge import concatenate, select
from hybrid.state import Ground, Population
from hybrid.step import processes
from hybrid.step.energy import soil_energies


class MovingGrid:
    """How the grid of a scene moves.

    body         number of the body that it follows
    moving_axes  {axis: MovingAxis} of those that move; axes: nodes [m] of the others; extent (3, 2) [m]
    faces        dict face -> condition, as `make_grid` takes it
    per_axis     (3,) points per cell along each axis
    keep         whether soil left behind is frozen, else it is removed
    count        function of a Grid that gives the numbers of points of soil filling it in its cells (a, b, c)
    lay_out      function of a Grid, and of the `cells` (a, b, c) bool whose points are wanted, None for all, that gives
                 (PointConstants, principal stress at rest (n, 3), law) of these points
    """

    def __init__(self, body, moving_axes, axes, extent, faces, per_axis, keep, count, lay_out):
        self.body, self.moving_axes, self._axes, self._extent, self._faces = body, moving_axes, axes, extent, faces
        self._per_axis, self._keep = np.array(per_axis), keep
        self._count, self.lay_out = count, lay_out

    # -------------------------------------------------------------- layout

    def layouts_for(self, box, before=None):
        """{axis: AxisLayout} for a body in `box` (2, 3) [m]; before: those of now, None at the start."""
        return {axis: moving.layout_for(*box[:, axis], before and before[axis])
                for axis, moving in self.moving_axes.items()}

    def grid(self, layouts):
        """Grid of layouts {axis: AxisLayout}."""
        axes, extent, faces = list(self._axes), self._extent.copy(), dict(self._faces)
        for axis, layout in layouts.items():
            moving = self.moving_axes[axis]
            axes[axis] = moving.coordinates(moving.node_numbers(layout))
            extent[axis] = axes[axis][[0, -1]]
            for side, end in ((0, 0), (1, moving.cells)):
                face = FACES[2 * axis + side]
                if layout.window[side] != end and faces[face] == "free":
                    faces[face] = "roller"
        return make_grid(axes, extent, faces)

    def carried_axis(self, axis, model, state):
        """CarriedAxis of an axis with the cells that it has now."""
        moving = self.moving_axes[axis]
        nodes = moving.coordinates(moving.node_numbers(_layouts(state.ground, self.moving_axes)[axis]))
        box = rigid.bounding_box(model.bodies[self.body], state.bodies[self.body])[:, axis]
        return CarriedAxis.around(nodes, box, box)

    def first_ground(self, layouts, soil):
        """Ground of a Soil that fills the grid of `layouts`."""
        blocks = [self.moving_axes[a].cells // self.moving_axes[a].block if a in layouts else 1 for a in range(3)]
        made = np.zeros(blocks, bool)
        made[self._blocks(layouts)] = True
        return Ground(_array(layouts, "fine"), _array(layouts, "window"), made, soil.constants, soil.law.rows)

    def _blocks(self, layouts):
        """Slices of the blocks in the window."""
        def of_axis(axis):
            if axis not in layouts:
                return slice(None)
            first, end = layouts[axis].window
            return slice(first // self.moving_axes[axis].block, end // self.moving_axes[axis].block)

        return tuple(of_axis(axis) for axis in range(3))

    def _block_of(self, position):
        """Block (n, 3) that each position (n, 3) [m] is in, or the nearest one."""
        block = np.zeros(position.shape, int)
        for axis, moving in self.moving_axes.items():
            at = (position[:, axis] - moving.start) // (moving.block * moving.size)
            block[:, axis] = np.clip(at, 0, moving.cells // moving.block - 1)
        return block

    def _blocks_of_cells(self, grid):
        """Three arrays: block that each cell of a whole Grid is in, along each axis."""
        middles = [0.5 * (nodes[1:] + nodes[:-1]) if len(nodes) > 1 else nodes for nodes in grid.axes]
        position = np.zeros((max(map(len, middles)), 3))
        for axis, middle in enumerate(middles):
            position[:len(middle), axis] = middle
        return [self._block_of(position)[:len(middle), axis] for axis, middle in enumerate(middles)]

    # -------------------------------------------------------------- replacing the grid

    def follow(self, model, state):
        """(Model, State, whether they are new) with the grid for the present place of the body.

        Raises StepError where the body returns to soil that was removed.
        """
        body = model.bodies[self.body]
        before = _layouts(state.ground, self.moving_axes)
        layouts = self.layouts_for(rigid.bounding_box(body, state.bodies[self.body]), before)
        if layouts == before:
            return model, state, False
        if not self._keep:
            self._refuse_return(body.name, state, before, layouts)
        grid = self.grid(layouts)
        here, contacts, made, behind = self._soil_of(layouts, grid, model, state)
        block, here, contacts = self._refined(grid, model, here, contacts, behind)
        ground = Ground(_array(layouts, "fine"), _array(layouts, "window"), made, here.constants, here.rows, behind)
        new = _with_ground(model, block, ground)
        gone = sum(soil_energies(model, state.points).values()) - sum(soil_energies(new, here.points).values())
        work = {**state.work, "left": state.work.get("left", 0.0) + gone}
        return new, replace(state, points=here.points, contacts=contacts, work=work, ground=ground), True

    def _soil_of(self, layouts, grid, model, state):
        """(Population in the window of a whole `grid`, ContactHistory by its numbers, blocks made by now, Population left
        behind or None)."""
        here, shared = Population(state.points, model.soil.constants, model.soil.law.rows), _is_shared(model)
        here, origin, behind = self._inside_window(layouts, here, state.ground.behind)
        here, made = self._fill_new_blocks(layouts, grid, here, state.ground.made, shared)
        contacts = [_renumbered(contact, origin, len(state.points)) for contact in state.contacts]
        if shared:
            here = processes.numbered(here, np.arange(len(here)) >= len(origin), behind)
            owner = model.soil.grid.owner(self._refinement(model.soil).family(here))
            here, contacts = processes.moved(owner, here, contacts)
        return here, contacts, made, behind

    def _refined(self, grid, model, here, contacts, behind):
        """(`grid` or the block of it that this process has, Population `here` with its points split and merged for it,
        ContactHistory by its numbers)."""
        free, before = _without_contact(contacts, len(here)), len(here)
        if here.points.inactive is not None:
            free &= ~here.points.inactive
        with comm.alone():      # each process splits and merges its own points, as often as they need it
            here, former = self._refinement(model.soil).adapt(here, grid, model.soil.law, free)
        contacts = [_renumbered(contact, former, before) for contact in contacts]
        here = replace(here, points=replace(here.points, half_width=updated_half(
            model.soil.domain, here.constants.half_width, here.points.deformation, here.points.position, grid.axes)))
        if _is_shared(model):
            return processes.on_new_grid(grid, processes.numbered(here, former < 0, behind), contacts)
        return grid, here, contacts

    def points_when_sunk(self, model, state):
        """Number of points in the grid when the body has sunk below the surface of the soil, where its fine cells are
        full of them; the present number where it cannot move down, or is there already."""
        body, points = model.bodies[self.body], state.points
        box = rigid.bounding_box(body, state.bodies[self.body])
        depth = box[1, 2] - extent(points, 2)[1]
        if depth <= 0.0 or not (body.free[2] or body.driven[2]):
            return number(points)
        return int(self._count(self.grid(self.layouts_for(box - (0.0, 0.0, depth)))).sum())

    def model_with(self, model, ground):
        """`model` with the points and the grid of a Ground."""
        return _with_ground(model, self.grid(_layouts(ground, self.moving_axes)), ground)

    def _inside_window(self, layouts, here, behind):
        """(Population in the window, former numbers of its points or -1, Population left behind or None)."""
        inside = self._inside(layouts, here.points.position)
        origin = np.flatnonzero(inside)
        gone, here = select(here, ~inside), select(here, inside)
        if not self._keep:
            return here, origin, None
        gone = replace(gone, points=_at_standstill(gone.points))
        behind = gone if behind is None else concatenate(behind, gone)
        back = self._inside(layouts, behind.points.position)
        if back.any():
            here, behind = concatenate(here, select(behind, back)), select(behind, ~back)
            origin = np.concatenate([origin, np.full(np.count_nonzero(back), -1)])
        return here, origin, behind

    def _refuse_return(self, name, state, before, layouts):
        """StepError where the window returns to blocks whose soil was removed."""
        again = np.zeros_like(state.ground.made)
        again[self._blocks(layouts)] = True
        again[self._blocks(before)] = False
        if np.any(again & state.ground.made):
            raise StepError(f"{name} returns at t = {state.time:.4g} s to soil that the window has left behind and "
                            'that was removed; set grid.behind = "freeze", or widen grid.x.window, y or z')

    def _inside(self, layouts, position):
        block, window = self._block_of(position), self._blocks(layouts)
        return np.all([(block[:, a] >= (s.start or 0)) & (s.stop is None or block[:, a] < s.stop)
                       for a, s in enumerate(window)], axis=0)

    def _fill_new_blocks(self, layouts, grid, here, made, shared):
        """Population with points at rest in blocks that enter the window for the first time, and the new `made`; shared:
        whether several processes make their share of these points each."""
        window = self._blocks(layouts)
        if made[window].all():
            return here, made
        cells = None
        if shared:
            new = ~made[np.ix_(*self._blocks_of_cells(grid))]
            cells = new & processes.share(np.where(new, self._count(grid), 0))
        constants, stress, law = self.lay_out(grid, cells=cells)
        new = np.flatnonzero(~made[tuple(self._block_of(constants.position).T)])
        points = at_rest(constants, stress, law.strain(stress))
        made = made.copy()
        made[window] = True
        return concatenate(here, select(Population(points, constants, law.rows), new)), made

    def _refinement(self, soil):
        """PointRefinement of the moving axes; points are split and merged along graded ones only."""
        axes = tuple(axis for axis, moving in self.moving_axes.items() if moving.around is not None)
        start, size = np.zeros(3), np.array([minimum(w) for w in soil.constants.half_width.T]) * 2 * self._per_axis
        for axis, moving in self.moving_axes.items():
            start[axis], size[axis] = moving.start, moving.size
        doublings = max((self.moving_axes[axis].doublings for axis in axes), default=0)
        return PointRefinement(axes, start, size / self._per_axis, self._per_axis, doublings)


def _array(layouts, name):
    """(3, 2) numbers of layouts; zero along axes that do not move."""
    return np.array([getattr(layouts[a], name) if a in layouts else (0, 0) for a in range(3)])


def _layouts(ground, moving_axes):
    return {axis: AxisLayout(tuple(ground.fine[axis].tolist()), tuple(ground.window[axis].tolist()))
            for axis in moving_axes}


def _is_shared(model):
    """Whether several processes have a block of the grid each."""
    return model.soil.grid.nodes is not None


def _at_standstill(points):
    """Points without any velocity or acceleration."""
    rest = {name: np.zeros_like(getattr(points, name)) for name in ("velocity", "acceleration", "algorithmic", "affine")
            if getattr(points, name) is not None}
    return replace(points, **rest)


def _with_ground(model, grid, ground):
    """`model` with the points of a Ground on its `grid`."""
    return model.with_soil(replace(model.soil, grid=grid, constants=ground.constants,
                                   law=model.soil.law.with_rows(ground.rows)))


def _without_contact(contacts, n):
    """(n,) bool, points without a place that contact follows."""
    free = np.ones(n, bool)
    for contact in contacts:
        free[contact.point] = False
    return free


def _renumbered(contact, origin, before):
    """ContactHistory by the new numbers of its points; those on points that were removed are dropped.

    origin: former numbers of the first new points, -1 for those that are really new; before: former number of points.
    """
    number = np.full(before, -1)
    number[origin[origin >= 0]] = np.flatnonzero(origin >= 0)
    point = number[contact.point]
    stay = np.flatnonzero(point >= 0)
    stay = stay[np.argsort(point[stay], kind="stable")]
    own = ("place", "position", "touching", "anchor", "side", "rest", "opened")
    return replace(contact, point=point[stay], **{name: getattr(contact, name)[stay] for name in own})
