"""Several processes give what one gives, to the tolerance of the solver, and end together. They start mpirun on tiny
scenes."""

import time
from pathlib import Path

import numpy as np
import pytest
from rank_runs import (
    COLUMN,
    DEMOS,
    SLIDE,
    history,
    hybrid,
    largest_difference,
    launched,
    needs_mpirun,
    patched,
    points,
    program,
    scene_file,
    settings,
    state,
)

from hybrid.output.history import read_history

pytestmark = needs_mpirun


def test_elastic_column_and_resuming_on_another_number_of_ranks(tmp_path):
    path = scene_file(tmp_path, COLUMN)
    hybrid("run", path, "--out", tmp_path / "one")
    text = launched("run", path, "--out", tmp_path / "two", "--ranks", 2)
    assert "btl_tcp" not in text      # Open MPI about a network that one machine does not need
    hybrid("run", path, "--out", tmp_path / "mixed", "--ranks", 3, "--set", "stage.settle.steps=2")
    hybrid("run", path, "--out", tmp_path / "mixed", "--resume")
    for name in ("two", "mixed"):
        assert largest_difference(points(tmp_path / "one"), points(tmp_path / name)) < 1e-6
        assert largest_difference(history(tmp_path / "one"), history(tmp_path / name)) < 1e-6


def test_body_that_slides_on_yielding_sand(tmp_path):
    path = scene_file(tmp_path, SLIDE)
    hybrid("run", path, "--out", tmp_path / "one")
    hybrid("run", path, "--out", tmp_path / "three", "--ranks", 3)
    found, expected = history(tmp_path / "three"), history(tmp_path / "one")
    assert expected["box_contact_fz_N"].min() > 1e3 and expected["energy_plastic_J"][-1] > 0.01
    for name in ("box_x_m", "box_z_m", "box_vx_m_per_s", "box_contact_fx_N", "box_contact_fz_N", "energy_plastic_J"):
        assert np.abs(found[name] - expected[name]).max() < 1e-4 * np.abs(expected[name]).max(), name
    for name in ("position", "stress"):
        one, three = points(tmp_path / "one")[name], points(tmp_path / "three")[name]
        assert np.abs(one - three).max() < 1e-3 * np.abs(one).max()


