"""Checkpoints in parts: no process ever holds all points, a kill at any moment leaves a whole one, any number goes on."""

import meshio
import numpy as np
import pytest
from rank_runs import hybrid, needs_mpirun, patched, program, scene_file, settings, state

pytestmark = needs_mpirun

SCENE = """
name = "pressed"
time = { step = 0.01 }
output = { pictures = [], every = 0, checkpoint = 2 }
solver = { tolerance = 1e-9, linear_tolerance = 1e-7 }
[grid]
x = { start = 0.0, end = 1.5, size = 0.25 }
y = { start = 0.0, end = 0.5, collapsed = true }
z = { start = -0.75, end = 0.5, size = 0.25 }
faces = { x_min = "roller", x_max = "roller", z_min = "fixed" }
[soil]
top = 0.0
material = { law = "hencky", young = 1e6, poisson = 0.3, density = 1800.0 }
[[body]]
name = "box"
geometry = "GEOMETRY/box.geo"
parameters = { length = 0.6, width = 0.5, height = 0.2, size = 20.0 }
density = 3000.0
position = [0.7, 0.25, 0.0]
rest_on = 0.0
friction = 0.3
velocity = [0.3, 0.0, 0.0]
[[stage]]
name = "press"
steps = 6
"""
ROCKING = """
name = "rocking"
time = { step = 0.004 }
output = { pictures = [], every = 0, checkpoint = 2 }
[grid]
x = { start = -1.0, end = 1.5, size = 0.25 }
y = { start = -1.0, end = 1.0, size = 0.25 }
z = { start = -0.5, end = 0.5, size = 0.25 }
[soil]
top = 0.0
held = true
material = { law = "hencky", young = 1e7, poisson = 0.3, density = 1800.0 }
[[body]]
name = "box"
geometry = "GEOMETRY/box.geo"
parameters = { length = 0.4, width = 0.5, height = 0.6, size = 20.0 }
density = 3000.0
position = [0.1, 0.05, 0.0]
rotation = [0.0, 1.0, 0.0, 8.0]
rest_on = 0.0
friction = 0.8
velocity = [0.0, 0.0, 0.0]
[[stage]]
name = "rock"
steps = 12
"""
IMPORTS = """
import os, sys
import numpy as np
from hybrid.runtime import ranks
"""
WATCHED = """
from hybrid.runtime import comm
def never(*_):
    raise AssertionError("all points in one process")
comm.to_first = never
"""
PATCHES = {
    "watched": WATCHED,
    "killed before its part": """
from hybrid.output import checkpoint
write = checkpoint.write
def killed(path, *rest):
    if path.name == "checkpoint_000004_r1.npz":
        while not path.with_name("checkpoint_000004_r0.npz").exists():
            pass
        os.kill(os.getpid(), 9)
    write(path, *rest)
checkpoint.write = killed
""",
    "watched, and killed before the list": WATCHED + """
from hybrid.output import checkpoint_file
replace = os.replace
def killed(source, path):
    if str(path).endswith("checkpoint.npz") and path.with_name("checkpoint_000004_r1.npz").exists():
        os.kill(os.getpid(), 9)
    replace(source, path)
os.replace = killed
""",
    "full disk": """
import errno
from hybrid.output import checkpoint_file
write = checkpoint_file._write
def full(file, arrays):
    if ranks.rank() == 1 and arrays["state/step"] == 4:
        raise OSError(errno.ENOSPC, "No space left on device", file.name)
    write(file, arrays)
checkpoint_file._write = full
""",
    "a signal to one": """
import signal
from hybrid.step import newton
solve = newton.solve
def stopped(step, *how):
    if step.state.step == 2 and ranks.rank() == 1:
        os.kill(os.getpid(), signal.SIGTERM)
    return solve(step, *how)
newton.solve = stopped
""",
    "a picture": """
from hybrid.output import pictures
class Drawing:
    def __init__(self, path, arrays, caption):
        np.savez(path.with_suffix(".npz"), **arrays)
    def collect(self, limit=0):
        return True
pictures.Drawing = Drawing
""",
}


@pytest.fixture
def run(tmp_path):
    def started(folder, *arguments, ranks=1, patch=None, fails=False):
        """stderr of a run of the scene into a folder, on so many processes, in a program if it is patched."""
        scene = scene_file(tmp_path, SCENE)
        if patch is None:
            return hybrid("run", scene, "--out", tmp_path / folder, "--ranks", ranks, *arguments)
        script = patched(tmp_path / "script.py", IMPORTS + PATCHES[patch])
        return program(script, "run", scene, "--out", tmp_path / folder, *arguments, ranks=ranks, fails=fails)
    return started


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """State at the end of a run by one process in one go."""
    folder = tmp_path_factory.mktemp("whole")
    hybrid("run", scene_file(folder, SCENE), "--out", folder / "out")
    return state(folder / "out")


