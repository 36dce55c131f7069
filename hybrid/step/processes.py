"""Points and nodes of a run by several processes: split at the start, moved to their new owners, gathered for output.

Each process has the points in the cells of its block (`hybrid.grid.blocks`), in the order of their numbers in the whole run,
their constants, their rows of the law and what contact remembers of them. Bodies and their surfaces are in all processes.
"""

from dataclasses import fields, replace

import numpy as np

from hybrid.grid.blocks import block_of, cells_of, cut_into_blocks
from hybrid.runtime import comm, ranks
from hybrid.runtime.errors import SceneError
from hybrid.soil.split_merge import concatenate, select
from hybrid.state import ContactHistory, PointConstants, Population


def refuse(scene, law):
    """SceneError for what several processes cannot do together."""
    if ranks.started() == 1:
        return
    unable = [(scene.grid.moves, "a grid that follows a body (grid.*.around)"), (scene.soil.held, "held soil (soil.held)"),
              (law is not None, "a law of your own (soil.material.law = 'user')"),
              (any(body.adhesion or body.tension for body in scene.bodies), "clay that sticks (body.adhesion, body.tension)"),
              (scene.soil.stray != "stop", f"soil.stray = {scene.soil.stray!r}")]
    for found, what in unable:
        if found:
            raise SceneError(f"--ranks: {what} is not possible on several ranks; run this scene on one rank")


def split(model, state):
    """(Model, State) of this process from those of the whole run, which every process has made."""
    soil, grid = model.soil, model.soil.grid
    cells = np.zeros([max(1, n - 1) for n in grid.shape], int)
    np.add.at(cells, tuple(cells_of(state.points.position, grid.axes).T), 1)
    block = block_of(grid, cut_into_blocks(cells, ranks.started()), ranks.rank())
    constants = replace(soil.constants, number=np.arange(len(state.points)))
    mine = block.owner(state.points.position) == ranks.rank()
    comm.split()
    contacts = [_rows(history, mine[history.point]) for history in state.contacts]
    model, state = _with_points(replace_soil(model, grid=block), replace(state, contacts=[]), select(
        Population(state.points, constants, soil.law.rows), mine), contacts)
    assert len(state.points) < comm.number(state.points), "one process holds all points"
    return model, state


def resumed(model, state):
    """(Model, State) of this process from its present model and a `state` of all points."""
    numbers = model.soil.constants.number
    of_points = select(Population(state.points, _placeless(len(state.points)), np.zeros((len(state.points), 0))), numbers)
    contacts = [_renumbered(_rows(history, np.isin(history.point, numbers)), numbers) for history in state.contacts]
    return _settled(model, replace(state, points=of_points.points, contacts=contacts))


def settle(model, state, workspace):
    """(Model, State) after all points have gone to the processes in whose cells they lie."""
    if model.soil.grid.nodes is None:
        return model, state
    new, state = _settled(model, state)
    if new is not model:
        workspace.follow_points(new)
    return new, state


def _settled(model, state):
    soil = model.soil
    owner = soil.grid.owner(state.points.position)
    if not comm.anywhere(owner != ranks.rank()):
        return model, state
    here, numbers = Population(state.points, soil.constants, soil.law.rows), soil.constants.number
    named = [replace(history, point=numbers[history.point]) for history in state.contacts]
    parcels = []
    for other in range(ranks.started()):
        goes = owner == other
        parcels.append((select(here, goes), [_rows(history, goes[old.point])
                                             for history, old in zip(named, state.contacts)]))
    arrived = comm.to_each(parcels)
    points, contacts = _together(arrived)
    return _with_points(model, state, points, contacts)


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


def _with_points(model, state, population, contacts):
    """(Model, State) with a population and contacts whose points have the numbers of the run."""
    constants = population.constants
    model = replace_soil(model, constants=constants, law=model.soil.law.with_rows(population.rows))
    contacts = [_renumbered(history, constants.number) for history in contacts]
    return model, replace(state, points=population.points, contacts=contacts)


def replace_soil(model, **changes):
    """The same model with changes of its soil."""
    return model.with_soil(replace(model.soil, **changes))


def _renumbered(history, numbers):
    """ContactHistory with the places of its points among `numbers`, increasing."""
    return replace(history, point=np.searchsorted(numbers, history.point))


def _rows(history, chosen):
    return ContactHistory(*(getattr(history, field.name)[chosen] for field in fields(ContactHistory)))


def _placeless(n):
    """Constants of n points that nobody reads."""
    return PointConstants(np.zeros((n, 0)), np.zeros((n, 0)), np.zeros(n), np.zeros(n))


def gather(model, state):
    """(State, initial positions (n, 3) [m]) of the whole run in the first process, (None, None) in the others."""
    constants = model.soil.constants
    here = Population(state.points, constants, np.zeros((len(constants), 0)))
    named = [replace(history, point=constants.number[history.point]) for history in state.contacts]
    parcels = comm.to_first((here, named))
    if parcels is None:
        return None, None
    points, contacts = _together(parcels)
    assert np.array_equal(points.constants.number, np.arange(len(points))), "points were lost between processes"
    return replace(state, points=points.points, contacts=contacts), points.constants.position


