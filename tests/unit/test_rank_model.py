"""Time on many processes by the model: sizes of blocks are those of the plans, and one process takes what the record
says."""

import copy
import json

import numpy as np
import pytest

from hybrid.bench import pages, rank_model
from hybrid.bench.block_sizes import sizes
from hybrid.grid.axes import FACES, make_grid
from hybrid.grid.blocks import cut_block

RECORD = json.loads((pages.ROOT / pages.RECORD).read_text(encoding="utf-8"))
ROLLERS = dict.fromkeys(FACES, "roller") | {"z_max": "free"}


@pytest.mark.parametrize("ranks", [2, 4, 8])
@pytest.mark.parametrize("cells", [(8, 8, 4), (11, 6, 5)])
def test_sizes_are_those_of_the_plans(cells, ranks):
    axes = tuple(np.arange(n + 1.0) for n in (*cells[:2], cells[2] + 2))
    grid = make_grid(axes, np.array([(nodes[0], nodes[-1]) for nodes in axes]), ROLLERS)
    points = np.zeros((*cells[:2], cells[2] + 2), int)
    points[:, :, :cells[2]] = 8
    found = sizes(cells, ranks)
    assert found.share.sum() == pytest.approx(1) and found.share.max() < 1.5 / ranks
    for rank in range(ranks):
        block = cut_block(grid, points, ranks, rank)
        plan, height = block.nodes, np.broadcast_to(block.axes[2], block.shape).ravel()
        free = (~block.fixed & (height <= cells[2])[:, None]).sum(axis=1)
        given, copied = (sum(free[at].sum() for at in one.values()) for one in (plan.given, plan.copies))
        assert (found.own[rank], found.copies[rank], found.given[rank]) == (free[plan.owned].sum(), copied, given)
        assert found.nodes[rank] == plan.owned.sum() and found.copied_nodes[rank] == (~plan.owned).sum()
        assert found.given_nodes[rank] == sum(map(len, plan.given.values()))
        assert found.neighbours[rank] == len(plan.given.keys() | plan.copies.keys())
        assert found.overlap[rank] <= found.copies[rank]


def test_sizes_are_those_that_were_counted():
    assert rank_model.largest_difference(RECORD) < 1e-6
    assert {row["ranks"] for row in RECORD["cases"]["exchange"]["rows"]} == {1, 2, 4, 8}


def test_one_process_takes_what_was_recorded():
    block, large, drag = rank_model.runs(RECORD)
    row = RECORD["cases"]["ranks"]["rows"][0]
    assert sum(rank_model.step(block, 1, RECORD).values()) == pytest.approx(row["s"] / row["steps"], rel=1e-12)
    phases = RECORD["cases"]["scaling"]["rows"][-1]
    assert sum(rank_model.step(large, 1, RECORD).values()) == pytest.approx(
        sum(phases[key] for key in phases if key.endswith(" [s]")), rel=1e-12)
    assert large.points == phases["points"] and drag.points == pytest.approx(10e6, rel=0.01)


def test_without_a_network_processes_only_share_the_work(monkeypatch):
    for name in ("LATENCY", "CALLS", "COMBINED"):
        monkeypatch.setattr(rank_model, name, 0.0)
    monkeypatch.setattr(rank_model, "BANDWIDTH", np.inf)
    monkeypatch.setattr(rank_model, "fixed_part", lambda record: 0.0)
    block = rank_model.runs(RECORD)[0]
    alone, eight = (rank_model.step(block, ranks, RECORD) for ranks in (1, 8))
    assert sum(eight[name] for name in ("messages", "reductions")) == 0.0
    assert eight["points"] == pytest.approx(alone["points"] / 8)
    growth = 8 ** rank_model.exchanged(RECORD)["growth"]
    assert 1.0 < eight["linear solver"] / (alone["linear solver"] / 8 * growth) < 1.3


def test_a_slower_network_takes_longer_and_more_where_there_are_more_processes(monkeypatch):
    drag = rank_model.runs(RECORD)[2]

    def messages(ranks):
        parts = rank_model.step(drag, ranks, RECORD)
        return parts["messages"] + parts["reductions"]

    fast = messages(8), messages(64)
    monkeypatch.setattr(rank_model, "LATENCY", 100 * rank_model.LATENCY)
    assert messages(64) - fast[1] > messages(8) - fast[0] > 0


def test_growth_of_iterations_is_the_fitted_power():
    changed = copy.deepcopy(RECORD)
    for row in changed["cases"]["exchange"]["rows"]:
        row["Krylov"] = 100 * row["ranks"] ** 0.25
    assert rank_model.exchanged(changed)["growth"] == pytest.approx(0.25)
