"""The first guess of an increment without inertia: bodies that touch nothing yet, soil that just touches, bodies drawn back."""

import numpy as np
import pytest

import hybrid
from hybrid.runtime.errors import StepError
from hybrid.step import increments, newton

MAT = """
time = { step = 1.0, inertia = false }
[grid]
x = { start = 0.0, end = 4.0, size = 0.1 }
y = { start = 0.0, end = 1.0, collapsed = true }
z = { start = -3.0, end = 0.4, size = 0.1 }
faces = { z_min = "fixed" }
[soil]
top = 0.0
material = { law = "von-mises", young = 5e6, poisson = 0.49, density = 1700.0, strength = 10e3 }
[[body]]
name = "mat"
geometry = "GEOMETRY/box.geo"
parameters = { length = 1.6, width = 1.0, height = 0.5, size = 20.0 }
density = 2400.0
position = [0.0, 0.5, 0.0]
rest_on = 0.001
held = ["x", "ry"]
[[stage]]
name = "rest"
steps = 2
"""
WALL = """
time = { step = 1.0, inertia = false }
[grid]
x = { start = -0.9, end = 4.5, size = 0.15 }
y = { start = 0.0, end = 1.0, collapsed = true }
z = { start = 0.0, end = 2.55, size = 0.15 }
[soil]
lower = [0.0, 0.0, 0.0]
upper = [4.5, 1.0, 2.1]
material = { law = "drucker-prager", young = 2e7, poisson = 0.3, density = 1700.0, friction_angle = 33.0, dilation_angle = 3.0, cohesion = 0.0 }
[[body]]
name = "wall"
geometry = "GEOMETRY/box.geo"
parameters = { length = 0.3, width = 1.0, height = 2.4, size = 20.0 }
density = 2400.0
position = [-0.15, 0.5, 1.2]
held = ["x", "z", "ry"]
[[stage]]
name = "stand"
steps = 1
"""
DRAWN = """
time = { step = 1.0, inertia = false }
[grid]
x = { start = -1.8, end = 6.0, size = 0.15 }
y = { start = 0.0, end = 1.0, collapsed = true }
z = { start = -3.9, end = 0.3, size = 0.15 }
faces = { z_min = "fixed" }
[soil]
top = 0.0
ground = [[0.0, -3.0], [0.001, 0.0]]
material = { law = "von-mises", young = 5e6, poisson = 0.49, density = 1733.0, strength = 8e3 }
[[soil.layer]]
name = "rock"
top = -3.0
material = { strength = 200e3, young = 50e6 }
[[body]]
name = "wall"
geometry = "GEOMETRY/box.geo"
parameters = { length = 0.53, width = 1.0, height = 3.2, size = 20.0 }
density = 2400.0
position = [-0.265, 0.5, -1.4]
held = ["z", "ry"]
driven = ["x"]
velocity = [-0.0015, 0.0, 0.0]
[[stage]]
name = "away"
steps = 1
"""


def records(tmp_path, geometry, text):
    path = tmp_path / "scene.toml"
    path.write_text(text.replace("GEOMETRY", str(geometry)))
    return list(hybrid.build(hybrid.load_scene(path)).steps())


def test_a_mat_is_put_down_by_its_weight(tmp_path, geometry, monkeypatch):
    """Its weight, on the stiffness of one cell, would press it into the soil by 4 cm at once."""
    found = records(tmp_path, geometry, MAT)
    assert sum(record.iterations for record in found) <= 8 and all(record.rejections == 0 for record in found)
    assert found[-1].bodies[0].contact_force[2] == pytest.approx(0.8 * 0.5 * 2400 * 9.81, rel=1e-3)
    monkeypatch.setattr(newton, "landed", lambda step, evaluation: evaluation)
    monkeypatch.setattr(increments.Support, "at_start", lambda step, length: None)
    with pytest.raises(StepError):
        records(tmp_path, geometry, MAT)


def test_a_wall_that_just_touches_sand_holds_it_at_rest(tmp_path, geometry):
    """K0 γ H²/2, K0 = 1 - sin φ, which the soil has from the start."""
    found = records(tmp_path, geometry, WALL)
    expected = (1 - np.sin(np.radians(33.0))) * 1700 * 9.81 * 2.1**2 / 2
    assert -found[-1].bodies[0].contact_force[0] == pytest.approx(expected, rel=0.02)


def drawn_back(tmp_path, geometry):
    """Newton iterations and force [N] of the first step of DRAWN."""
    record, = records(tmp_path, geometry, DRAWN)
    return record.iterations, -record.bodies[0].contact_force[0]


def test_soil_follows_a_wall_that_is_drawn_back(tmp_path, geometry):
    """Its springs are pressed by less than it moves, so that it would leave the soil behind, which cannot stand by itself."""
    iterations, force = drawn_back(tmp_path, geometry)
    assert iterations < 350 and 50e3 < force < 65e3


@pytest.mark.slow
def test_increments_are_far_shorter_without_it(tmp_path, geometry, monkeypatch):
    """888 iterations in 64 increments instead of 185 in 8."""
    iterations, force = drawn_back(tmp_path, geometry)
    monkeypatch.setattr(newton, "followed", lambda step, unknowns: None)
    without, same = drawn_back(tmp_path, geometry)
    assert without > 2 * iterations and same == pytest.approx(force, rel=0.03)
