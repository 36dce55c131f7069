"""Points and nodes of a run by several processes: who makes them, how they move to new owners, gathered for a picture.

From the start on each process has the points in the cells of its block (`hybrid.grid.blocks`), in the order of their
numbers in the whole run, their constants, their rows of the law and what contact remembers of them. Points that a moving
grid has left behind stay with the process that had them. Bodies and their surfaces are in all processes.

A block's load is the work on it: POINT of a point and CONTACT of a contact point, which lives with its soil point. Blocks
of equal loads are cut anew where the share of the fullest one has become GROWN times as large, and for every new grid.
"""

from contextlib import suppress
from dataclasses import replace

import numpy as np

from hybrid.grid.axes import cell_numbers
from hybrid.grid.blocks import block_of, cut_block
from hybrid.runtime import comm, ranks
from hybrid.runtime.errors import SceneError
from hybrid.soil.parcels import behind_together, named, placed, rows, together, without_numbers
from hybrid.soil.split_merge import select
from hybrid.state import Population

GROWN = 1.2
POINT, CONTACT = 2, 1   # times on one process that drags the anchor: 0.44 of a point for contact and its search


# ------------------------------------------------------------------ the part of each process at the start


def first_block(grid, counts):
    """(Block of this process from the whole grid, (a, b, c) bool its own cells) for numbers of points `counts` (a, b, c)
    in the cells, from which on each process holds only its share of all values."""
    block = cut_block(grid, counts, ranks.started(), ranks.rank())
    comm.split()
    low, high = block.boxes[ranks.rank()]
    own = np.zeros(counts.shape, bool)
    own[tuple(map(slice, low, high))] = True
    return block, own


def share(counts):
    """(a, b, c) bool, cells whose points, of numbers `counts` (a, b, c), this process makes before they go to their
    owners: a nearly equal share, in the order of the cells, however few cells they are in."""
    before = np.cumsum(counts).reshape(counts.shape) - counts
    return before * ranks.started() // max(counts.sum(), 1) == ranks.rank()


def balanced(model, state):
    """(Model, State) at the start with the points, and what contact remembers of them, in blocks of equal loads."""
    return (model, state) if model.soil.grid.nodes is None else _settled(model, state)


def keeps(model, state):
    """Function of the numbers (n,) of points in the run: which of them, (n,) bool, this process takes from a checkpoint
    of a run that starts with `model` and `state`. These are the points whose constants it has; where a grid moves
    constants are in the checkpoint, and any equal share will do."""
    if state.ground is not None:
        return lambda numbers: numbers % ranks.started() == ranks.rank()
    return lambda numbers: np.isin(numbers, model.soil.constants.number) | (numbers < 0) & (ranks.rank() == 0)


def resumed(model, state, number):
    """(Model, State) of this process from its model and what it has taken of a checkpoint: a `state` with named contacts and
    the numbers (n,) of its points, increasing."""
    contacts = placed(state.contacts, number)
    if state.ground is None:
        assert np.array_equal(number, model.soil.constants.number), "points were lost"
        return _settled(model, replace(state, contacts=contacts))
    here = Population(state.points, replace(state.ground.constants, number=number), state.ground.rows)
    block, here, contacts = on_new_grid(model.soil.grid, here, contacts)
    return _with_points(model, state, here, contacts, block)


# ------------------------------------------------------------------ from process to process


def settle(model, state, workspace):
    """(Model, State) after all points have gone to the processes in whose cells they lie, of new blocks where the present
    ones have become uneven."""
    if model.soil.grid.nodes is None:
        return model, state
    new, state = _settled(model, state)
    if new.soil.grid is not model.soil.grid:
        workspace.renew(new)
    elif new is not model:
        workspace.follow_points(new)
    return new, state


def _settled(model, state):
    soil, position = model.soil, state.points.position
    block, owner = soil.grid, soil.grid.owner(position)
    here, contacts = Population(state.points, soil.constants, soil.law.rows), state.contacts
    loads = comm.counts(_sums(owner, contacts, ranks.started()))
    if loads.max() > GROWN * block.fullest * loads.sum():
        with suppress(SceneError):      # all points may have come together in fewer cells than there are processes
            block = _cut_anew(block, position, contacts)
            owner = block.owner(position)
    moves = comm.anywhere(owner != ranks.rank())
    if moves:
        here, contacts = moved(owner, here, contacts)
    block = _around_contacts(block, contacts)
    return _with_points(model, state, here, contacts, block) if moves or block is not soil.grid else (model, state)