def assert_ends_as(whole, folder):
    last = state(folder)
    assert last.step == whole.step and len(last.contacts[0].point) == len(whole.contacts[0].point) > 4
    for name in ("position", "velocity", "stress"):
        one, other = getattr(whole.points, name), getattr(last.points, name)
        assert np.abs(one - other).max() < 1e-6 * np.abs(one).max(), name
    assert np.array_equal(last.contacts[0].point, whole.contacts[0].point)
    assert last.bodies[0].position == pytest.approx(whole.bodies[0].position, abs=1e-9)


def files(folder):
    return sorted(path.name for path in folder.glob("*checkpoint*")) + sorted(path.name for path in folder.glob(".*partial"))


@pytest.mark.slow
def test_a_killed_run_goes_on_with_any_number_of_processes(run, whole, tmp_path):
    """It is killed when the parts of step 4 are written and their list is not. From step 2 it goes on from 2 to 3
    processes, from 3 to 1, and from 1 to 2. No process has all points meanwhile."""
    out = tmp_path / "out"
    run("out", ranks=2, patch="watched, and killed before the list", fails=True)
    assert state(out).step == 2 and (out / "checkpoint_000004_r1.npz").exists()
    with np.load(out / "checkpoint.npz") as listed, np.load(out / "checkpoint_000002_r1.npz") as part:
        assert not [name for name in listed.files if name.startswith("points/")]
        assert 0.3 < len(part["points/position"]) / len(whole.points) < 0.7
    run("out", "--resume", *settings("stage.press.steps=4"), ranks=3, patch="watched")
    assert files(out) == ["checkpoint.npz", *(f"checkpoint_000004_r{rank}.npz" for rank in range(3))]
    run("out", "--resume", *settings("stage.press.steps=5"))
    assert files(out) == ["checkpoint.npz"]
    run("out", "--resume", ranks=2, patch="watched")
    assert_ends_as(whole, out)


@pytest.mark.parametrize("how", ["killed before its part", "full disk"])
def test_a_part_that_is_not_written_leaves_the_checkpoint_before(run, tmp_path, how):
    out = tmp_path / "out"
    text = run("out", ranks=2, patch=how, fails=True)
    assert state(out).step == 2
    assert (out / "checkpoint_000004_r0.npz").exists() and not (out / "checkpoint_000004_r1.npz").exists()
    if how == "full disk":
        assert "No space left on device; process 1" in text and "the state after step 2" in text


def test_a_signal_to_one_process_ends_all_after_the_step_with_a_checkpoint(run, tmp_path):
    text = run("out", *settings("output.checkpoint=100"), ranks=2, patch="a signal to one", fails=True)
    assert "interrupted by SIGTERM; step 3 is kept: continue with --resume" in text
    assert state(tmp_path / "out").step == 3


@pytest.mark.slow
def test_pictures_and_frames_of_bodies_have_what_all_processes_have(run, tmp_path):
    drawn = "output.pictures=[3]", "output.every=2", "stage.press.steps=4"
    for ranks in (1, 2):
        run(str(ranks), *settings(*drawn), ranks=ranks, patch="a picture")
    with np.load(tmp_path / "1/soil_step_003.npz") as one, np.load(tmp_path / "2/soil_step_003.npz") as two:
        for name in one.files:
            assert one[name] == pytest.approx(two[name], rel=1e-6, abs=1e-9), name
    one, two = (meshio.read(tmp_path / folder / "body_box_000002.vtu").point_data["contact_force"] for folder in "12")
    assert np.abs(one).max() > 10.0 and np.abs(one - two).max() < 1e-5 * np.abs(one).max()


def test_a_body_that_rocks_on_held_ground_goes_on_with_any_number_of_processes(tmp_path):
    """It touches the ground at places on itself, which no point of the ground owns: with friction their history decides."""
    scene = scene_file(tmp_path, ROCKING)
    hybrid("run", scene, "--out", tmp_path / "whole")
    for stop, ranks in ((4, 2), (8, 1), (None, 2)):
        resumed = [] if stop == 4 else ["--resume"]
        hybrid("run", scene, "--out", tmp_path / "out", *resumed, "--ranks", ranks,
               *(settings(f"stage.rock.steps={stop}") if stop else []))
        assert state(tmp_path / "out").contacts[0].touching.any()
    whole, last = state(tmp_path / "whole"), state(tmp_path / "out")
    assert len(whole.contacts[0].point) and (whole.contacts[0].point == -1).all()
    for name in ("point", "place"):
        assert np.array_equal(getattr(last.contacts[0], name), getattr(whole.contacts[0], name))
    assert last.step == whole.step == 12
    assert last.bodies[0].position == pytest.approx(whole.bodies[0].position, abs=1e-9)
    assert last.bodies[0].spin == pytest.approx(whole.bodies[0].spin, abs=1e-7)
