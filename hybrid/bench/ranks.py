"""One process, two threads and two processes (`--ranks 2`) on the same scenes: iterations, and the time of each phase.

Each run is a process of its own, one after the other. Its time is that of its phases: without start-up, compilation and
files.
"""

import csv
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from hybrid.runtime.data import DEMOS

BLOCK = """
name = "block"
time = {{ step = 0.01 }}
output = {{ pictures = [], every = 0, checkpoint = 0 }}
[soil]
top = 1.0
geostatic = false
ghost = 0.0
[soil.material]
law = "drucker-prager"
young = 10e6
poisson = 0.3
density = 1800.0
friction_angle = 32.0
dilation_angle = 2.0
cohesion = 1e3
[grid]
x = {{ start = 0.0, end = 2.0, size = {size} }}
y = {{ start = 0.0, end = 2.0, size = {size} }}
z = {{ start = 0.0, end = {end}, size = {size} }}
[[stage]]
name = "fall"
steps = 3
"""
HEIGHT = 20                 # cells of the block, twice as many along x and y
WAYS = {"one process": (1, 1), "two threads": (1, 2), "two ranks": (2, 1)}
QUIET = ["output.pictures=[]", "output.every=0", "output.checkpoint=0"]


def run(options):
    """A row for each scene, of which --quick has the first, and way to run it."""
    height = 3 if options.quick else HEIGHT
    anchor = [*QUIET, "stage.0.steps=25", "stage.1.steps=15"]
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        block = Path(folder, "block.toml")
        block.write_text(BLOCK.format(size=1 / height, end=1 + 2 / height), encoding="utf-8")
        scenes = [("block", block, []), ("anchor", DEMOS / "anchor.toml", anchor)]
        for name, scene, changes in scenes[:1] if options.quick else scenes:
            for way, (ranks, threads) in WAYS.items():
                rows.append({"scene": name, "way": way, **_ran(scene, changes, ranks, threads, Path(folder, name))})
    for row in rows:
        row["gain"] = next(r["s"] for r in rows if r["scene"] == row["scene"]) / row["s"]
    return rows


def _ran(scene, changes, ranks, threads, out):
    """Counts of a run, its time [s] and that of its phases."""
    environment = {**os.environ, "OMP_NUM_THREADS": str(threads), "NUMBA_NUM_THREADS": str(threads)}
    command = [sys.executable, "-m", "hybrid", "run", str(scene), "--ranks", str(ranks), "--out", str(out), "--overwrite"]
    command += ["--set", *changes] if changes else []
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)} failed: {done.stderr[-500:]}")
    with open(out / "history.csv", encoding="utf-8", newline="") as file:
        history = list(csv.DictReader(file))
    phases = {key.removeprefix("seconds_").replace("_", " "): sum(float(row[key]) for row in history)
              for key in history[0] if key.startswith("seconds_")}
    return {"steps": len(history), **{key: sum(int(row[key]) for row in history) for key in ("iterations", "krylov")},
            "s": sum(phases.values()), **phases}
