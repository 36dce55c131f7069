"""How many processes a run takes by itself: more than one for much soil only, and as memory and cores allow."""

from dataclasses import replace
from math import inf

import pytest

from hybrid.runtime import ranks
from hybrid.scene import Solver
from hybrid.setup.best_ranks import best_ranks
from hybrid.study.scenes import soil_scene

GIB = 2.0**30


def block(cells, **soil):
    """Scene of cells³ cells full of soil, 8 points in each."""
    return soil_scene(x=(0.0, cells), y=(0.0, cells), z=(-cells, 0.0), size=1.0, solver=Solver(), points_per_axis=2, **soil)


@pytest.mark.parametrize("cells, cores, memory, expected", [
    (36, 64, inf, 1),               # 373 248 points
    (37, 64, inf, 4),               # 405 224
    (60, 64, inf, 17),              # 1 728 000
    (60, 4, inf, 4), (60, 2, inf, 1),
    (60, 64, 80 * GIB, 17), (60, 64, 17 * GIB, 7), (60, 64, 15.5 * GIB, 1),     # grid and soil need 14.8
])
def test_processes_are_as_many_as_points_cores_and_memory_allow(cells, cores, memory, expected):
    number, points = best_ranks(block(cells), cores, memory)
    assert number == expected and points in (0, 8 * cells**3)


def test_held_soil_and_a_grid_that_follows_a_body_are_for_one():
    assert best_ranks(block(60, held=True), 8, inf)[0] == 1
    large = block(60)
    moving = replace(large, grid=replace(large.grid, x=replace(large.grid.x, window=(3.0, 3.0), growth=1.4)))
    assert moving.grid.moves and best_ranks(moving, 8, inf)[0] == 1


def test_threads_that_are_set_and_a_scheduler_leave_the_number_alone(monkeypatch):
    for name in (*ranks.STARTED, "NUMBA_NUM_THREADS"):
        monkeypatch.delenv(name, raising=False)
    assert ranks.may_start()
    for name in ("NUMBA_NUM_THREADS", "OMPI_COMM_WORLD_SIZE"):
        with monkeypatch.context() as patch:
            patch.setenv(name, "1")
            assert not ranks.may_start()


def test_where_mpirun_fails_no_more_than_one_can_start(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    assert not ranks.can_start(2)
    (tmp_path / "mpirun").write_text("#!/bin/sh\nexit 1\n")
    (tmp_path / "mpirun").chmod(0o755)
    assert not ranks.can_start(2)
