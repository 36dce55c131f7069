"""What `hybrid check` predicts against what short runs take, within a factor of two.

Times are those of the processor, which other programs hardly change; prediction and run take turns in one process.
Memory is the most that a process of its own ever held.
"""

import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from hybrid import probe as probe_module
from hybrid.build import build
from hybrid.probe import PARTS, probe
from hybrid.scene import Solver
from hybrid.scene_file import load_scene
from hybrid.study.scenes import plane, soil_scene, sphere

ROOT = Path(__file__).parents[2]
COARSE = [f"grid.{axis}.{key}" for axis, fine in (("x", "[-0.8, 3.6]"), ("y", "[0.0, 1.6]"), ("z", "[-1.2, 0.8]"))
          for key in ("size=0.4", f"fine={fine}")]
SCENES = {
    "held": lambda: plane(sphere(0.25, 0.05, rest_on=0.0, velocity=(1.0, 0.0, 0.0), friction=0.4, penalty=1.0), 30,
                          0.01, cells=(16, 8), gravity=(1.0, 0.0, -9.81)),
    "elastic": lambda: soil_scene(x=(0.0, 1.6), y=(0.0, 1.6), z=(-0.8, 0.2), steps=12, gravity=(0.0, 0.0, -9.81),
                                  solver=Solver()),
    "anchor": lambda: load_scene(ROOT / "demos/anchor.toml", [*COARSE, "stage.0.steps=8", "stage.1.steps=3"]),
}


@pytest.fixture(autouse=True)
def processor_time(monkeypatch):
    monkeypatch.setattr(probe_module, "perf_counter", time.process_time)


@pytest.mark.parametrize("kind", SCENES)
def test_time_of_a_step(kind):
    """Ratios found: 0.7 to 0.8, 0.9 to 1.3 and 1.0 to 1.4."""
    simulation, taken = build(SCENES[kind]()), []
    first = probe(simulation)
    begin = time.process_time()
    for _ in simulation.steps():
        taken.append(time.process_time() - begin)
        begin = time.process_time()
    again = probe(build(SCENES[kind]()))
    predicted = np.mean([first.step, again.step])
    assert 0.5 < predicted / np.median(taken) < 2     # the mean would tell of what is compiled meanwhile
    assert first.steps == len(taken) and set(first.seconds) == set(PARTS)


def test_the_probe_leaves_the_simulation_as_it_is():
    simulation = build(SCENES["held"]())
    state, position = simulation.state, simulation.state.bodies[0].position.copy()
    points = state.points.position.copy()
    sheet = probe(simulation).sheet()["predicted"]
    assert simulation.state is state and np.array_equal(state.bodies[0].position, position)
    assert np.array_equal(state.points.position, points) and state.step == 0
    assert sheet["all steps"].endswith("for 30") and sheet["assumed"][0].startswith("2 Newton iterations a step, 2 ")


def test_points_on_their_first_lattice_would_tell_too_little(monkeypatch):
    """Once they move they couple 12 to 27 nodes instead of 8."""
    simulation = build(SCENES["elastic"]())
    moved = min(probe(simulation).seconds["tangent"] for _ in range(2))
    monkeypatch.setattr(probe_module, "DRAWN", 0.0)
    assert min(probe(simulation).seconds["tangent"] for _ in range(2)) < 0.8 * moved


MEMORY = """
import sys
sys.path.insert(0, "tests")
from hybrid.build import build
from hybrid.probe import peak_memory, probe
from hybrid.scene import Solver
from hybrid.sheet import LIBRARIES
from hybrid.study.scenes import soil_scene

def block(cells, linear):
    width = 0.1 * cells
    return build(soil_scene(x=(0.0, width), y=(0.0, width), z=(-width / 2, 0.1), size=0.1, steps=1,
                            gravity=(0.0, 0.0, -9.81), solver=Solver(linear=linear)))

for linear in ("krylov", "direct"):     # compiles
    list(block(4, linear).steps())
for linear in ("krylov", "direct"):
    base, simulation = peak_memory(), block(12, linear)
    probed = probe(simulation).peak - base
    list(simulation.steps())
    print(2**20 * simulation.sheet()["modelled"]["memory, estimated [MiB]"] - LIBRARIES, probed, peak_memory() - base)
"""


def test_memory_of_a_run():
    """The peak grows by what is estimated, and the probe has met it before."""
    told = subprocess.run([sys.executable, "-c", MEMORY], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for estimated, probed, run in np.array([line.split() for line in told.splitlines()], float):
        assert 0.5 < estimated / run < 2 and 0.5 < probed / run < 1.02