@pytest.mark.slow
def test_bodies_that_rest_on_one_another(tmp_path):
    """The demo stack.toml on cells of 0.5 m, four steps: forces of the soil and of blocks on one another."""
    keys = [f"grid.{axis}.size=0.5" for axis in "xyz"] + ["grid.y.start=-1.5", "grid.y.end=1.5"]
    keys += ["stage.stand.steps=4", "stage.drop.steps=1", "output.every=0", "output.pictures=[]"]
    for folder, ranks in (("one", 1), ("two", 2)):
        hybrid("run", DEMOS / "stack.toml", *settings(*keys), "--out", tmp_path / folder, *(["--ranks", 2] * (ranks > 1)))
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
geometry = "GEOMETRY/box.geo"
parameters = {{ length = 0.5, width = 0.4, height = 0.2, size = 20.0 }}
density = 2000.0
position = [{x}, 0.0, 0.0]
rest_on = 0.0
friction = 0.4
""" for name, x in (("a", -0.3), ("b", 0.3)))


def test_joined_bodies_on_soil(tmp_path):
    """Poses, force and angle of the hinge between two boxes are those of one rank."""
    path = scene_file(tmp_path, JOINED)
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
    return [DEMOS / "anchor.toml", *settings(*keys)]


@pytest.fixture(scope="module")
def two(tmp_path_factory):
    """History of the coarse anchor on two ranks."""
    folder = tmp_path_factory.mktemp("anchor")
    hybrid("run", *coarse_anchor("stage.0.steps=6", "stage.1.steps=8"), "--out", folder, "--ranks", 2)
    return read_history(folder)


def test_few_nodes_of_all_ranks_are_solved_for_by_themselves(two, tmp_path):
    """Nonlinear elimination: as few iterations as on one rank (6 a step at most), to the same place."""
    hybrid("run", *coarse_anchor("stage.0.steps=6", "stage.1.steps=8"), "--out", tmp_path, "--ranks", 1)
    one = read_history(tmp_path)
    assert two["iterations"].max() <= 6 and two["iterations"].sum() <= 1.05 * one["iterations"].sum()
    assert two["anchor_z_m"] == pytest.approx(one["anchor_z_m"], abs=1e-5)
    assert two["anchor_tension_N"][-1] == pytest.approx(one["anchor_tension_N"][-1], rel=1e-4)


BLOCK = """
name = "block"
time = { step = 0.01 }
output = { pictures = [], every = 0, checkpoint = 0 }
[soil]
top = 1.0
geostatic = false
[soil.material]
law = "drucker-prager"
young = 1e7
poisson = 0.3
density = 1800.0
friction_angle = 32.0
dilation_angle = 2.0
cohesion = 1e3
[grid]
x = { start = 0.0, end = 2.0, size = 0.1 }
y = { start = 0.0, end = 2.0, size = 0.1 }
z = { start = 0.0, end = 1.2, size = 0.1 }
[[stage]]
name = "fall"
steps = 2
"""


def test_the_preconditioner_has_the_stiffness_of_all_ranks(tmp_path):
    """2 % more GMRES iterations on two ranks than on one; six times as many where entries on a cut are those of one rank
    only."""
    path = scene_file(tmp_path, BLOCK)
    for ranks in (1, 2):
        hybrid("run", path, "--out", tmp_path / str(ranks), "--ranks", ranks)
    one, two = (read_history(tmp_path / str(ranks)) for ranks in (1, 2))
    assert two["krylov"].sum() <= 1.15 * one["krylov"].sum()


DIVIDED = """
from hybrid.linalg import system_cache
system_cache.COPIED = 0
"""


@pytest.mark.slow
def test_few_unknowns_that_each_rank_solves_for_are_those_of_a_divided_factor(two, tmp_path):
    """Over the first steps: later ones may differ by an iteration, as rounding grows."""
    scene = coarse_anchor("stage.0.steps=6", "stage.1.steps=1")
    program(patched(tmp_path / "divided.py", DIVIDED), "run", *scene, "--out", tmp_path / "out", ranks=2)
    divided = read_history(tmp_path / "out")
    first = len(divided["iterations"])
    assert list(two["iterations"][:first]) == list(divided["iterations"])
    assert two["anchor_z_m"][:first] == pytest.approx(divided["anchor_z_m"], abs=1e-8)


def test_sphere_on_held_ground(tmp_path):
    keys = ["stage.0.steps=12", "output.every=0", "output.pictures=[]"]
    for ranks in (1, 2):
        hybrid("run", DEMOS / "rolling_sphere.toml", *settings(*keys), "--out", tmp_path / str(ranks), "--ranks", ranks)
    one, two = (read_history(tmp_path / str(ranks)) for ranks in (1, 2))
    for name in ("sphere_x_m", "sphere_spin_y_rad_per_s", "sphere_contact_fx_N"):
        assert np.abs(one[name]).max() > 0.5 and two[name] == pytest.approx(one[name], rel=1e-6), name


@pytest.mark.slow   # test_sliding_on_clay has a bond shared by two ranks
def test_clay_that_sticks_to_a_pipe_and_breaks_away(tmp_path):
    """The demo pipe.toml on coarse cells, its bond of 200 Pa: contact points bear the interface of those of another rank.
    With those of their own rank alone the pipe ends 1 mm elsewhere."""
    keys = ["grid.x.size=0.125", "grid.z.size=0.125", "stage.1.steps=10", "output.every=0", "output.pictures=[]",
            "output.checkpoint=2", "solver.tolerance=1e-7", "solver.linear_tolerance=1e-5", "body.0.tension=200.0"]
    for ranks in (1, 2):
        hybrid("run", DEMOS / "pipe.toml", *settings(*keys), "--out", tmp_path / str(ranks), "--ranks", ranks)
    one, two = (read_history(tmp_path / str(ranks)) for ranks in (1, 2))
    for name in ("pipe_z_m", "pipe_contact_fx_N", "pipe_contact_fz_N", "energy_friction_J"):
        assert np.abs(one[name] - two[name]).max() < 1e-4 * np.abs(one[name]).max(), name
    opened = state(tmp_path / "2").contacts[0].opened
    assert opened.any() and not opened.all()


# A box above clay, four cells wide: put down by its weight, or driven in steps in which a wave crosses a hundred cells
ABOVE = """
name = "above"
time = { step = 0.5INERTIA }
output = { pictures = [], every = 0, checkpoint = 0 }
solver = { tolerance = 1e-7, linear_tolerance = 1e-5 }
grid.x = { start = -2.0, end = 2.0, size = 0.25 }
grid.y = { start = 0.0, end = 1.0, collapsed = true }
grid.z = { start = -1.5, end = 0.75, size = 0.25 }
grid.faces = { z_min = "fixed" }
soil.top = 0.0
soil.material = { law = "von-mises", young = 5e6, poisson = 0.49, density = 1700.0, strength = 1e4 }
stage = [{ name = "down", steps = 2 }]
[[body]]
name = "box"
geometry = "GEOMETRY/box.geo"
parameters = { length = 1.0, width = 1.0, height = 0.5, size = 20.0 }
density = 3000.0
"""
LAID = ABOVE.replace("INERTIA", ", inertia = false") + "position = [0.1, 0.5, 0.35]"
PRESSED = ABOVE.replace("INERTIA", "") + """position = [0.1, 0.5, 0.25]
held = ["x", "ry"]
driven = ["z"]
velocity = [0.0, 0.0, -0.02]
"""


@pytest.mark.parametrize("text", [pytest.param(LAID, marks=pytest.mark.slow), PRESSED], ids=["put down", "long steps"])
def test_starts_of_an_increment_are_those_of_all_ranks(text, tmp_path):
    """The search for the place where contact bears a body; soil at rest, tried where its last velocities lead nowhere."""
    path = scene_file(tmp_path, text)
    for ranks in (1, 2):
        hybrid("run", path, "--out", tmp_path / str(ranks), "--ranks", ranks)
    one, two = (read_history(tmp_path / str(ranks)) for ranks in (1, 2))
    assert two["box_z_m"] == pytest.approx(one["box_z_m"], abs=1e-6)
    assert two["box_contact_fz_N"] == pytest.approx(one["box_contact_fz_N"], rel=1e-3)
    # the long step takes 26 to 34 by round-off alone
    assert abs(two["iterations"].sum() - one["iterations"].sum()) <= 0.3 * one["iterations"].sum()


@pytest.mark.slow
@pytest.mark.parametrize("ranks", [4, 8])
def test_more_ranks_than_cores(tmp_path, ranks):
    """Sand that yields under a box, in blocks of two or three cells."""
    path, sizes = scene_file(tmp_path, SLIDE), settings("grid.x.size=0.125", "grid.z.size=0.125")
    for number in (1, ranks):
        hybrid("run", path, "--out", tmp_path / str(number), "--ranks", number, *sizes)
    assert largest_difference(points(tmp_path / "1"), points(tmp_path / str(ranks))) < 1e-6


def test_what_ranks_cannot_do_is_refused_once(tmp_path):
    path = scene_file(tmp_path, COLUMN)
    sizes = settings("grid.x.size=1.0", "grid.y.size=0.5", "grid.z.size=0.5")
    text = hybrid("run", path, "--out", tmp_path / "out", "--ranks", 4, *sizes, code=2)
    assert text.count("hybrid: ") == 1 and "run on one rank, or on fewer" in text
    assert not (tmp_path / "out" / "history.csv").exists()


FAULT = """
import sys
from hybrid.runtime import ranks
ranks.end_together.__defaults__ = (2.0,)    # [s] that the others have to end by themselves, instead of 10
from hybrid.step import newton
solve = newton.solve
def broken(step, *how):
    if step.state.step == 2 and ranks.rank() == 1:
        raise ArithmeticError("made for the test")
    return solve(step, *how)
