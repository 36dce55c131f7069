"""Runs of the command that are killed or stopped, and all that they leave in their folder, for comparison to the bit."""

import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from hybrid.output.history import count_steps

REPOSITORY = Path(__file__).parents[2]
STEPS = 12
SCENE = f"""
name = "sliding"
gravity = [0.0, 0.0, -9.81]
output = {{ every = 3, checkpoint = 4 }}
solver = {{ tolerance = 1e-9 }}
time = {{ step = 0.01 }}
[grid]
x = {{ start = 0.0, end = 0.8, size = 0.2 }}
y = {{ start = 0.0, end = 0.8, size = 0.2 }}
z = {{ start = -0.6, end = 0.2, size = 0.2 }}
faces = {{ z_min = "fixed" }}
[soil]
top = 0.0
material = {{ law = "hencky", young = 1e6, poisson = 0.3, density = 1800.0 }}
[[body]]
name = "box"
geometry = "{REPOSITORY}/geometry/box.geo"
parameters = {{ length = 0.4, width = 0.3, height = 0.2, size = 0.2 }}
density = 3000.0
position = [0.41, 0.39, 0.0]
rest_on = 0.0
friction = 0.3
velocity = [0.2, 0.1, 0.0]
spin = [0.0, 0.0, 0.5]
[[stage]]
name = "slide"
steps = {STEPS}
"""


def write_scene(folder):
    """Path of the scene file, which is written to a folder."""
    path = folder / "sliding.toml"
    path.write_text(SCENE)
    return path


def start(scene, folder, *options, **more):
    """Process of `hybrid run`; its messages are in its stderr."""
    environment = os.environ | {"PYTHONPATH": str(REPOSITORY)} | more.pop("environment", {})
    return subprocess.Popen([sys.executable, "-m", "hybrid", "run", scene, "--out", folder, *options],
                            stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True, env=environment, **more)


def wait_for_step(process, folder, step, limit=300.0):
    """Wait until history.csv has a `step` that this process has computed."""
    end = time.monotonic() + limit
    while count_steps(folder) < step:
        assert process.poll() is None, process.stderr.read()
        assert time.monotonic() < end, "the run does not get on"
        time.sleep(0.01)


def results(folder):
    """{name: bytes} of the checkpoint's arrays, of each column of history.csv but times of computing, and of each frame
    and series."""
    found = {path.name: path.read_bytes() for path in folder.iterdir() if path.suffix in (".vtu", ".pvd")}
    with np.load(folder / "checkpoint.npz") as file:
        found |= {name: file[name].tobytes() for name in file.files if name != "run"}
    with open(folder / "history.csv", encoding="utf-8") as file:
        rows = [line.rstrip("\n").split(",") for line in file]
    return found | {column[0]: "\n".join(column).encode() for column in zip(*rows, strict=True)
                    if not column[0].startswith("seconds_")}


def different(folder, other):
    """Names of the results that differ between two folders, or are in one of them only."""
    one, two = results(folder), results(other)
    return sorted(name for name in one.keys() | two.keys() if one.get(name) != two.get(name))
