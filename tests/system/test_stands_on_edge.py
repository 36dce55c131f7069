"""Bodies on an edge on elastic soil: without friction it bears no force along the ground.

With sharp edges, contact there is at one row of places, on one face of the body: its force is along the normal of that
face, 1.00 of the weight sideways on an edge of 45/45 degrees, and a rod without friction falls as if its foot were pinned.
"""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from put_on_soil import put_on_soil

from hybrid.body.mesh import generate
from hybrid.body.surface import build_surface
from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Material, Motion, Time
from hybrid.setup import contact, foot
from hybrid.setup.build import build
from hybrid.study.scenes import box

SOIL = Material(law="hencky", young=2e7, poisson=0.3, density=1800.0)


def on_edge(length, height, angle, steps, **time):
    """Scene of a smooth box that stands on its edge on elastic soil, tilted by an `angle` [degrees]."""
    body = box(length, 1.0, height, size=2.0, density=2000.0, position=(0.02, 0.5, 0.0), rest_on=0.0, friction=0.0,
               rotation=(0.0, 1.0, 0.0, angle))
    scene = put_on_soil(body, size=0.1, x=(-1.0, 1.2), z=(-0.5, 0.3), material=SOIL, steps=steps)
    return replace(scene, time=Time(**time)) if time else scene


def falling():
    """(way of the centre along the ground [m], angle [degrees]) of a rod that falls from 25 degrees in 0.4 s."""
    simulation = build(on_edge(0.2, 1.0, 25.0, 80, step=0.005))
    *_, record = simulation.steps()
    turned = simulation.state.bodies[0].rotation
    return record.bodies[0].position[0] - 0.02, np.degrees(np.arctan2(turned[0, 2], turned[0, 0]))


def sideways():
    """Force along the ground over the weight of a box held on its edge."""
    scene = on_edge(0.4, 0.4, 45.0, 1)
    held = replace(scene.stages[0], motions=(Motion(held=("x", "ry")),))
    *_, record = build(replace(scene, stages=(held,))).steps()
    return abs(record.bodies[0].contact_force[0] / record.bodies[0].contact_force[2])


def test_a_smooth_rod_that_falls_keeps_its_centre_above_its_foot():
    way, angle = falling()
    assert abs(way) < 0.03 and angle == pytest.approx(78.4, abs=5.0)    # 78.4 on held ground and by integration


def test_an_edge_bears_hardly_anything_along_the_ground():
    assert sideways() < 0.12


def test_with_sharp_edges_it_is_pinned(monkeypatch):
    monkeypatch.setattr(contact, "stands_on_edge", lambda *given: False)
    assert falling()[0] > 0.1 and sideways() > 0.9


def standing(size=0.2, rotation=np.eye(3), lift=0.0, surface=None, cell=0.1):
    """What `stands_on_edge` says of a box that touches the soil with its lowest vertex, or is lifted over it."""
    mesh = generate(GEOMETRY / "box.geo", {"length": 1.0, "width": 1.0, "height": 0.5, "size": size})
    body = SimpleNamespace(surface=build_surface(mesh.points, mesh.contact, mesh.normals), radius=0.8)
    vertices = body.surface.vertices @ rotation.T
    ground = 0.0 if surface is None else vertices[:, 0] * surface
    grid = SimpleNamespace(smallest_cell=cell, collapsed=np.zeros(3, bool))
    soil = SimpleNamespace(grid=grid, constants=None, heights=None if surface is None else (
        (np.array([-9.0, 9.0]), None, surface * np.array([-9.0, 9.0])), 9.0))
    motion = SimpleNamespace(rotation=rotation, position=np.array([0.0, 0.0, lift - (vertices[:, 2] - ground).min()]))
    return foot.stands_on_edge(body, motion, soil)


def turned(angle, about=1):
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    out = np.eye(3)
    i, j = (about + 1) % 3, (about + 2) % 3
    out[[i, i, j, j], [i, j, i, j]] = c, -s, s, c
    return out


@pytest.mark.parametrize("values, expected", [
    ({}, False), ({"lift": 0.5}, False), ({"rotation": turned(0.3)}, False), ({"rotation": turned(5.0)}, True),
    ({"rotation": turned(5.0), "size": 0.05}, True), ({"cell": 9.0}, False),
    ({"rotation": turned(30.0, 0)}, True), ({"rotation": turned(30.0, 0) @ turned(20.0)}, True),
    ({"rotation": turned(30.0), "lift": -0.15}, False), ({"rotation": turned(20.0), "lift": -0.05}, True),
    ({"rotation": turned(-20.0), "surface": np.tan(np.radians(20.0))}, False),
    ({"surface": np.tan(np.radians(20.0))}, True)],
    ids=["flat", "over the ground", "less than a place", "5 degrees", "in fine triangles", "narrow",
         "edge", "corner", "in the soil", "pressed in",
         "on a slope", "upright on a slope"])
def test_what_stands_on_an_edge(values, expected, monkeypatch):
    monkeypatch.setattr(foot, "extent", lambda constants, axis: (-1.0, 0.0 if "surface" not in values else 9.0))
    assert standing(**values) is expected


def test_a_cylinder_on_its_side_keeps_its_rims():
    """It stands on no edge: soil is in contact along its curved face."""
    drum = replace(box(1.0, 1.0, 1.0), geometry=GEOMETRY / "cylinder.geo", density=2000.0, rest_on=0.0,
                   parameters={"radius": 0.25, "height": 0.5, "size": 0.15}, rotation=(1.0, 0.0, 0.0, 90.0))
    scene = put_on_soil(drum, size=0.25, x=(-0.5, 0.5), y=(-0.5, 0.5), z=(-0.5, 0.5), material=SOIL)
    assert build(scene).model.bodies[0].soft_edges is not None


@pytest.mark.parametrize("width, cell, collapsed, expected", [
    (0.3, 0.1, False, False), (0.04, 0.1, False, True), (0.04, 0.07, True, False), (0.3, 0.1, True, False)])
def test_a_narrow_foot_is_flat_from_half_a_cell_on(width, cell, collapsed, expected, monkeypatch):
    """Of a T upside down, whose upper base is larger; seen from below."""
    monkeypatch.setattr(foot, "extent", lambda constants, axis: (-1.0, 0.0))
    corner = np.array([(-0.5, -0.5), (-0.5, 0.5), (0.5, 0.5), (0.5, -0.5)])
    vertices = np.concatenate([np.column_stack([w * corner, np.full(4, z)]) for w, z in ((width, 0.0), (1.0, 0.5))])
    triangles = np.array([(0, 1, 2), (0, 2, 3), (4, 5, 6), (4, 6, 7)])
    body = SimpleNamespace(radius=0.8, surface=SimpleNamespace(
        vertices=vertices, triangles=triangles, normals=np.tile([0.0, 0.0, -1.0], (4, 1))))
    grid = SimpleNamespace(smallest_cell=cell, collapsed=np.array([False, collapsed, False]))
    soil = SimpleNamespace(grid=grid, constants=None, heights=None)
    assert foot.stands_on_edge(body, SimpleNamespace(rotation=np.eye(3), position=np.zeros(3)), soil) is expected