newton.solve = broken
"""


def test_a_fault_of_one_rank_ends_all_and_names_it(tmp_path):
    path = scene_file(tmp_path, COLUMN)
    text = program(patched(tmp_path / "fault.py", FAULT), "run", path, "--out", tmp_path / "out", ranks=2, fails=True)
    assert text.count("ArithmeticError: made for the test") == 1 and "on rank 1 of 2" in text
    hybrid("run", path, "--out", tmp_path / "out", "--resume")
    assert len(history(tmp_path / "out")["energy_kinetic_J"]) == 4


SCRIPT = """
import sys
from hybrid import build
from hybrid.runtime import ranks
from hybrid.scene.file import load_scene
ranks.end_together.__defaults__ = (2.0,)
for record in build(load_scene(sys.argv[1])).steps():
    if record.step == 2 and (ranks.rank() == 1 or sys.argv[2] == "all"):
        raise ArithmeticError("made for the test")
"""


@pytest.mark.parametrize("who, words", [("one", "on rank 1 of 2"), ("all", "")])
def test_a_fault_in_a_script_of_the_user_ends_all(tmp_path, who, words):
    """Which would wait for one another forever; told once."""
    (tmp_path / "script.py").write_text(SCRIPT)
    text = program(tmp_path / "script.py", scene_file(tmp_path, COLUMN), who, ranks=2, fails=True)
    assert text.count("ArithmeticError: made for the test") == 1 and words in text
    assert ("on rank" in text) == (who == "one")


KILLED = """
import os, sys
from hybrid.runtime import ranks
from hybrid.step import newton
solve = newton.solve
with open(f"{sys.argv.pop()}/{ranks.rank()}.pid", "w") as file:
    file.write(str(os.getpid()))
def killed(step, *how):
    if step.state.step == 3 and ranks.rank() == 1:
        os.kill(os.getpid(), 9)
    return solve(step, *how)
newton.solve = killed
"""


def runs(number):
    """Whether a process exists, other than one that has ended and waits to be asked how."""
    try:
        return Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except (FileNotFoundError, ProcessLookupError):
        return False


def test_killing_a_rank_ends_all_and_the_run_goes_on(tmp_path):
    """As the kernel does when memory is short. The last checkpoint goes on with another number of ranks."""
    path = scene_file(tmp_path, COLUMN)
    program(patched(tmp_path / "killed.py", KILLED), "run", path, "--out", tmp_path / "out", tmp_path, ranks=2, fails=True)
    numbers, end = [int(file.read_text()) for file in tmp_path.glob("*.pid")], time.monotonic() + 10
    while any(map(runs, numbers)) and time.monotonic() < end:
        time.sleep(0.1)
    assert len(numbers) == 2 and not any(map(runs, numbers))
    hybrid("run", path, "--out", tmp_path / "out", "--resume")
    hybrid("run", path, "--out", tmp_path / "whole")
    assert largest_difference(points(tmp_path / "whole"), points(tmp_path / "out")) < 1e-6
