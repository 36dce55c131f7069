"""Runs of the command in one and in several processes, the scenes that they start from, and what they leave in their
folders."""

import csv
import importlib.util
import os
import shutil
import subprocess
import sys
from contextlib import redirect_stderr
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
import rank_pool

from hybrid.cli import main
from hybrid.output import checkpoint
from hybrid.runtime.ranks import launch
from hybrid.scene.file import load_scene
from hybrid.setup.build import build

ROOT = Path(__file__).parents[2]
DEMOS = ROOT / "demos"
needs_mpirun = pytest.mark.skipif(shutil.which("mpirun") is None or importlib.util.find_spec("mpi4py") is None,
                                  reason="needs mpirun and mpi4py")

COLUMN = """
name = "column"
time = { step = 0.02 }
output = { pictures = [], every = 2, checkpoint = 2 }
solver = { tolerance = 1e-8, linear_tolerance = 1e-6 }
[grid]
x = { start = 0.0, end = 1.0, size = 0.25 }
y = { start = 0.0, end = 0.5, size = 0.25 }
z = { start = 0.0, end = 1.5, size = 0.25 }
faces = { y_min = "roller", y_max = "roller", z_min = "fixed" }
[soil]
top = 1.0
geostatic = false
material = { law = "hencky", young = 1e5, poisson = 0.3, density = 1000.0 }
[[stage]]
name = "settle"
steps = 4
"""
# Sand that yields, F-bar, ghost penalty, friction; points cross from process to process
SLIDE = """
name = "slide"
time = { step = 0.02 }
output = { pictures = [] }
solver = { tolerance = 1e-8, linear_tolerance = 1e-6 }
[grid]
x = { start = 0.0, end = 2.5, size = 0.25 }
y = { start = 0.0, end = 1.0, collapsed = true }
z = { start = -1.0, end = 0.5, size = 0.25 }
faces = { x_min = "roller", x_max = "roller", z_min = "fixed" }
[soil]
top = 0.0
material = { relative_density = 38 }
[[body]]
name = "box"
geometry = "GEOMETRY/box.geo"
parameters = { length = 0.8, width = 1.0, height = 0.4, size = 20.0 }
density = 3000.0
position = [1.2, 0.5, 0.0]
rest_on = 0.0
velocity = [1.0, 0.0, 0.0]
[[stage]]
name = "slide"
steps = 4
"""
# Window and fine cells go with a box through sand
FOLLOWED_BOX = """
grid.x = { start = 0.0, end = 9.6, size = 0.2, growth = 1.4, around = [0.4, 0.4], window = [0.4, 0.4], doublings = 1 }
grid.y = { start = -0.2, end = 0.2, collapsed = true }
grid.z = { start = -3.2, end = 1.6, size = 0.2, growth = 1.4, around = [0.6, 0.2] }
grid.faces = { z_min = "fixed" }
soil.top = 0.0
soil.material = { relative_density = 38 }
[[body]]
name = "box"
geometry = "GEOMETRY/box.geo"
parameters = { length = 0.8, width = 0.8, height = 0.6, size = 20.0 }
density = 2000.0
position = [1.6, 0.0, 0.301]
held = ["ry"]
friction = 0.3
"""


def scene_file(folder, text):
    """Path of a scene in a folder; GEOMETRY in its text is the folder of the shipped geometries."""
    path = folder / "scene.toml"
    path.write_text(text.replace("GEOMETRY", str(ROOT / "geometry")))
    return path


def settings(*keys):
    """Arguments that set each of some keys of a scene, as key=value."""
    return [text for key in keys for text in ("--set", key)]


def patched(path, text):
    """Path of a program that is the command `hybrid` after a `text` has changed it."""
    path.write_text(f"{text}\nimport sys\nfrom hybrid.cli import main\nsys.exit(main(sys.argv[1:]))\n")
    return path


def python(ranks, *arguments):
    """CompletedProcess of a Python program, with its arguments, in so many processes of one thread each."""
    command, environment = launch(ranks, arguments)
    return _done(command if ranks > 1 else command[3:], environment)     # without mpirun -n 1


def _done(command, environment):
    return subprocess.run(command, env={**environment, "NUMBA_NUM_THREADS": "1"}, capture_output=True, text=True,
                          timeout=300)


def hybrid(*arguments, code=0):
    """stderr of the command, which ends with a code. If it is to succeed it runs in this process, whose kernels are loaded,
    or in processes that stay (`rank_pool`); else in the environment of a user, where --ranks starts processes."""
    if code:
        return launched(*arguments, code=code)
    ranks = arguments[arguments.index("--ranks") + 1] if "--ranks" in arguments else 1
    if ranks > 1:
        answers = rank_pool.call(ranks, "hybrid.cli.main", list(map(str, arguments)))
        assert not any(code for code, _ in answers), answers
        return "".join(text for _, text in answers)
    alone = arguments if "--ranks" in arguments else (*arguments, "--ranks", 1)
    with redirect_stderr(StringIO()) as text:
        assert main([str(argument) for argument in alone]) == 0, text.getvalue()
    return text.getvalue()


def launched(*arguments, code=0):
    """stderr of the command in the environment of a user, which ends with a code; --ranks starts processes."""
    done = _done([sys.executable, "-m", "hybrid", *map(str, arguments)], os.environ)
    assert done.returncode == code, done.stderr
    return done.stderr


def program(path, *arguments, ranks=1, fails=False):
    """stderr of a program that is the command, as of `patched`, which fails or not."""
    done = python(ranks, path, *arguments)
    assert (done.returncode != 0) == fails, done.stderr
    return done.stderr


def state(folder):
    """State at the last checkpoint of a run."""
    return checkpoint.load(folder / "checkpoint.npz")


def points(folder, *more):
    """Fields of the points there, each (n, ...), by name."""
    return {name: getattr(state(folder).points, name)
            for name in ("position", "velocity", "stress", "plastic_strain", *more)}


def history(folder):
    """Columns (n,) of the energies and of what moves the box, by name."""
    with open(folder / "history.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    names = [name for name in rows[0] if name.startswith(("energy", "box")) and name != "energy_error_J"]
    return {name: np.array([float(row[name]) for row in rows]) for name in names}


def largest_difference(one, other):
    """Between values of the same names, relative to the largest value of each."""
    assert one.keys() == other.keys()
    return max(np.abs(one[name] - other[name]).max() / max(np.abs(one[name]).max(), 1e-3) for name in one)


def ground_apart(scene):
    """Distance [m] over which slopes of the ground of a scene are taken, in this process."""
    return build(load_scene(scene)).model.soil.ground.apart
