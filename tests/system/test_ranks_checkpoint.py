"""Checkpoints in parts: no process ever holds all points, a kill at any moment leaves a whole one, any number goes on."""

import shutil
import subprocess
import sys

import meshio
import numpy as np
import pytest

from hybrid.output import checkpoint
from hybrid.runtime.ranks import launch

pytest.importorskip("mpi4py")
pytestmark = pytest.mark.skipif(shutil.which("mpirun") is None, reason="needs mpirun")

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
def stopped(step):
    if step.state.step == 2 and ranks.rank() == 1:
        os.kill(os.getpid(), signal.SIGTERM)
    return solve(step)
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
def hybrid(tmp_path, geometry):
    def run(folder, *arguments, ranks=1, patch=None, code=0):
        """stderr of a run of the scene into a folder, on so many processes, in a program that is patched."""
        scene, script = tmp_path / "scene.toml", tmp_path / "script.py"
        scene.write_text(SCENE.replace("GEOMETRY", str(geometry)))
        script.write_text("import os, sys\nimport numpy as np\nfrom hybrid.runtime import ranks\n" + PATCHES.get(patch, "")
                          + "\nfrom hybrid.cli import main\nsys.exit(main(sys.argv[1:]))")
        command, environment = launch(ranks, [script, "run", scene, "--out", tmp_path / folder, *arguments])
        command = command if ranks > 1 else [sys.executable, *command[4:]]
        done = subprocess.run(command, env={**environment, "NUMBA_NUM_THREADS": "1"}, capture_output=True, text=True, timeout=120)
        assert (done.returncode != 0) == bool(code), done.stderr
        return done.stderr
    return run


@pytest.fixture(scope="module")
def whole(tmp_path_factory, geometry):
    """State at the end of a run by one process in one go."""
    folder = tmp_path_factory.mktemp("whole")
    (folder / "scene.toml").write_text(SCENE.replace("GEOMETRY", str(geometry)))
    subprocess.run([sys.executable, "-m", "hybrid", "run", folder / "scene.toml", "--out", folder / "out"], check=True)
    return checkpoint.load(folder / "out" / "checkpoint.npz")


def assert_ends_as(whole, folder):
    state = checkpoint.load(folder / "checkpoint.npz")
    assert state.step == whole.step and len(state.contacts[0].point) == len(whole.contacts[0].point) > 4
    for name in ("position", "velocity", "stress"):
        one, other = getattr(whole.points, name), getattr(state.points, name)
        assert np.abs(one - other).max() < 1e-6 * np.abs(one).max(), name
    assert np.array_equal(state.contacts[0].point, whole.contacts[0].point)
    assert state.bodies[0].position == pytest.approx(whole.bodies[0].position, abs=1e-9)


def files(folder):
    return sorted(path.name for path in folder.glob("*checkpoint*")) + sorted(path.name for path in folder.glob(".*partial"))


def test_a_killed_run_goes_on_with_any_number_of_processes(hybrid, whole, tmp_path):
    """It is killed when the parts of step 4 are written and their list is not. From step 2 it goes on from 2 to 3 processes, from
    3 to 1, and from 1 to 2. No process has all points meanwhile."""
    out = tmp_path / "out"
    hybrid("out", ranks=2, patch="watched, and killed before the list", code=1)
    assert checkpoint.load(out / "checkpoint.npz").step == 2 and (out / "checkpoint_000004_r1.npz").exists()
    with np.load(out / "checkpoint.npz") as listed, np.load(out / "checkpoint_000002_r1.npz") as part:
        assert not [name for name in listed.files if name.startswith("points/")]
        assert 0.3 < len(part["points/position"]) / len(whole.points) < 0.7
    hybrid("out", "--resume", "--set", "stage.press.steps=4", ranks=3, patch="watched")
    assert files(out) == ["checkpoint.npz", *(f"checkpoint_000004_r{rank}.npz" for rank in range(3))]
    hybrid("out", "--resume", "--set", "stage.press.steps=5")
    assert files(out) == ["checkpoint.npz"]
    hybrid("out", "--resume", ranks=2, patch="watched")
    assert_ends_as(whole, out)


@pytest.mark.parametrize("how", ["killed before its part", "full disk"])
def test_a_part_that_is_not_written_leaves_the_checkpoint_before(hybrid, tmp_path, how):
    out = tmp_path / "out"
    text = hybrid("out", ranks=2, patch=how, code=1)
    assert checkpoint.load(out / "checkpoint.npz").step == 2
    assert (out / "checkpoint_000004_r0.npz").exists() and not (out / "checkpoint_000004_r1.npz").exists()
    if how == "full disk":
        assert "No space left on device; process 1" in text and "the state after step 2" in text


def test_a_signal_to_one_process_ends_all_after_the_step_with_a_checkpoint(hybrid, tmp_path):
    text = hybrid("out", "--set", "output.checkpoint=100", ranks=2, patch="a signal to one", code=1)
    assert "interrupted by SIGTERM; step 3 is kept: continue with --resume" in text
    assert checkpoint.load(tmp_path / "out/checkpoint.npz").step == 3


def test_pictures_and_frames_of_bodies_have_what_all_processes_have(hybrid, tmp_path):
    drawn = "output.pictures=[3]", "output.every=2", "stage.press.steps=4"
    for ranks in (1, 2):
        hybrid(str(ranks), *(text for key in drawn for text in ("--set", key)), ranks=ranks, patch="a picture")
    with np.load(tmp_path / "1/soil_step_003.npz") as one, np.load(tmp_path / "2/soil_step_003.npz") as two:
        for name in one.files:
            assert one[name] == pytest.approx(two[name], rel=1e-6, abs=1e-9), name
    one, two = (meshio.read(tmp_path / folder / "body_box_000002.vtu").point_data["contact_force"] for folder in "12")
    assert np.abs(one).max() > 10.0 and np.abs(one - two).max() < 1e-5 * np.abs(one).max()
