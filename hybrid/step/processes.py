"""Points and nodes of a run by several processes: split at the start, moved to their new owners, gathered for output.

Each process has the points in the cells of its block (`hybrid.grid.blocks`), in the order of their numbers in the whole run,
their constants, their rows of the law and what contact remembers of them. Points that a moving grid has left behind stay with
the process that had them. Bodies and their surfaces are in all processes.

Blocks are cut anew where the points of the fullest one have become GROWN times as many, and for every new grid.
"""

from contextlib import suppress
from dataclasses import fields, replace

import numpy as np

from hybrid.grid.blocks import Block, block_of, cut_block, points_in_cells
from hybrid.runtime import comm, ranks
from hybrid.runtime.errors import SceneError
from hybrid.soil.split_merge import concatenate, select
from hybrid.state import ContactHistory, PointConstants, Population

GROWN = 1.2


def refuse(law):
    """SceneError for what several processes cannot do together: a user's law."""
    if ranks.started() > 1 and law is not None:
        raise SceneError("--ranks: a law of your own (soil.material.law = 'user') is not possible on several ranks; run this "
                         "scene on one rank")


# ------------------------------------------------------------------ from all points to those of each process


def split(model, state):
    """(Model, State) of this process from those of the whole run, which every process has made."""
    soil, n = model.soil, len(state.points)
    with comm.alone():
        block = _cut_anew(soil.grid, state.points.position)
    comm.split()
    mine = block.owner(state.points.position) == ranks.rank()
    everything = Population(state.points, replace(soil.constants, number=np.arange(n)), soil.law.rows)
    contacts = [_renumbered(_rows(history, mine[history.point]), np.flatnonzero(mine)) for history in state.contacts]
    if state.ground is not None and state.ground.behind is not None:
        behind = state.ground.behind
        behind = replace(behind, constants=replace(behind.constants, number=n + np.arange(len(behind))))
        state = replace(state, ground=replace(state.ground, behind=select(behind, share())))
    model, state = _with_points(model, state, select(everything, mine), contacts, block)
    assert len(state.points) < n, "one process holds all points"
    return model, state


def share():
    """Slice of the part of this process of items that every process has."""
    return slice(ranks.rank(), None, ranks.started())


def resumed(model, state):
    """(Model, State) of this process from its present model, or that of the whole run, and a `state` of all points."""
    if not isinstance(model.soil.grid, Block):
        return split(model, state)
    numbers = model.soil.constants.number
    of_points = select(Population(state.points, _placeless(len(state.points)), np.zeros((len(state.points), 0))), numbers)
    contacts = [_renumbered(_rows(history, np.isin(history.point, numbers)), numbers) for history in state.contacts]
    return _settled(model, replace(state, points=of_points.points, contacts=contacts))


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
    moves = comm.anywhere(owner != ranks.rank())
    if moves:
        if comm.counts(np.bincount(owner, minlength=ranks.started())).max() > GROWN * block.fullest:
            with suppress(SceneError):      # all points may have come together in fewer cells than there are processes
                block = _cut_anew(block, position)
                owner = block.owner(position)
        here, contacts = moved(owner, here, contacts)
    block = _around_contacts(block, contacts)
    return _with_points(model, state, here, contacts, block) if moves or block is not soil.grid else (model, state)


def _cut_anew(grid, position):
    """Block of this process with nearly equal shares of the points at `position` (n, 3) [m]."""
    return cut_block(grid, comm.counts(points_in_cells(position, grid)), ranks.started(), ranks.rank())


def _around_contacts(block, contacts):
    """The Block, with more layers of cells around it where contact points have drifted beyond those that it has."""
    layers = int(comm.largest([block.layers_for(history.position) for history in contacts]))
    return block_of(block, block.boxes, ranks.rank(), block.fullest, layers) if layers > block.layers else block


def moved(owner, population, contacts):
    """(Population, contacts) of this process after its points, with their contacts, have gone to their `owner` (n,)."""
    number, parcels = population.constants.number, []
    named = [replace(history, point=number[history.point]) for history in contacts]
    for other in range(ranks.started()):
        goes = owner == other
        parcels.append((select(population, goes), [_rows(history, goes[old.point])
                                                   for history, old in zip(named, contacts)]))
    population, named = _together(comm.to_each(parcels))
    return population, [_renumbered(history, population.constants.number) for history in named]


