"""A rough block on elastic soil in plane strain: soil beneath it sticks, where Newton's method finds slip to and fro."""

import numpy as np
import pytest

from hybrid.runtime.data import GEOMETRY
from hybrid.runtime.errors import StepError
from hybrid.scene.file import load_scene
from hybrid.setup.build import build
from hybrid.step import sticking

PRESSED = """
time = { step = 1.0, inertia = false }
[grid]
x = { start = -1.5, end = 2.0, size = 0.1 }
y = { start = 0.0, end = 1.0, collapsed = true }
z = { start = -1.5, end = 0.3, size = 0.1 }
faces = { z_min = "fixed" }
[soil]
top = 0.0
material = { law = "hencky", young = 10e6, poisson = 0.3, density = 1800.0 }
[[body]]
name = "block"
geometry = "GEOMETRY/box.geo"
parameters = { length = 1.0, width = 1.0, height = 0.5 }
density = 2000.0
position = [0.0, 0.5, 0.0]
rest_on = 0.0
friction = 0.3
[[stage]]
name = "press"
steps = 3
motion = [{ held = ["x"] }]
load = [{ force = [[0.0, 0.0, 0.0, 0.0], [3.0, 0.0, 0.0, -12e3]] }]
[[stage]]
name = "drag"
steps = 1
motion = [{ component = "x", velocity = 0.01 }]
"""


def block(tmp_path, keys=""):
    path = tmp_path / "pressed.toml"
    path.write_text(PRESSED.replace("GEOMETRY", str(GEOMETRY)).replace("friction = 0.3", f"friction = 0.3\n{keys}"))
    return build(load_scene(path))


def test_a_rough_block_is_pressed_and_slides(tmp_path):
    records = list(block(tmp_path).steps())
    weight = 0.5 * 2000.0 * 9.81
    forces = [record.bodies[0].contact_force for record in records]
    assert [force[2] for force in forces] == pytest.approx([weight + 4e3, weight + 8e3, weight + 12e3, weight], rel=1e-3)
    assert forces[-1][0] == pytest.approx(-0.3 * weight, rel=0.01)
    assert max(record.iterations for record in records) <= 20 and not any(record.rejections for record in records)


PAD = """
gravity = [0.0, 0.0, 0.0]
time = { step = 1.0, inertia = false }
[grid]
x = { start = -1.0, end = 3.0, size = 0.1 }
y = { start = 0.0, end = 1.0, collapsed = true }
z = { start = 0.0, end = 1.4, size = 0.1 }
faces = { z_min = "fixed" }
[soil]
lower = [0.0, 0.0, 0.0]
upper = [1.0, 1.0, 1.0]
material = { law = "hencky", young = 1e6, poisson = 0.3, density = 1000.0 }
[[body]]
name = "pad"
geometry = "GEOMETRY/box.geo"
parameters = { length = 0.6, width = 1.0, height = 0.2, size = 20.0 }
density = 2000.0
position = [0.5, 0.5, 1.1]
friction = 1.0
[[stage]]
name = "press"
steps = 2
held = ["x", "ry"]
motion = [{ component = "z", velocity = -0.005 }]
[[stage]]
name = "shear"
steps = 10
held = ["ry"]
motion = [{ held = ["z"] }, { component = "x", velocity = 0.004 }]
"""


def pad(tmp_path):
    path = tmp_path / "pad.toml"
    path.write_text(PAD.replace("GEOMETRY", str(GEOMETRY)))
    return build(load_scene(path))


def test_a_pad_that_sticks_shears_the_soil(tmp_path):
    """To a tenth of its height; the soil's stiffness is that of the first step, and no point slips."""
    records = list(pad(tmp_path).steps())
    along, _, across = abs(np.array([record.bodies[0].contact_force for record in records])).T
    assert along[-1] == pytest.approx(10 * along[2], rel=0.2) and across[2:] == pytest.approx(across[1], rel=0.05)
    assert sum(record.iterations for record in records) < 300


def test_stiffer_springs_of_a_pad_hardly_find_equilibrium(tmp_path, monkeypatch):
    """In nine times the iterations."""
    soft = sum(record.iterations for record in pad(tmp_path).steps())
    monkeypatch.setattr("hybrid.setup.penalty.SHEARED", 2000.0)
    assert sum(record.iterations for record in pad(tmp_path).steps()) > 5 * soft


def test_stiffer_springs_need_points_held_in_stick(tmp_path, monkeypatch):
    """Four times along the normal, and ten times as stiff along the surface beside these."""
    keys = "penalty = 20e3\ntangential = 3.0"
    for which in ("reversing", "drifting"):
        monkeypatch.setattr(sticking, which, lambda *given: None)
    with pytest.raises(StepError, match="step 1 failed"):
        next(block(tmp_path, keys).steps())
    monkeypatch.undo()
    assert next(block(tmp_path, keys).steps()).iterations <= 30


def test_soft_tangential_springs_need_fewer_iterations(tmp_path):
    """Which a body that cannot roll has by default (`hybrid.setup.rolling`): 19 instead of 39."""
    soft, stiff = (sum(record.iterations for record, _ in zip(block(tmp_path, keys).steps(), range(3)))
                   for keys in ("", "tangential = 3.0"))
    assert 1.2 * soft < stiff
