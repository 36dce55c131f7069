"""Several processes give what one gives, to the tolerance of the solver, and end together. They start mpirun on tiny scenes."""

import csv
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import meshio
import numpy as np
import pytest

from hybrid.output import checkpoint
from hybrid.output.history import read_history
from hybrid.runtime.ranks import launch

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
DEMOS = Path(__file__).parents[2] / "demos"


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


def mpirun(ranks, script, *arguments):
    """CompletedProcess of a Python `script` on so many ranks."""
    command, environment = launch(ranks, [script, *arguments])
    return subprocess.run(command, env={**environment, "NUMBA_NUM_THREADS": "1"}, capture_output=True, text=True, timeout=120)


def history(folder):
    with open(folder / "history.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    names = [name for name in rows[0] if name.startswith(("energy", "box")) and name != "energy_error_J"]
    return {name: np.array([float(row[name]) for row in rows]) for name in names}


def state(folder):
    return checkpoint.load(folder / "checkpoint.npz")


def points(folder, *more):
    return {name: getattr(state(folder).points, name) for name in ("position", "velocity", "stress", "plastic_strain", *more)}


def largest_difference(one, other):
    assert one.keys() == other.keys()
    return max(np.abs(one[name] - other[name]).max() / max(np.abs(one[name]).max(), 1e-3) for name in one)


def test_elastic_column_and_resuming_on_another_number_of_ranks(scene, tmp_path):
    path = scene(COLUMN)
    hybrid("run", path, "--out", tmp_path / "one")
    text = hybrid("run", path, "--out", tmp_path / "two", "--ranks", 2)
    assert "btl_tcp" not in text      # Open MPI about a network that one machine does not need
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
        hybrid("run", DEMOS / "stack.toml", *coarse, *few, "--out", tmp_path / folder, *(["--ranks", 2] * (ranks > 1)))
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


def coarse_anchor(*more):
    """Arguments of `hybrid run` for the demo anchor.toml on cells of 0.4 m, `more` keys, without files of fields."""
    keys = [f"grid.{axis}.size=0.4" for axis in "xyz"] + ["grid.x.fine=[-0.6,3.4]", "grid.y.fine=[0.0,1.2]"]
    keys += ["grid.z.fine=[-1.2,0.8]", "output.every=0", "output.pictures=[]", *more]
    return [DEMOS / "anchor.toml", *(text for key in keys for text in ("--set", key))]


def test_few_nodes_of_all_ranks_are_solved_for_by_themselves(tmp_path):
    """Nonlinear elimination: as few iterations a step as on one rank (4 at most, 8 without), to the same place."""
    for folder, ranks in (("one", 1), ("two", 2)):
        hybrid("run", *coarse_anchor("stage.0.steps=10", "stage.1.steps=15"), "--out", tmp_path / folder, "--ranks", ranks)
    one, two = (read_history(tmp_path / folder) for folder in ("one", "two"))
    assert two["iterations"].max() <= 5 and two["iterations"].sum() <= 1.05 * one["iterations"].sum()
    assert two["anchor_z_m"] == pytest.approx(one["anchor_z_m"], abs=1e-5)
    assert two["anchor_tension_N"][-1] == pytest.approx(one["anchor_tension_N"][-1], rel=1e-4)


# A block slides out of the grid
THROWN = """
name = "thrown"
gravity = [6.0, 0.0, -1.0]
time = { step = 0.04 }
output = { pictures = [], every = 0, checkpoint = 2 }
solver = { tolerance = 1e-8, linear_tolerance = 1e-6 }
[grid]
x = { start = 0.0, end = 2.0, size = 0.25 }
y = { start = 0.0, end = 0.5, size = 0.25 }
z = { start = 0.0, end = 1.0, size = 0.25 }
faces = { z_min = "roller", x_max = "free" }
[soil]
lower = [0.5, 0.0, 0.0]
upper = [1.5, 0.5, 0.5]
geostatic = false
stray = "freeze"
material = { law = "hencky", young = 1e5, poisson = 0.3, density = 1000.0 }
[[stage]]
name = "slide"
steps = 14
"""


def test_points_that_leave_the_grid(scene, tmp_path):
    """Half of the block is frozen where it left; of one of three ranks, all of it."""
    path = scene(THROWN)
    for ranks in (1, 3):
        hybrid("run", path, "--out", tmp_path / str(ranks), "--ranks", ranks)
    one, three = (points(tmp_path / str(ranks), "inactive") for ranks in (1, 3))
    assert one["inactive"].sum() == 64 and (three["inactive"] == one["inactive"]).all()
    for name in ("position", "velocity", "stress"):
        assert np.abs(one[name] - three[name]).max() < 1e-6 * np.abs(one[name]).max(), name
    stop = ["--set", "soil.stray='stop'"]
    texts = [hybrid("run", path, "--out", tmp_path / f"stop{ranks}", "--ranks", ranks, *stop, code=2) for ranks in (1, 2)]
    assert texts[1].count("hybrid: ") == 1 and "points 112 at (2.019, " in texts[1]
    assert texts[0].splitlines()[-1] in texts[1].splitlines()      # which Open MPI 5 follows by a page of its own


def test_sphere_on_held_ground(tmp_path):
    keys = ["stage.0.steps=12", "output.every=0", "output.pictures=[]"]
    for ranks in (1, 2):
        hybrid("run", DEMOS / "rolling_sphere.toml", *(text for key in keys for text in ("--set", key)), "--out",
               tmp_path / str(ranks), "--ranks", ranks)
    one, two = (read_history(tmp_path / str(ranks)) for ranks in (1, 2))
    for name in ("sphere_x_m", "sphere_spin_y_rad_per_s", "sphere_contact_fx_N"):
        assert np.abs(one[name]).max() > 0.5 and two[name] == pytest.approx(one[name], rel=1e-6), name


def test_clay_that_sticks_to_a_pipe_and_breaks_away(tmp_path):
    """The demo pipe.toml on coarse cells, its bond of 200 Pa: contact points bear the interface of those of another rank.
    With those of their own rank alone the pipe ends 1 mm elsewhere."""
    keys = ["grid.x.size=0.125", "grid.z.size=0.125", "stage.1.steps=10", "output.every=0", "output.pictures=[]",
            "output.checkpoint=2", "solver.tolerance=1e-7", "solver.linear_tolerance=1e-5", "body.0.tension=200.0"]
    for ranks in (1, 2):
        hybrid("run", DEMOS / "pipe.toml", *(text for key in keys for text in ("--set", key)), "--out",
               tmp_path / str(ranks), "--ranks", ranks)
    one, two = (read_history(tmp_path / str(ranks)) for ranks in (1, 2))
    for name in ("pipe_z_m", "pipe_contact_fx_N", "pipe_contact_fz_N", "energy_friction_J"):
        assert np.abs(one[name] - two[name]).max() < 1e-4 * np.abs(one[name]).max(), name
    opened = state(tmp_path / "2").contacts[0].opened
    assert opened.any() and not opened.all()


# A box is pushed through sand; window and fine cells go with it, points are split, merged and left behind
PLOUGH = """
name = "plough"
time = { step = 0.04 }
output = { pictures = [], every = 5, checkpoint = 3 }
solver = { tolerance = 1e-8, linear_tolerance = 1e-6 }
[grid]
x = { start = 0.0, end = 9.6, size = 0.2, growth = 1.4, around = [0.4, 0.4], window = [0.4, 0.4], doublings = 1 }
y = { start = -0.2, end = 0.2, collapsed = true }
z = { start = -3.2, end = 1.6, size = 0.2, growth = 1.4, around = [0.6, 0.2] }
faces = { z_min = "fixed" }
[soil]
top = 0.0
material = { relative_density = 38 }
[[body]]
name = "box"
geometry = "GEOMETRY/box.geo"
parameters = { length = 0.8, width = 0.8, height = 0.6, size = 20.0 }
density = 2000.0
position = [1.6, 0.0, 0.301]
held = ["ry"]
friction = 0.3
[[stage]]
name = "go"
steps = 20
motion = [{ component = "x", velocity = 1.5 }, { component = "z", velocity = -0.05 }]
"""


def ground(folder):
    """Initial places of the points in the grid and of those left behind, in order, with position and stress of these."""
    last = state(folder)
    behind = last.ground.behind
    assert last.ground.constants.number is behind.constants.number is None
    parts = [(constants.position, points.position, points.stress)
             for constants, points in ((last.ground.constants, last.points), (behind.constants, behind.points))]
    return [values[np.lexsort(np.round(place, 6).T)] for place, *others in parts for values in (place, *others)]


def test_grid_that_follows_a_body(scene, tmp_path):
    """On two and three ranks, and where a run goes on with another number of them."""
    path = scene(PLOUGH)
    for ranks in (1, 2, 3):
        hybrid("run", path, "--out", tmp_path / str(ranks), "--ranks", ranks)
    for steps, ranks in ((9, 2), (15, 3), (20, 1)):
        hybrid("run", path, "--out", tmp_path / "mixed", "--ranks", ranks, "--set", f"stage.go.steps={steps}",
               *(["--resume"] if steps > 9 else []))
    one, expected = read_history(tmp_path / "1"), ground(tmp_path / "1")
    assert len(expected[3]) > 100 and one["energy_plastic_J"][-1] > 10.0
    for folder in ("2", "3", "mixed"):
        found = read_history(tmp_path / folder)
        for name in ("box_contact_fx_N", "box_contact_fz_N", "energy_plastic_J", "energy_left_J"):
            assert np.abs(found[name] - one[name]).max() < 1e-6 * np.abs(one[name]).max(), (folder, name)
        frames = [sum(len(meshio.read(file).points) for file in (tmp_path / place).glob("soil_000015*.vtu"))
                  for place in ("1", folder)]      # with the points left behind, each once
        assert frames[0] == frames[1] > 256
        for there, here in zip(ground(tmp_path / folder), expected):
            assert there.shape == here.shape and np.abs(there - here).max() < 1e-6 * np.abs(here).max()


SHARES = """
import sys
from hybrid.runtime import comm
from hybrid.step import processes
settled = processes._settled
def watched(model, state):
    model, state = settled(model, state)
    shares = comm.joined([len(state.points)])
    assert max(shares) < 0.8 * sum(shares), f"uneven: {shares}"
    return model, state
processes._settled = watched
processes.GROWN = float(sys.argv.pop())
from hybrid.cli import main
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.parametrize(("grown", "uneven"), [(1.2, False), (1e9, True)])
def test_blocks_follow_soil_that_moves(scene, tmp_path, grown, uneven):
    """A block of soil slides 1.9 m along: each of two ranks keeps half of it, but not where blocks stay as they are."""
    path, script = scene(THROWN.replace("end = 2.0", "end = 4.0").replace("steps = 14", "steps = 20")), tmp_path / "shares.py"
    script.write_text(SHARES)
    done = mpirun(2, script, "run", path, "--out", tmp_path / "two", grown)
    if uneven:
        assert done.returncode != 0 and "uneven: " in done.stderr
        return
    assert done.returncode == 0, done.stderr
    hybrid("run", path, "--out", tmp_path / "one")
    assert points(tmp_path / "one")["position"][:, 0].min() > 2.0
    assert largest_difference(points(tmp_path / "one"), points(tmp_path / "two")) < 1e-6


LANDING = """
import sys
import numpy as np
from hybrid.runtime import comm
from hybrid.step import processes
settled = processes._settled
def watched(model, state):
    model, state = settled(model, state)
    work, points = (comm.joined([x]) for x in (len(state.points) + 0.5 * len(state.contacts[0].point), len(state.points)))
    if comm.number(state.contacts[0].point) > 50:
        with open(sys.argv[-1], "a") as file:
            file.write(f"{max(work) / sum(work)} {max(points) / sum(points)}\\n")
    return model, state
processes._settled = watched
from hybrid.cli import main
sys.exit(main(sys.argv[1:-1]))
"""


def test_blocks_follow_contact(scene, tmp_path):
    """A box falls on soil whose points stay in their cells: half of the work is each process's, not half of the points."""
    lands = SLIDE.replace("position = [1.2, 0.5, 0.0]\nrest_on = 0.0", "position = [0.5, 0.5, 0.24]").replace(
        "velocity = [1.0, 0.0, 0.0]", "velocity = [0.0, 0.0, -2.0]").replace("size = 0.25", "size = 0.125").replace("start = -1.0", "start = -0.5")
    script, found = tmp_path / "landing.py", tmp_path / "found"
    script.write_text(LANDING)
    done = mpirun(2, script, "run", scene(lands), "--out", tmp_path / "two", found)
    assert done.returncode == 0, done.stderr
    work, points = np.loadtxt(found).T
    assert work.max() < 0.58 < points.max()


def test_what_ranks_cannot_do_is_refused_once(scene, tmp_path):
    path = scene(COLUMN)
    sizes = [text for key in ("x.size=1.0", "y.size=0.5", "z.size=0.5") for text in ("--set", f"grid.{key}")]
    text = hybrid("run", path, "--out", tmp_path / "out", "--ranks", 4, *sizes, code=2)
    assert text.count("hybrid: ") == 1 and "run on one rank, or on fewer" in text
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
    done = mpirun(2, script, "run", path, "--out", tmp_path / "out")
    assert done.returncode != 0
    assert done.stderr.count("ArithmeticError: made for the test") == 1 and "on rank 1 of 2" in done.stderr
    hybrid("run", path, "--out", tmp_path / "out", "--resume")
    assert len(history(tmp_path / "out")["energy_kinetic_J"]) == 4


KILLED = """
import os, sys
from hybrid.runtime import ranks
from hybrid.step import newton
solve = newton.solve
with open(f"{sys.argv[-1]}/{ranks.rank()}.pid", "w") as file:
    file.write(str(os.getpid()))
def killed(step):
    if step.state.step == 3 and ranks.rank() == 1:
        os.kill(os.getpid(), 9)
    return solve(step)
newton.solve = killed
from hybrid.cli import main
sys.exit(main(sys.argv[1:-1]))
"""


def runs(number):
    """Whether a process exists, other than one that has ended and waits to be asked how."""
    try:
        return Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except (FileNotFoundError, ProcessLookupError):
        return False


def test_killing_a_rank_ends_all_and_the_run_goes_on(scene, tmp_path):
    """As the kernel does when memory is short. The last checkpoint goes on with another number of ranks."""
    path, script = scene(COLUMN), tmp_path / "killed.py"
    script.write_text(KILLED)
    done = mpirun(2, script, "run", path, "--out", tmp_path / "out", tmp_path)
    assert done.returncode != 0
    numbers, end = [int(file.read_text()) for file in tmp_path.glob("*.pid")], time.monotonic() + 10
    while any(map(runs, numbers)) and time.monotonic() < end:
        time.sleep(0.1)
    assert len(numbers) == 2 and not any(map(runs, numbers))
    hybrid("run", path, "--out", tmp_path / "out", "--resume")
    hybrid("run", path, "--out", tmp_path / "whole")
    assert largest_difference(points(tmp_path / "whole"), points(tmp_path / "out")) < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("ranks", [4, 8])
def test_more_ranks_than_cores(scene, tmp_path, ranks):
    """Sand that yields under a box, in blocks of two or three cells."""
    path, sizes = scene(SLIDE), ("--set", "grid.x.size=0.125", "grid.z.size=0.125")
    for number in (1, ranks):
        hybrid("run", path, "--out", tmp_path / str(number), "--ranks", number, *sizes)
    assert largest_difference(points(tmp_path / "1"), points(tmp_path / str(ranks))) < 1e-6
