"""Several processes give what one gives, to the tolerance of the solver, and end together. They start mpirun on tiny scenes."""

import csv
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from hybrid.output.history import read_history

pytest.importorskip("mpi4py")
pytestmark = pytest.mark.skipif(shutil.which("mpirun") is None, reason="needs mpirun")

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
GEOMETRY = os.path.join(os.path.dirname(__file__), "..", "..", "geometry")


@pytest.fixture
def scene(tmp_path):
    def write(text):
        path = tmp_path / "scene.toml"
        path.write_text(text.replace("GEOMETRY", os.path.abspath(GEOMETRY)))
        return path
    return write


def hybrid(*arguments, code=0):
    environment = {**os.environ, "NUMBA_NUM_THREADS": "1"}
    done = subprocess.run([sys.executable, "-m", "hybrid", *map(str, arguments)], env=environment, capture_output=True,
                          text=True, timeout=300)
    assert done.returncode == code, done.stderr
    return done.stderr


def history(folder):
    with open(folder / "history.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    names = [name for name in rows[0] if name.startswith(("energy", "box")) and name != "energy_error_J"]
    return {name: np.array([float(row[name]) for row in rows]) for name in names}


def points(folder):
    with np.load(folder / "checkpoint.npz") as arrays:
        return {name: arrays[f"points/{name}"] for name in ("position", "velocity", "stress", "plastic_strain")}


def largest_difference(one, other):
    assert one.keys() == other.keys()
    return max(np.abs(one[name] - other[name]).max() / max(np.abs(one[name]).max(), 1e-3) for name in one)


def test_elastic_column_and_resuming_on_another_number_of_ranks(scene, tmp_path):
    path = scene(COLUMN)
    hybrid("run", path, "--out", tmp_path / "one")
    hybrid("run", path, "--out", tmp_path / "two", "--ranks", 2)
    hybrid("run", path, "--out", tmp_path / "mixed", "--ranks", 3, "--set", "stage.settle.steps=2")
    hybrid("run", path, "--out", tmp_path / "mixed", "--resume")
    for name in ("two", "mixed"):
        assert largest_difference(points(tmp_path / "one"), points(tmp_path / name)) < 1e-6
        assert largest_difference(history(tmp_path / "one"), history(tmp_path / name)) < 1e-6


def test_body_that_slides_on_yielding_sand(scene, tmp_path):
    path = scene(SLIDE)
    hybrid("run", path, "--out", tmp_path / "one")
    hybrid("run", path, "--out", tmp_path / "three", "--ranks", 3)
    found, expected = history(tmp_path / "three"), history(tmp_path / "one")
    assert expected["box_contact_fz_N"].min() > 1e3 and expected["energy_plastic_J"][-1] > 0.01
    for name in ("box_x_m", "box_z_m", "box_vx_m_per_s", "box_contact_fx_N", "box_contact_fz_N", "energy_plastic_J"):
        assert np.abs(found[name] - expected[name]).max() < 1e-4 * np.abs(expected[name]).max(), name
    for name in ("position", "stress"):
        one, three = points(tmp_path / "one")[name], points(tmp_path / "three")[name]
        assert np.abs(one - three).max() < 1e-3 * np.abs(one).max()


def test_bodies_that_rest_on_one_another(tmp_path):
    """The demo stack.toml on cells of 0.5 m, four steps: forces of the soil and of blocks on one another."""
    coarse = [text for axis in "xyz" for text in ("--set", f"grid.{axis}.size=0.5")]
    few = ["--set", "grid.y.start=-1.5", "--set", "grid.y.end=1.5", "--set", "stage.stand.steps=4", "--set", "stage.drop.steps=1",
           "--set", "output.every=0", "--set", "output.pictures=[]"]
    for folder, ranks in (("one", 1), ("two", 2)):
        hybrid("run", Path(__file__).parents[2] / "demos/stack.toml", *coarse, *few, "--out", tmp_path / folder, *(["--ranks", 2] * (ranks > 1)))
    rows = [read_history(tmp_path / folder) for folder in ("one", "two")]
    for name in ("lower_contact_fz_N", "middle_on_lower_fz_N", "upper_on_middle_fz_N"):
        one, two = (row[name] for row in rows)
        assert np.abs(one).min() > 100.0 and np.abs(one - two).max() < 1e-4 * np.abs(one).max(), name


JOINED = """
name = "joined"
gravity = [0.0, 0.0, -9.81]
time = { step = 0.01 }
output = { every = 0 }
grid.x = { start = -1.0, end = 1.0, size = 0.25 }
grid.y = { start = -0.5, end = 0.5, size = 0.25 }
grid.z = { start = -0.75, end = 0.5, size = 0.25 }
grid.faces = { z_min = "fixed" }
soil.top = 0.0
soil.material = { law = "hencky", young = 1e6, poisson = 0.2, density = 1500.0 }
joint = [{ name = "pin", kind = "hinge", bodies = ["a", "b"], point = [0.3, 0.0, 0.0], axis = [0.0, 1.0, 0.0] }]
stage = [{ name = "go", steps = 4, load = [{ body = "b", force = [300.0, 0.0, 0.0] }] }]
""" + "".join(f"""
[[body]]
name = "{name}"
geometry = "{Path(__file__).parents[2] / 'geometry/box.geo'}"
parameters = {{ length = 0.5, width = 0.4, height = 0.2, size = 20.0 }}
density = 2000.0
position = [{x}, 0.0, 0.0]
rest_on = 0.0
friction = 0.4
""" for name, x in (("a", -0.3), ("b", 0.3)))


def test_joined_bodies_on_soil(tmp_path):
    """Poses, force and angle of the hinge between two boxes are those of one rank."""
    path = tmp_path / "joined.toml"
    path.write_text(JOINED)
    for folder, ranks in (("one", 1), ("two", 2)):
        hybrid("run", path, "--out", tmp_path / folder, *(["--ranks", 2] * (ranks > 1)))
    one, two = (read_history(tmp_path / folder) for folder in ("one", "two"))
    for name in ("a_x_m", "b_z_m", "pin_angle_deg", "pin_fx_N", "pin_fz_N"):
        assert np.abs(one[name] - two[name]).max() < 1e-3 * np.abs(one[name]).max(), name
    assert np.abs(one["pin_fx_N"]).max() > 10.0


def test_what_ranks_cannot_do_is_refused_once(scene, tmp_path):
    path = scene(COLUMN)
    text = hybrid("run", path, "--out", tmp_path / "out", "--ranks", 2, "--set", "soil.stray='freeze'", code=2)
    assert text.count("hybrid: ") == 1 and "run this scene on one rank" in text
    assert not (tmp_path / "out" / "history.csv").exists()


FAULT = """
import sys
from hybrid.runtime import ranks
from hybrid.step import newton
solve = newton.solve
def broken(step):
    if step.state.step == 2 and ranks.rank() == 1:
        raise ArithmeticError("made for the test")
    return solve(step)
newton.solve = broken
from hybrid.cli import main
sys.exit(main(sys.argv[1:]))
"""


def test_a_fault_of_one_rank_ends_all_and_names_it(scene, tmp_path):
    path, script = scene(COLUMN), tmp_path / "fault.py"
    script.write_text(FAULT)
    environment = {**os.environ, "NUMBA_NUM_THREADS": "1", "OMPI_ALLOW_RUN_AS_ROOT": "1",
                   "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMPI_MCA_rmaps_base_oversubscribe": "1"}
    done = subprocess.run(["mpirun", "-n", "2", sys.executable, str(script), "run", str(path), "--out",
                           str(tmp_path / "out")], env=environment, capture_output=True, text=True, timeout=120)
    assert done.returncode != 0
    assert done.stderr.count("ArithmeticError: made for the test") == 1 and "on rank 1 of 2" in done.stderr
    hybrid("run", path, "--out", tmp_path / "out", "--resume")
    assert len(history(tmp_path / "out")["energy_kinetic_J"]) == 4
