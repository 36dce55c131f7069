"""Soil that moves among several processes: points that cross over or leave the grid, a grid that follows a body, and
blocks that follow the work. They start mpirun on tiny scenes."""

import meshio
import numpy as np
import pytest
from rank_runs import (
    FOLLOWED_BOX,
    SLIDE,
    hybrid,
    largest_difference,
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


@pytest.mark.slow
def test_points_that_leave_the_grid(tmp_path):
    """Half of the block is frozen where it left; of one of three ranks, all of it."""
    path = scene_file(tmp_path, THROWN)
    for ranks in (1, 3):
        hybrid("run", path, "--out", tmp_path / str(ranks), "--ranks", ranks)
    one, three = (points(tmp_path / str(ranks), "inactive") for ranks in (1, 3))
    assert one["inactive"].sum() == 64 and (three["inactive"] == one["inactive"]).all()
    for name in ("position", "velocity", "stress"):
        assert np.abs(one[name] - three[name]).max() < 1e-6 * np.abs(one[name]).max(), name
    stop = settings("soil.stray='stop'")
    texts = [hybrid("run", path, "--out", tmp_path / f"stop{ranks}", "--ranks", ranks, *stop, code=2) for ranks in (1, 2)]
    assert texts[1].count("hybrid: ") == 1 and "points 112 at (2.019, " in texts[1]
    assert texts[0].splitlines()[-1] in texts[1].splitlines()      # which Open MPI 5 follows by a page of its own


# A box is pushed through sand; points are split, merged and left behind
PLOUGH = """
name = "plough"
time = { step = 0.04 }
output = { pictures = [], every = 5, checkpoint = 3 }
solver = { tolerance = 1e-8, linear_tolerance = 1e-6 }
""" + FOLLOWED_BOX + """
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


def test_grid_that_follows_a_body(tmp_path):
    """On three ranks, and as the run goes on with two and with one."""
    path = scene_file(tmp_path, PLOUGH)
    hybrid("run", path, "--out", tmp_path / "one")
    for steps, ranks in ((9, 3), (16, 2), (20, 1)):
        hybrid("run", path, "--out", tmp_path / "mixed", "--ranks", ranks, *settings(f"stage.go.steps={steps}"),
               *(["--resume"] if steps > 9 else []))
    expected, found = (read_history(tmp_path / folder) for folder in ("one", "mixed"))
    assert expected["energy_plastic_J"][-1] > 10.0
    for name in ("box_contact_fx_N", "box_contact_fz_N", "energy_plastic_J", "energy_left_J"):
        assert np.abs(found[name] - expected[name]).max() < 1e-6 * np.abs(expected[name]).max(), name
    for step in (5, 15):      # frames of three ranks and of two have the points left behind, each once
        one, mixed = (sum(len(meshio.read(file).points) for file in (tmp_path / folder).glob(f"soil_{step:06d}*.vtu"))
                      for folder in ("one", "mixed"))
        assert mixed == one > 256
    expected, found = (ground(tmp_path / folder) for folder in ("one", "mixed"))
    assert len(expected[3]) > 100
    for there, here in zip(found, expected):
        assert there.shape == here.shape and np.abs(there - here).max() < 1e-6 * np.abs(here).max()


SHARES = """
import sys
from hybrid.runtime import comm
from hybrid.step import processes
settled = processes._settled
def watched(model, state):
    model, state = settled(model, state)
    shares = comm.gathered([len(state.points)])
    assert max(shares) < 0.8 * sum(shares), f"uneven: {shares}"
    return model, state
processes._settled = watched
processes.GROWN = float(sys.argv.pop())
"""


@pytest.mark.parametrize(("grown", "uneven"), [(1.2, False), (1e9, True)])
def test_blocks_follow_soil_that_moves(tmp_path, grown, uneven):
    """A block of soil slides 1.9 m along: each of two ranks keeps half of it, but not where blocks stay as they are."""
    path = scene_file(tmp_path, THROWN.replace("end = 2.0", "end = 4.0").replace("steps = 14", "steps = 20"))
    text = program(patched(tmp_path / "shares.py", SHARES), "run", path, "--out", tmp_path / "two", grown, ranks=2,
                   fails=uneven)
    if uneven:
        assert "uneven: " in text
        return
    hybrid("run", path, "--out", tmp_path / "one")
    assert points(tmp_path / "one")["position"][:, 0].min() > 2.0
    assert largest_difference(points(tmp_path / "one"), points(tmp_path / "two")) < 1e-6


LANDING = """
import sys
import numpy as np
from hybrid.runtime import comm
from hybrid.step import processes
settled = processes._settled
found = sys.argv.pop()
def watched(model, state):
    model, state = settled(model, state)
    work, points = (comm.gathered([x]) for x in (len(state.points) + 0.5 * len(state.contacts[0].point), len(state.points)))
    if comm.number(state.contacts[0].point) > 50:
        with open(found, "a") as file:
            file.write(f"{max(work) / sum(work)} {max(points) / sum(points)}\\n")
    return model, state
processes._settled = watched
"""


def test_blocks_follow_contact(tmp_path):
    """A box falls on soil whose points stay in their cells: half of the work is each process's, not half of the points."""
    lands = SLIDE.replace("position = [1.2, 0.5, 0.0]\nrest_on = 0.0", "position = [0.5, 0.5, 0.24]").replace(
        "velocity = [1.0, 0.0, 0.0]", "velocity = [0.0, 0.0, -2.0]").replace(
        "size = 0.25", "size = 0.125").replace("start = -1.0", "start = -0.5")
    path, found = scene_file(tmp_path, lands), tmp_path / "found"
    program(patched(tmp_path / "landing.py", LANDING), "run", path, "--out", tmp_path / "two", found, ranks=2)
    work, points = np.loadtxt(found).T
    assert work.max() < 0.58 < points.max()
