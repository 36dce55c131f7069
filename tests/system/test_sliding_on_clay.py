"""Bodies that slide over clay by a good part of a cell in each step feel the whole of its friction and adhesion. Contact
points that come and go within a step are about a third of all here."""

from dataclasses import replace

import numpy as np
import pytest
from put_on_soil import put_on_soil
from rank_runs import hybrid as command
from rank_runs import needs_mpirun, scene_file

import hybrid
from hybrid.output.history import read_history
from hybrid.scene import Motion, Stage
from hybrid.setup import contact
from hybrid.setup.interface import interface_of
from hybrid.step import newton
from hybrid.study.scenes import box

BRICK = """
time = { step = 0.01 }
output = { pictures = [], every = 0 }
[grid]
x = { start = 0.0, end = 2.6, size = 0.13 }
y = { start = 0.0, end = 0.5, collapsed = true }
z = { start = -0.52, end = 0.13, size = 0.13 }
faces = { z_min = "fixed" }
[soil]
top = 0.0
material = { law = "von-mises", young = 20e6, poisson = 0.45, density = 1800.0, strength = 100e3 }
[[body]]
name = "brick"
geometry = "GEOMETRY/box.geo"
parameters = { length = 0.41, width = 0.5, height = 0.28, size = 20 }
density = DENSITY
position = [0.353, 0.25, 0.0]
rest_on = 0.0
INTERFACE
[[stage]]
name = "settle"
steps = 15
held = ["x", "ry"]
[[stage]]
name = "slide"
steps = 25
motion = [{ component = "x", velocity = 3.0 }]
"""
LIGHT, HEAVY = (7850.0, "friction = 0.45"), (73e3, "adhesion = 0.3")
ADHESION = 0.3 * 100e3 * 0.41 * 0.5     # [N] α s_u A


def brick(folder, density, interface):
    """Path of the scene with a brick of this density [kg/m³] and `interface`, a line of its table."""
    return scene_file(folder, BRICK.replace("DENSITY", str(density)).replace("INTERFACE", interface))


def shear(path):
    """Mean forces [N] along the brick, against its motion, and across it, from the tenth step of sliding on."""
    records = [record for record in hybrid.build(hybrid.load_scene(path)).steps() if record.stage == "slide"][10:]
    x, _, z = np.mean([record.bodies[0].contact_force for record in records], axis=0)
    return -x, z


def test_friction(tmp_path, monkeypatch):
    """0.44 of 0.45; 0.28 where points that come into contact have no share of the clay's strength."""
    path = brick(tmp_path, *LIGHT)
    along, across = shear(path)
    assert along / across == pytest.approx(0.45, rel=0.06)
    monkeypatch.setattr(newton, "SHARED", np.inf)
    monkeypatch.setattr(contact, "interface_of", lambda *of: replace(interface_of(*of), frictional=False))
    along, across = shear(path)
    assert along / across < 0.35


def test_sand_under_the_clay_changes_nothing_along_a_body_that_does_not_reach_it(tmp_path):
    """It left the body with friction alone: 23 % too much for a block that is pressed on clay."""
    path = brick(tmp_path, 73e3, "friction = 0.9")
    pure, _ = shear(path)
    sand = """[[soil.layer]]
name = "sand"
top = -0.39
law = "mohr-coulomb"
material = { friction_angle = 35.0, dilation_angle = 5.0, cohesion = 1e3 }
[[body]]"""
    path.write_text(path.read_text().replace("[[body]]", sand, 1))
    assert shear(path)[0] == pytest.approx(pure, rel=0.05)


def test_adhesion(tmp_path, monkeypatch):
    path = brick(tmp_path, *HEAVY)
    assert shear(path)[0] == pytest.approx(ADHESION, rel=0.1)
    monkeypatch.setattr(newton, "SHARED", np.inf)
    assert shear(path)[0] < 0.8 * ADHESION


@needs_mpirun
def test_on_two_ranks(tmp_path):
    path = brick(tmp_path, *LIGHT)
    keys = ["--set", "stage.1.steps=4", "solver.tolerance=1e-8", "solver.linear_tolerance=1e-6"]
    for ranks in (1, 2):
        command("run", path, "--out", tmp_path / str(ranks), "--ranks", ranks, *keys)
    one, two = (read_history(tmp_path / str(ranks)) for ranks in (1, 2))
    for name in ("brick_contact_fx_N", "brick_contact_fz_N"):
        assert np.abs(one[name] - two[name]).max() < 1e-4 * np.abs(one[name]).max(), name


def test_a_mat_twisted_on_clay():
    """All of it slips; at its middle, where slip is small, slip turns round from one update to the next. Held in stick for
    that, it took 40 iterations in the four steps of twisting instead of 10."""
    scene = put_on_soil(
        box(1.0, 1.0, 0.2, size=20.0, density=2500.0, rest_on=0.0, adhesion=1.0, held=("x", "y", "rx", "ry")), size=0.25,
        x=(-1.0, 1.0), y=(-1.0, 1.0), z=(-0.75, 0.25))
    twisted = Motion(component="rz", velocity=0.01)
    scene = replace(scene, stages=(Stage("lay", 1, motions=(Motion(held=("rz",)),)), Stage("twist", 4, motions=(twisted,))))
    found = list(hybrid.build(scene).steps())
    assert sum(record.iterations for record in found[1:]) <= 20
    torque = -found[-1].bodies[0].contact_moment[2]
    assert torque == pytest.approx(0.3826 * 10e3 * 1.0**3, rel=0.12)     # s_u ∫ r dA over the square, on 4 x 4 cells
