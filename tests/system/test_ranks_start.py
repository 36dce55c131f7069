"""The start of several processes: each makes the points of its own cells, and of a new window its share. None ever has
all."""

import json

import numpy as np
import pytest
import rank_pool
from counted_points import largest_share
from rank_runs import FOLLOWED_BOX, ground_apart, needs_mpirun, scene_file

from hybrid.output import checkpoint

pytestmark = needs_mpirun

HEAD = """
name = "start"
time = {{ step = 0.01{time} }}
output = {{ pictures = [], every = 0, checkpoint = 2 }}
solver = {{ tolerance = 1e-9, linear_tolerance = 1e-7 }}
stage = [{{ name = "go", steps = {steps} }}]
"""
SAND = 'law = "drucker-prager", young = 2e7, poisson = 0.3, density = 1700.0, friction_angle = 35.0, dilation_angle = 5.0'
# Cells that grow away from a box that presses on layered sand
GRADED = HEAD.format(time="", steps=2) + """
grid.x = { start = 0.0, end = 3.0, size = 0.125, fine = [0.5, 1.25], growth = 1.3 }
grid.y = { start = 0.0, end = 0.5, size = 0.25 }
grid.z = { start = -1.5, end = 0.5, size = 0.125, fine = [-0.5, 0.25], growth = 1.3 }
grid.faces = { x_min = "roller", x_max = "roller", y_min = "roller", y_max = "roller", z_min = "fixed" }
soil.top = 0.0
soil.material = { SAND, cohesion = 1e4 }
soil.layer = [{ name = "dense", bottom = -1.5, top = -1.0, material = { density = 2000.0, hardening = 1e5 } }]
[[body]]
name = "box"
geometry = "GEOMETRY/box.geo"
parameters = { length = 0.6, width = 0.3, height = 0.2, size = 20.0 }
density = 3000.0
position = [0.9, 0.25, 0.0]
rest_on = 0.0
friction = 0.3
"""
# Soil cut to a slope, which settles before the first step
SLOPE = HEAD.format(time=", inertia = false", steps=2) + """
grid.x = { start = 0.0, end = 5.0, size = 0.25 }
grid.y = { start = 0.0, end = 0.5, collapsed = true }
grid.z = { start = -1.5, end = 1.0, size = 0.25 }
grid.faces = { x_min = "roller", x_max = "roller", z_min = "fixed" }
soil.top = 0.75
soil.ground = [[0.0, 0.7], [2.0, 0.6], [3.5, -0.35], [5.0, -0.3]]
soil.material = { SAND, cohesion = 2e4 }
"""
# A tilted plate in clay from the start: domains are cut, numbered anew and touched on both sides of a cut between two blocks
IN_PLACE = HEAD.format(time=", inertia = false", steps=2) + """
grid.x = { start = -1.6, end = 1.6, size = 0.2 }
grid.y = { start = 0.0, end = 0.05, collapsed = true }
grid.z = { start = -3.0, end = 0.2, size = 0.2 }
grid.faces = { z_min = "fixed" }
soil.top = 0.0
soil.material = { law = "von-mises", young = 5e6, poisson = 0.49, density = 1700.0, strength = 1e4, cone = "plane strain" }
[[body]]
name = "plate"
geometry = "GEOMETRY/box.geo"
parameters = { length = 1.0, width = 0.1, height = 0.24, size = 0.12 }
density = 7850.0
position = [0.0, 0.025, -1.487]
rotation = [0.0, 1.0, 0.0, 30.0]
held = ["x", "y", "z", "rx", "ry", "rz"]
"""
GO = 'steps = 8, motion = [{ component = "x", velocity = 6.0 }]'
MOVING = HEAD.format(time="", steps=8).replace("steps = 8", GO) + FOLLOWED_BOX
SCENES = {"graded": GRADED, "slope": SLOPE, "in place": IN_PLACE, "moving": MOVING}


def run(tmp_path, name, number):
    """(Largest share of all points that a process has had, folder) of a scene on so many processes."""
    scene, out = scene_file(tmp_path, SCENES[name].replace("SAND", SAND)), tmp_path / str(number)
    if number == 1:
        return largest_share(scene, out), out
    (share, _), *_ = rank_pool.call(number, "counted_points.largest_share", scene, out)
    return share, out


def order(state):
    """Points in the order of their initial places, where a grid has added some, else of their numbers."""
    if state.ground is None:
        return np.arange(len(state.points))
    return np.lexsort(np.round(state.ground.constants.position, 6).T)


def assert_same(out, expected):
    """Points in the same order, and the same ones touch. Which of two domains has the face between them depends on round-off
    where both lie alike; such faces do not touch."""
    one, other = (checkpoint.load(folder / "checkpoint.npz") for folder in (expected, out))
    assert len(one.points) == len(other.points)
    for field in ("position", "half_width", "velocity", "stress"):
        values, found = (getattr(state.points, field)[order(state)] for state in (one, other))
        assert np.abs(values - found).max() <= 2e-6 * np.abs(values).max(), field
    for touched, found in zip(one.contacts, other.contacts) if one.ground is None else ():
        assert touched.touching.sum() > 10
        for field in ("point", "place"):
            assert np.array_equal(getattr(touched, field)[touched.touching], getattr(found, field)[found.touching])
        assert np.abs(touched.position[touched.touching] - found.position[found.touching]).max() < 1e-7


def sizes(folder):
    """Model sheet of a run without what the solver's tolerance changes."""
    sheet = json.loads((folder / "summary.json").read_text())["sizes"]
    for row in ("processes", "settled at the start", "initial imbalance"):
        sheet["modelled"].pop(row, None)
    return sheet


@pytest.mark.parametrize(("name", "ranks"), [("graded", 2), ("slope", 2), ("in place", 2), ("moving", 2), *(
    pytest.param(*case, marks=pytest.mark.slow) for case in (("graded", 3), ("slope", 3), ("in place", 3), ("moving", 3)))])
def test_no_process_has_all_points_and_all_are_those_of_one(tmp_path, name, ranks):
    """Also numbers of cells, points, unknowns and entries, and what is not modelled, are those of one process."""
    whole, expected = run(tmp_path, name, 1)
    assert whole >= 1.0
    share, out = run(tmp_path, name, ranks)
    assert share < {2: 0.75, 3: 0.6}[ranks]
    assert_same(out, expected)
    assert name == "moving" or sizes(out) == sizes(expected)    # one process writes that of the grid at the end


def test_all_processes_take_slopes_of_the_ground_over_the_same_distance(tmp_path):
    """That of the finest cells, which one of them has."""
    fine = "size = 0.1, fine = [0.0, 1.0], growth = 1.3 }"
    scene = scene_file(tmp_path, SLOPE.replace("SAND", SAND).replace("size = 0.25 }", fine, 1))
    (one, _), (other, _) = rank_pool.call(2, "rank_runs.ground_apart", scene)
    assert one == other == pytest.approx(ground_apart(scene))