def _cut_anew(grid, position, contacts):
    """Block of this process with a nearly equal share of the load of points at `position` (n, 3) [m] and of their
    contacts."""
    cell, shape = cell_numbers(position, grid)
    loads = comm.counts(_sums(cell, contacts, int(np.prod(shape)))).reshape(shape)
    return cut_block(grid, loads, ranks.started(), ranks.rank())


def _sums(place, contacts, length):
    """Loads (length,) of the cells, or blocks, `place` (n,) of points with `contacts`."""
    loads = POINT * np.bincount(place, minlength=length)
    for history in contacts:
        loads += CONTACT * np.bincount(place[history.point[history.point >= 0]], minlength=length)
    return loads


def _around_contacts(block, contacts):
    """The Block, with more layers of cells around it where contact points have drifted beyond those that it has."""
    layers = int(comm.largest([block.layers_for(history.position) for history in contacts]))
    return block_of(block, block.boxes, ranks.rank(), block.fullest, layers) if layers > block.layers else block


def moved(owner, population, contacts):
    """(Population, contacts) of this process after its points, with their contacts, have gone to their `owner` (n,)."""
    parcels, known = [], named(contacts, population.constants.number)
    for other in range(ranks.started()):
        goes = owner == other
        parcels.append((select(population, goes),
                        [rows(history, np.where(old.point < 0, other == 0, goes[old.point]))   # places on bodies: the first
                         for history, old in zip(known, contacts)]))
    population, known = together(comm.to_each(parcels))
    return population, placed(known, population.constants.number)


def _with_points(model, state, population, contacts, block):
    """(Model, State) with a population and its contacts on a Block."""
    constants, of_law = population.constants, population.rows
    model = model.with_soil(replace(model.soil, grid=block, constants=constants, law=model.soil.law.with_rows(of_law)))
    ground = state.ground and replace(state.ground, constants=constants, rows=of_law)
    return model, replace(state, points=population.points, contacts=contacts, ground=ground)


# ------------------------------------------------------------------ a grid that moves


def numbered(population, new, behind):
    """`population` with numbers of its points `new` (n,) bool: after all others and those `behind` (Population or None),
    in the order of the initial places of the new points of all processes."""
    constants = population.constants
    number, place = constants.number.copy(), constants.position[new]
    others = [number[~new].astype(float)] + ([] if behind is None else [behind.constants.number])
    order = np.lexsort(comm.gathered(place).T)
    mine = np.argsort(order)[comm.offset(len(place)):][:len(place)]
    number[new] = 1 + int(comm.maximum(np.concatenate(others), -1)) + mine
    return replace(population, constants=replace(constants, number=number))


def with_nodes_at(model, lines):
    """Model of this process whose nodes have moved to `lines` [m] by axis and have kept their numbers."""
    old = model.soil.grid
    if old.nodes is None:
        grid = replace(old, axes=lines)
    else:
        grid = block_of(replace(old, lines=lines), old.boxes, old.rank, old.fullest, old.layers)
    vars(grid).update(smallest_cell=old.smallest_cell, resolution=old.resolution)   # what goes by them stays as it is
    return model.with_soil(replace(model.soil, grid=grid))


def on_new_grid(grid, population, contacts):
    """(Block, Population, contacts) of this process for a new `grid`, the whole one."""
    block = _cut_anew(grid, population.points.position, contacts)
    population, contacts = moved(block.owner(population.points.position), population, contacts)
    return _around_contacts(block, contacts), population, contacts


# ------------------------------------------------------------------ to the first process


def gather(model, state):
    """(State, initial positions (n, 3) [m]) of the whole run in the first process, (None, None) in the others."""
    constants = model.soil.constants
    here = Population(state.points, constants, model.soil.law.rows if state.ground else np.zeros((len(constants), 0)))
    parcels = comm.to_first((here, named(state.contacts, constants.number), state.ground and state.ground.behind))
    if parcels is None:
        return None, None
    points, contacts = together([parcel[:2] for parcel in parcels])
    number = points.constants.number
    assert (np.diff(number) > 0).all() and (state.ground or len(number) == number.max(initial=-1) + 1), "points were lost"
    points = without_numbers(points)
    ground = state.ground and replace(state.ground, constants=points.constants, rows=points.rows,
                                      behind=without_numbers(behind_together([parcel[2] for parcel in parcels])))
    return replace(state, points=points.points, contacts=placed(contacts, number), ground=ground), points.constants.position
