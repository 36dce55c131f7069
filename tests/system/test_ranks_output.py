"""Frames in pieces: what several processes write is what one writes, and opens as one."""

import json
import os
import shutil
import subprocess
import sys

import numpy as np
import pytest
from rank_runs import COLUMN, hybrid, needs_mpirun, patched, program, scene_file

from hybrid.output.vtk import read_pvd

pyvista = pytest.importorskip("pyvista")
pytestmark = needs_mpirun

EACH_STEP = COLUMN.replace("every = 2, checkpoint = 2", "every = 1, checkpoint = 1").replace("steps = 4", "steps = 3")


def run(folder, *arguments, ranks=1, patch="", fails=False):
    """stderr of a run of the column into a folder, with frames and checkpoints of each of its 3 steps."""
    if not patch:
        return hybrid("run", scene_file(folder.parent, EACH_STEP), "--out", folder, "--ranks", ranks, *arguments)
    script = patched(folder.parent / "script.py", patch)
    return program(script, "run", scene_file(folder.parent, EACH_STEP), "--out", folder, *arguments, ranks=ranks,
                   fails=fails)


def files(folder):
    return [name for name, _ in read_pvd(folder / "soil.pvd")]


def in_order(grid):
    """Coordinates and fields of a frame, in the order of the points' numbers."""
    order = np.argsort(grid["number"]) if "number" in grid.point_data else np.arange(grid.n_points)
    return {"points": grid.points[order],
            **{name: np.asarray(grid[name])[order] for name in grid.point_data if name != "number"}}


def test_pieces_are_the_frame_of_one_process_and_go_on_with_any_number(tmp_path):
    one, two, mixed = tmp_path / "one", tmp_path / "two", tmp_path / "mixed"
    run(one)
    run(two, ranks=2)
    assert files(two) == [f"soil_00000{step}.pvtu" for step in range(4)]
    pieces = [pyvista.read(two / f"soil_000002_r{rank}.vtu").n_points for rank in range(2)]
    assert sum(pieces) == 256 and min(pieces) > 64
    found, expected = (in_order(pyvista.read(folder / files(folder)[2])) for folder in (two, one))
    assert found.keys() == expected.keys()
    for name, values in expected.items():
        np.testing.assert_allclose(found[name], values, rtol=0, atol=1e-6 * max(np.abs(values).max(), 1e-3), err_msg=name)
    shutil.copytree(two, mixed)
    run(mixed, "--resume", "--set", "stage.settle.steps=4")
    run(mixed, "--resume", "--set", "stage.settle.steps=5", ranks=3)
    assert files(mixed) == [*files(two), "soil_000004.vtu", "soil_000005.pvtu"]
    assert pyvista.read(mixed / "soil_000005.pvtu").n_points == 256 and (mixed / "soil_000005_r2.vtu").exists()


FULL = """
import errno, sys
from hybrid.output import pieces
from hybrid.runtime import ranks
write = pieces.write_vtu
def full(path, mesh):
    if ranks.rank() == 1 and "000002" in path.name:
        raise OSError(errno.ENOSPC, "No space left on device", str(path))
    write(path, mesh)
pieces.write_vtu = full
"""


def test_a_piece_that_cannot_be_written_ends_all_once_and_the_frame_is_not_listed(tmp_path):
    text = run(tmp_path / "out", ranks=2, patch=FULL, fails=True)
    assert text.count("No space left on device; process 1") == 1 and "soil_000002_r1.vtu: cannot be written" in text
    assert files(tmp_path / "out") == ["soil_000000.pvtu", "soil_000001.pvtu"]
    run(tmp_path / "out", "--resume", ranks=2)
    assert files(tmp_path / "out") == [f"soil_00000{step}.pvtu" for step in range(4)]


BEST = """
import os, sys
from hybrid.setup import best_ranks
best_ranks.PER_PROCESS, best_ranks.FEWEST = 100, 2
os.sched_getaffinity = lambda _: {0, 1, 2}
"""


def test_a_run_becomes_as_many_processes_as_are_worth_it_and_says_so(tmp_path):
    """256 points, 100 for each process; one where mpirun cannot start any."""
    script, path = patched(tmp_path / "best.py", BEST), scene_file(tmp_path, EACH_STEP)
    environment = {name: value for name, value in os.environ.items() if name != "NUMBA_NUM_THREADS"}

    def processes(folder, *arguments, **more):
        command = [sys.executable, script, "run", path, "--out", tmp_path / folder, "--set", "output.every=0", *arguments]
        done = subprocess.run(command, env={**environment, **more}, capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, done.stderr
        sizes = json.loads((tmp_path / folder / "summary.json").read_text())["sizes"]["modelled"]
        return sizes.get("processes"), "2 processes for 256 points (--ranks 1: one process)" in done.stderr

    assert processes("two") == (2, True)
    (tmp_path / "mpirun").write_text("#!/bin/sh\nexit 1\n")
    (tmp_path / "mpirun").chmod(0o755)
    assert processes("one", PATH=f"{tmp_path}:{os.environ['PATH']}") == (None, False)
