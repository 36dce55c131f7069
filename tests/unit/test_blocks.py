"""Blocks of a grid: their nodes are those of the whole grid, however often blocks are cut, and reach as far as they have
to."""

from dataclasses import replace

import numpy as np
import pytest

from hybrid.grid.axes import FACES, cell_numbers, cells_of, make_grid
from hybrid.grid.blocks import block_of, cut_block, cut_into_blocks
from hybrid.runtime.errors import SceneError
from hybrid.state import ContactHistory
from hybrid.step import processes

EXTENT = np.array([(0.0, 5.0), (-1.0, 3.0), (-2.0, 2.0)])
AXES = (np.array([0.0, 1.0, 2.0, 2.5, 3.0, 4.0, 5.0]), np.linspace(-1.0, 3.0, 5), np.linspace(-2.0, 2.0, 5))
FREE = dict.fromkeys(FACES, "free")


def grids():
    held = FREE | {"x_min": "roller", "y_max": "fixed", "z_min": "fixed"}
    flat = AXES[0], np.array([1.0]), AXES[2]
    return [make_grid(AXES, EXTENT, held), make_grid(AXES, EXTENT, FREE), make_grid(flat, EXTENT, held),
            make_grid(AXES, EXTENT, FREE, all_fixed=True)]


def places(n=300, seed=1):
    rng = np.random.default_rng(seed)
    return EXTENT[:, 0] + rng.random((n, 3)) ** 2 * np.ptp(EXTENT, axis=1)


def points_in_cells(position, grid):
    """(a, b, c) number of positions in each cell."""
    numbers, shape = cell_numbers(position, grid)
    return np.bincount(numbers, minlength=np.prod(shape)).reshape(shape)


@pytest.mark.parametrize("grid", grids())
def test_nodes_of_a_block_are_those_of_the_grid(grid):
    loads = points_in_cells(places(), grid)
    for rank in range(3):
        block = cut_block(grid, loads, 3, rank)
        again = cut_block(cut_block(grid, loads[::-1, ::-1, ::-1], 3, 1), loads, 3, rank)    # from a Block of others
        at = np.ix_(*(np.searchsorted(whole, own) for whole, own in zip(grid.axes, block.axes)))
        numbers = np.arange(grid.node_count).reshape(grid.shape)[at].ravel()
        for one in (block, again):
            assert np.array_equal(one.fixed, grid.fixed[numbers]) and np.array_equal(one.volumes, grid.volumes[numbers])
            assert one.smallest_cell == grid.smallest_cell and np.array_equal(one.boxes, block.boxes)
        assert np.array_equal(again.nodes.owned, block.nodes.owned)


def test_every_cell_and_point_has_one_owner_and_shares_are_even():
    grid = grids()[0]
    position, loads = places(), points_in_cells(places(), grid)
    assert loads.sum() == len(position)
    blocks = [cut_block(grid, loads, 4, rank) for rank in range(4)]
    share = np.bincount(blocks[0].owner(position), minlength=4)
    assert share.max() == pytest.approx(blocks[0].fullest * len(position)) and blocks[0].fullest < 1.3 / 4
    covered = np.zeros(loads.shape, int)
    for low, high in cut_into_blocks(loads, 4):
        covered[tuple(slice(a, b) for a, b in zip(low, high))] += 1
    assert (covered == 1).all()


def test_blocks_have_equal_work_where_a_body_touches_the_soil(monkeypatch):
    """Contact points count with their soil points: those on one side move the cut towards it."""
    axes = tuple(np.arange(n + 1.0) for n in (24, 2, 2))
    grid = make_grid(axes, np.array([(x[0], x[-1]) for x in axes]), FREE)
    position = np.random.default_rng(5).random((4000, 3)) * [24.0, 2.0, 2.0]
    touched = np.repeat(np.flatnonzero(position[:, 0] < 6.0), 6)
    contacts = [replace(ContactHistory.empty(), point=touched)]
    monkeypatch.setattr(processes.ranks, "started", lambda: 2)

    def fullest(contacts):
        block = processes._cut_anew(grid, position, contacts)
        owner = block.owner(position)
        work = processes.POINT * np.bincount(owner) + processes.CONTACT * np.bincount(owner[touched], minlength=2)
        return work.max() / work.sum(), block.fullest

    without, _ = fullest([])
    found, known = fullest(contacts)
    assert without > 0.65 and found < 0.55 and known == pytest.approx(found)


def test_soil_in_a_single_cell_leaves_blocks_empty_until_there_are_too_few_cells():
    loads = np.zeros((1, 1, 3), int)
    loads[0, 0, 1] = 8
    assert sorted(loads[0, 0, low:high].sum() for (_, _, low), (_, _, high) in cut_into_blocks(loads, 3)) == [0, 0, 8]
    with pytest.raises(SceneError, match="run on one rank, or on fewer"):
        cut_into_blocks(loads, 4)


def test_layers_reach_to_places_far_from_the_own_cells():
    grid = grids()[0]
    block = cut_block(grid, points_in_cells(places(), grid), 2, 0)
    low, high = block.boxes[0]
    assert block.layers == block.layers_for(places()[:0]) == 1
    far = places()[np.argmax(cells_of(places(), grid.axes)[:, 0])][None]
    beyond = cells_of(far, grid.axes)[0, 0] + 1 - high[0]
    assert block.layers_for(far) == beyond > 1
    wide = block_of(block, block.boxes, 0, block.fullest, beyond)
    assert wide.axes[0][-1] >= far[0, 0] > block.axes[0][-1] and wide.fullest == block.fullest
