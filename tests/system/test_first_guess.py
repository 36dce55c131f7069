"""The first guess of an increment without inertia: bodies that touch nothing yet, soil that just touches, bodies drawn back."""

import numpy as np
import pytest

import hybrid
from hybrid.runtime.errors import StepError
from hybrid.step import newton

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
z = { start = ZMIN, end = 2.55, size = 0.15 }
FACES
[soil]
lower = [0.0, 0.0, ZMIN]
upper = [4.5, 1.0, 2.1]
material = { MATERIAL }
[[body]]
name = "wall"
geometry = "GEOMETRY/box.geo"
parameters = { length = 0.3, width = 1.0, height = 2.4, size = 20.0 }
density = 2400.0
position = [-0.15, 0.5, 1.2]
held = ["z", "ry"]
MOTION
[[stage]]
name = "stand"
steps = STEPS
"""
SAND = 'law = "drucker-prager", young = 2e7, poisson = 0.3, density = 1700.0, friction_angle = 33.0, dilation_angle = 3.0, cohesion = 0.0'
CLAY = 'law = "von-mises", young = 5e6, poisson = 0.49, density = 1733.0, strength = 6e3'


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
    with pytest.raises(StepError):
        records(tmp_path, geometry, MAT)


def test_a_wall_that_just_touches_sand_holds_it_at_rest(tmp_path, geometry):
    """K0 γ H²/2, K0 = 1 - sin φ, which the soil has from the start."""
    text = WALL.replace("ZMIN", "0.0").replace("FACES", "").replace("MATERIAL", SAND).replace("STEPS", "1")
    found = records(tmp_path, geometry, text.replace("MOTION", "").replace('"z", "ry"', '"x", "z", "ry"'))
    expected = (1 - np.sin(np.radians(33.0))) * 1700 * 9.81 * 2.1**2 / 2
    assert -found[-1].bodies[0].contact_force[0] == pytest.approx(expected, rel=0.02)


def test_soil_follows_a_wall_that_is_drawn_back(tmp_path, geometry, monkeypatch):
    """52 iterations otherwise here; with other cells the first step is cut into increments that take 800, or is not done at all."""
    text = WALL.replace("ZMIN", "-0.9").replace("FACES", 'faces = { z_min = "fixed" }').replace("MATERIAL", CLAY)
    text = text.replace("MOTION", 'driven = ["x"]\nvelocity = [-0.0015, 0.0, 0.0]').replace("STEPS", "4")
    text = text.replace("[[body]]", '[[soil.layer]]\nname = "rock"\ntop = 0.0\nmaterial = { strength = 200e3, young = 50e6 }\n[[body]]', 1)
    text = text.replace("lower = [0.0, 0.0, -0.9]\nupper = [4.5, 1.0, 2.1]", "top = 2.1\nground = [[0.0, 0.0], [0.001, 2.1]]")
    found = records(tmp_path, geometry, text)
    count = sum(record.iterations for record in found)
    forces = [-record.bodies[0].contact_force[0] for record in found]
    assert count <= 24 and forces[0] > forces[-1] > 0.0
    monkeypatch.setattr(newton, "followed", lambda step, evaluation: evaluation)
    assert sum(record.iterations for record in records(tmp_path, geometry, text)) > 2 * count