def _together(parcels):
    """(Population, ContactHistory of each body with the points' numbers in the run), sorted, of parcels of both."""
    points = parcels[0][0]
    for more, _ in parcels[1:]:
        points = concatenate(points, more)
    points = select(points, np.argsort(points.constants.number, kind="stable"))
    contacts = []
    for pieces in zip(*(histories for _, histories in parcels)):
        whole = ContactHistory(*(np.concatenate([getattr(piece, field.name) for piece in pieces])
                                 for field in fields(ContactHistory)))
        contacts.append(_rows(whole, np.lexsort((whole.place, whole.point))))
    return points, contacts


def _with_points(model, state, population, contacts, block):
    """(Model, State) with a population and its contacts on a Block."""
    constants, rows = population.constants, population.rows
    model = model.with_soil(replace(model.soil, grid=block, constants=constants, law=model.soil.law.with_rows(rows)))
    ground = state.ground and replace(state.ground, constants=constants, rows=rows)
    return model, replace(state, points=population.points, contacts=contacts, ground=ground)


def _renumbered(history, numbers):
    """ContactHistory with the places of its points among `numbers`, increasing."""
    return replace(history, point=np.searchsorted(numbers, history.point))


def _rows(history, chosen):
    return ContactHistory(*(getattr(history, field.name)[chosen] for field in fields(ContactHistory)))


def _placeless(n):
    """Constants of n points that nobody reads."""
    return PointConstants(np.zeros((n, 0)), np.zeros((n, 0)), np.zeros(n), np.zeros(n))


# ------------------------------------------------------------------ a grid that moves


def numbered(population, new, behind):
    """`population` with numbers of its points `new` (n,) bool: after all others and those `behind` (Population or None), in the
    order of the initial places of the new points of all processes."""
    constants = population.constants
    number, place = constants.number.copy(), constants.position[new]
    others = [number[~new].astype(float)] + ([] if behind is None else [behind.constants.number])
    order = np.lexsort(comm.joined(place).T)
    mine = np.argsort(order)[comm.offset(len(place)):][:len(place)]
    number[new] = 1 + int(comm.maximum(np.concatenate(others), -1)) + mine
    return replace(population, constants=replace(constants, number=number))


def on_new_grid(grid, population, contacts):
    """(Block, Population, contacts) of this process for a new `grid`, the whole one."""
    block = _cut_anew(grid, population.points.position)
    population, contacts = moved(block.owner(population.points.position), population, contacts)
    return _around_contacts(block, contacts), population, contacts


# ------------------------------------------------------------------ to the first process


def gather(model, state):
    """(State, initial positions (n, 3) [m]) of the whole run in the first process, (None, None) in the others."""
    constants = model.soil.constants
    here = Population(state.points, constants, model.soil.law.rows if state.ground else np.zeros((len(constants), 0)))
    named = [replace(history, point=constants.number[history.point]) for history in state.contacts]
    parcels = comm.to_first((here, named, state.ground and state.ground.behind))
    if parcels is None:
        return None, None
    points, contacts = _together([parcel[:2] for parcel in parcels])
    number = points.constants.number
    assert (np.diff(number) > 0).all() and (state.ground or len(number) == number.max(initial=-1) + 1), "points were lost"
    contacts = [_renumbered(history, number) for history in contacts]
    ground = state.ground and replace(state.ground, constants=replace(points.constants, number=None), rows=points.rows,
                                      behind=_behind([parcel[2] for parcel in parcels]))
    return replace(state, points=points.points, contacts=contacts, ground=ground), points.constants.position


def _behind(populations):
    """All points left behind, in the order of their numbers, without these; None where none are kept."""
    parcels = [(one, []) for one in populations if one is not None]
    if not parcels:
        return None
    behind, _ = _together(parcels)
    return replace(behind, constants=replace(behind.constants, number=None))
