"""Frames in pieces: what several processes write is what one writes, and opens as one."""

import json
import os
import shutil
import subprocess
import sys

import numpy as np
import pytest

from hybrid.output.vtk import read_pvd
from hybrid.runtime.ranks import launch

pytest.importorskip("mpi4py")
pyvista = pytest.importorskip("pyvista")
pytestmark = pytest.mark.skipif(shutil.which("mpirun") is None, reason="needs mpirun")

COLUMN = """
name = "column"
time = { step = 0.02 }
output = { pictures = [], every = 1, checkpoint = 1 }
solver = { tolerance = 1e-8, linear_tolerance = 1e-6 }
[grid]
x = { start = 0.0, end = 1.0, size = 0.25 }
y = { start = 0.0, end = 0.5, size = 0.25 }
z = { start = 0.0, end = 1.5, size = 0.25 }
[soil]
top = 1.0
geostatic = false
material = { law = "hencky", young = 1e5, poisson = 0.3, density = 1000.0 }
[[stage]]
name = "settle"
steps = 3
"""


def hybrid(folder, *arguments, ranks=1, script=("-m", "hybrid"), code=0):
    """stderr of a run of the column into a folder."""
    path = folder.parent / "column.toml"
    path.write_text(COLUMN)
    command, environment = launch(ranks, [*script, "run", path, "--out", folder, *arguments])
    done = subprocess.run(command if ranks > 1 else [sys.executable, *command[4:]], env={**environment, "NUMBA_NUM_THREADS": "1"},
                          capture_output=True, text=True, timeout=120)
    assert (done.returncode != 0) == bool(code), done.stderr
    return done.stderr


def files(folder):
    return [name for name, _ in read_pvd(folder / "soil.pvd")]


def in_order(grid):
    """Coordinates and fields of a frame, in the order of the points' numbers."""
    order = np.argsort(grid["number"]) if "number" in grid.point_data else np.arange(grid.n_points)
    return {"points": grid.points[order], **{name: np.asarray(grid[name])[order] for name in grid.point_data if name != "number"}}


def test_pieces_are_the_frame_of_one_process_and_go_on_with_any_number(tmp_path):
    one, two, mixed = tmp_path / "one", tmp_path / "two", tmp_path / "mixed"
    hybrid(one)
    hybrid(two, ranks=2)
    assert files(two) == [f"soil_00000{step}.pvtu" for step in range(4)]
    pieces = [pyvista.read(two / f"soil_000002_r{rank}.vtu").n_points for rank in range(2)]
    assert sum(pieces) == 256 and min(pieces) > 64
    found, expected = (in_order(pyvista.read(folder / files(folder)[2])) for folder in (two, one))
    assert found.keys() == expected.keys()
    for name, values in expected.items():
        np.testing.assert_allclose(found[name], values, rtol=0, atol=1e-6 * max(np.abs(values).max(), 1e-3), err_msg=name)
    shutil.copytree(two, mixed)
    hybrid(mixed, "--resume", "--set", "stage.settle.steps=4")
    hybrid(mixed, "--resume", "--set", "stage.settle.steps=5", ranks=3)
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
from hybrid.cli import main
sys.exit(main(sys.argv[1:]))
"""


def test_a_piece_that_cannot_be_written_ends_all_once_and_the_frame_is_not_listed(tmp_path):
    script = tmp_path / "full.py"
    script.write_text(FULL)
    text = hybrid(tmp_path / "out", ranks=2, script=(script,), code=1)
    assert text.count("No space left on device; process 1") == 1 and "soil_000002_r1.vtu: cannot be written" in text
    assert files(tmp_path / "out") == ["soil_000000.pvtu", "soil_000001.pvtu"]
    hybrid(tmp_path / "out", "--resume", ranks=2)
    assert files(tmp_path / "out") == [f"soil_00000{step}.pvtu" for step in range(4)]


BEST = """
import os, sys
from hybrid.setup import best_ranks
best_ranks.PER_PROCESS, best_ranks.FEWEST = 100, 2
os.sched_getaffinity = lambda _: {0, 1, 2}
from hybrid.cli import main
sys.exit(main(sys.argv[1:]))
"""


def test_a_run_becomes_as_many_processes_as_are_worth_it_and_says_so(tmp_path):
    """256 points, 100 for each process; one where mpirun cannot start any."""
    script, path = tmp_path / "best.py", tmp_path / "column.toml"
    script.write_text(BEST)
    path.write_text(COLUMN)
    environment = {name: value for name, value in os.environ.items() if name != "NUMBA_NUM_THREADS"}

    def processes(folder, *arguments, **more):
        done = subprocess.run([sys.executable, script, "run", path, "--out", tmp_path / folder, "--set", "output.every=0", *arguments],
                              env={**environment, **more}, capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, done.stderr
        sizes = json.loads((tmp_path / folder / "summary.json").read_text())["sizes"]["modelled"]
        return sizes.get("processes"), "2 processes for 256 points (--ranks 1: one process)" in done.stderr

    assert processes("two") == (2, True)
    (tmp_path / "mpirun").write_text("#!/bin/sh\nexit 1\n")
    (tmp_path / "mpirun").chmod(0o755)
    assert processes("one", PATH=f"{tmp_path}:{os.environ['PATH']}") == (None, False)
