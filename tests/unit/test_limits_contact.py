"""Limits of contact and of stepping: each warns where the failure study measured failure, and not just before."""

import re
from dataclasses import replace

import pytest
from limit_texts import limit_texts
from put_on_soil import put_on_soil

from hybrid.monitors.limits import contact, stepping
from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Axis, Body, Joint, Layer, Material, Motion, Pull, Time
from hybrid.setup.build import build
from hybrid.study.precision.problems import platen
from hybrid.study.scenes import SCHEMES, box, plane, soil_scene, sphere


def texts(limit, body, step=0.01, **rest):
    """Warnings of a limit about a body on a held plane."""
    return limit_texts(limit, plane(body, 10, step, **rest))


def tumbling(step, scheme="newmark", **time):
    """Of a box that turns by 1 rad/s about two axes."""
    body = box(1.0, 0.7, 0.3, position=(0.0, 0.0, 2.0), spin=(0.6, 0.8, 0.0))
    return texts(stepping.large_rotation_step, body, step, time={**SCHEMES[scheme], **time})


@pytest.mark.parametrize("scheme, limit", [("newmark", 0.4), ("alpha", 0.4), ("default", 0.4), ("energy-momentum", 0.2),
                                           ("dissipative", 0.03)])
def test_large_turns_of_a_tumbling_body(scheme, limit):
    assert not tumbling(0.99 * limit, scheme)
    text, = tumbling(1.5 * limit, scheme)
    assert f"rotates by {1.5 * limit:.3g} rad a step" in text and f"limit {limit:g} rad" in text
    assert "time.accuracy = 1e-3" in text
    assert not tumbling(1.5 * limit, scheme, accuracy=1e-3)


@pytest.mark.parametrize("kind, rotation, count", [
    ("ball", (1.0, 0.0, 0.0, 30.0), 1), ("ball", None, 0), ("hinge", (1.0, 0.0, 0.0, 30.0), 0)])
def test_a_top_turns_about_more_than_its_axis(kind, rotation, count):
    """0.45 rad a step: with 0.3 a top precessed by 246 instead of 253 degrees. One that stands upright, or turns in a hinge,
    does not."""
    body = box(0.2, 0.2, 1.0, name="top", position=(0.0, 0.0, 2.0), spin=(0.0, 0.0, 45.0), rotation=rotation)
    axis = {"axis": (0.0, -0.5, 3**0.5 / 2)} if kind == "hinge" else {}
    described = replace(plane(body, 10, 0.01, gravity=(0.0, 0.0, -9.81)),
                        joints=(Joint("foot", kind, ("top",), (0.0, 0.0, -0.5), **axis),))
    simulation = build(described)
    assert len(list(stepping.large_rotation_step(simulation.scene, simulation.model))) == count


@pytest.mark.parametrize("values, words", [
    ({"spin": (0.0, 0.0, 42.0)},
     r"turns by 0.42 rad a step by body.spin, limit 0.4 rad: contact.* steps of at most 0.0095 s"),
    ({"spin": (0.0, 0.0, 360.0)}, "turns by 3.6 rad a step by body.spin, limit 0.4 rad; is it a number of degrees"),
    ({"spin": (0.0, 0.0, 42.0), "driven": ("rz",), "held": ("rx", "ry")}, "turns by 0.42 rad a step by"),
    ({"spin": (0.0, 0.0, 39.0)}, ""),
    ({"motion": Motion(component="ry", velocity=50.0), "time": {"inertia": False}}, "at most 0.008 s$"),
    ({"motion": Motion(component="ry", velocity=50.0)}, "turns by 0.5 rad a step by what drives ry"),
    ({"motion": Motion(component="ry", displacement=((0.0, 0.0), (0.1, 300.0)))},
     "turns by 0.524 rad a step by what drives ry"),
    ({"motion": Motion(component="ry", displacement=((0.0, 0.0), (0.1, 200.0)))}, ""),
    ({"motion": Motion(component="x", velocity=50.0)}, ""),
    ({"spin": (0.0, 0.0, 360.0), "time": {"accuracy": 1e-3}}, "")])
def test_large_turns_about_one_axis(values, words):
    values = dict(values)
    motion, time = values.pop("motion", None), values.pop("time", {})
    scene = plane(box(1.0, 0.7, 0.3, position=(0.0, 0.0, 2.0), **values), 10, 0.01, time=time)
    simulation = build(replace(scene, stages=(replace(scene.stages[0], motions=(motion,) if motion else ()),)))
    found = list(stepping.large_turn_about_an_axis(simulation.scene, simulation.model))
    assert len(found) == bool(words) and all(re.search(words, text) for text in found), found


@pytest.mark.parametrize("component, count", [("ry", 0), ("rz", 1)])
def test_a_drum_may_turn_by_more_about_its_own_axis(component, count):
    """It lies along y of space, which is its own z."""
    drum = Body(GEOMETRY / "cylinder.geo", 1000.0, parameters={"radius": 0.2, "height": 1.0, "size": 0.1},
                position=(0.0, 0.0, 2.0), rotation=(1.0, 0.0, 0.0, 90.0))
    scene = plane(drum, 10, 0.01)
    motion = Motion(component=component, velocity=100.0)
    simulation = build(replace(scene, stages=(replace(scene.stages[0], motions=(motion,)),)))
    assert len(list(stepping.large_turn_about_an_axis(simulation.scene, simulation.model))) == count


@pytest.mark.parametrize("spin, count", [(100.0, 0), (210.0, 1)])
def test_a_ball_may_turn_by_more_about_one_axis(spin, count):
    """Its contact is the same after any turn; beyond 2 rad steps are cut."""
    body = sphere(0.2, 0.05, position=(0.0, 0.0, 2.0), spin=(0.0, spin, 0.0))
    assert len(texts(stepping.large_turn_about_an_axis, body)) == count


def test_turns_about_one_axis_lose_nothing():
    body = box(1.0, 0.7, 0.3, position=(0.0, 0.0, 2.0), spin=(0.0, 1.0, 0.0))
    assert not texts(stepping.large_rotation_step, body, 1.0)


@pytest.mark.parametrize("penalty, count", [(12.6, 0), (12.4, 1), (None, 0)])
def test_contact_softer_than_the_soil(penalty, count):
    """A platen 1.2 m wide on a cube of 0.8 m."""
    simulation = build(platen.scene(penalty=penalty))
    warnings = list(contact.low_penalty(simulation.scene, simulation.model))
    assert len(warnings) == count
    assert all("body.penalty = 12.4 /m" in text and "limit 10" in text and "body.penalty to 12.5" in text
               for text in warnings)


@pytest.mark.parametrize("tangential, friction, count", [(0.3, 0.4, 0), (0.29, 0.4, 1), (0.29, 0.0, 0)])
def test_soft_springs_of_stuck_friction(tangential, friction, count):
    body = box(0.5, 0.5, 0.5, rest_on=0.0, tangential=tangential, friction=friction)
    warnings = texts(contact.low_tangential_stiffness, body)
    assert len(warnings) == count
    assert all("body.tangential = 0.29" in text and "limit 0.3" in text and "body.tangential = 1" in text
               for text in warnings)


@pytest.mark.parametrize("width, more, count", [
    (0.26, {}, 0), (0.24, {}, 1), (0.24, {"contact": "faces"}, 0), (0.07, {"contact": "faces"}, 0),
    (0.24, {"rotation": (0.0, 0.0, 1.0, 30.0)}, 1)])
def test_bodies_narrower_than_two_spacings_of_contact_points(width, more, count):
    """Corners lie 0.125 m apart, points on faces 0.031 m."""
    body = box(1.0, width, 0.5, rest_on=0.0, **{"contact": "corners", **more})
    warnings = texts(contact.narrow_body, body, cells=(6, 6))
    assert len(warnings) == count
    assert all("0.24 m wide" in text and "1.9 spacings" in text and "limit 2" in text and 'body.contact = "faces"' in text
               and "cells of at most 0.24 m" in text for text in warnings)


def test_a_narrow_body_held_above_the_soil_touches_none():
    above = {"held": ("x", "y", "z", "rx", "ry", "rz")}
    above |= {"penalty": 1.0}       # else it touches held ground at places of its own
    assert texts(contact.narrow_body, box(1.0, 0.03, 0.5, rest_on=0.0, **above), cells=(6, 6))
    assert not texts(contact.narrow_body, box(1.0, 0.03, 0.5, rest_on=0.3, **above), cells=(6, 6))


@pytest.mark.parametrize("velocity, count", [
    ((2.4, 0.0, 0.0), 0), ((2.6, 0.0, 0.0), 1), ((0.0, -2.6, 0.0), 1), ((0.0, 0.0, 9.0), 0)])
def test_bodies_driven_over_the_end_of_the_grid(velocity, count):
    """A box of 0.5 m in the middle of 1 m, driven for 0.1 s."""
    body = box(0.5, 0.5, 0.5, rest_on=0.1, velocity=velocity, driven=("x", "y", "z"))
    warnings = texts(contact.driven_past_grid_end, body)
    assert len(warnings) == count
    assert all("= 0.51 m" in text.replace("-", "") and "limit" in text and "outwards" in text for text in warnings)


@pytest.mark.parametrize("pulling, count", [(True, 1), (False, 0)])
def test_bodies_pulled_over_the_end_of_the_grid(pulling, count):
    pull = Pull((0.0, 0.0, 0.0), (0.5, 0.0, 0.0), 1e6, 1.0)
    described = plane(box(0.5, 0.5, 0.5, rest_on=0.1, pull=pull), 100, 0.01)
    described = replace(described, stages=tuple(replace(stage, pull=pulling) for stage in described.stages))
    simulation = build(described)
    assert len(list(contact.driven_past_grid_end(simulation.scene, simulation.model))) == count


@pytest.mark.parametrize("density, more, count", [
    (760.0, {}, 0), (740.0, {}, 1), (740.0, {"held": ("x", "y", "z")}, 0), (740.0, {"held": ("z",), "rest_on": 0.1}, 0),
    (740.0, {"held": ("z",), "rest_on": -0.1}, 1), (740.0, {"tension": "full"}, 0),
    (740.0, {"tension": "full", "velocity": (0.0, 0.0, -1.0)}, 1)])
def test_bodies_lighter_than_the_soil_under_them(density, more, count):
    """A box 0.4 m high on soil of 1000 kg/m³ in cells of 0.2 m."""
    described = plane(box(0.5, 0.5, 0.4, density=density, **{"rest_on": 0.0} | more), 1, 0.01, cell=0.2,
                      soil={"held": False})
    simulation = build(described)
    warnings = list(contact.light_body(simulation.scene, simulation.model))
    assert len(warnings) == count
    assert all("1.48 rows of cells" in text and "limit 1.5" in text and "at most 0.197 m" in text for text in warnings)


@pytest.mark.parametrize("height, count", [(0.3, 0), (0.1, 1)])
def test_a_light_body_that_hangs_on_a_joint_hits_nothing(height, count):
    """More than a cell above the soil."""
    bob = box(0.5, 0.5, 0.4, rest_on=height, density=100.0)
    described = plane(bob, 1, 0.01, cell=0.2, soil={"held": False})
    joint = Joint("rod", "ball", (described.bodies[0].name,), (0.0, 0.0, 2.0))
    simulation = build(replace(described, joints=(joint,)))
    assert len(list(contact.light_body(simulation.scene, simulation.model))) == count


def test_a_light_body_on_another_one_hits_that():
    """The upper one of two on a block, the same one beside it, and over one that is buried."""
    found = []
    for x, height in ((0.0, 0.0), (1.0, 0.0), (0.0, -0.8)):
        upper = box(0.4, 0.4, 0.2, density=300.0, name="upper", position=(x, 0.0, 0.0), rest_on=0.6)
        lower = box(0.5, 0.5, 0.6, density=3000.0, name="lower", position=(0.0, 0.0, 0.0), rest_on=height)
        described = soil_scene([lower, upper], x=(-2.0, 2.0), y=(-1.0, 1.0), z=(-1.2, 0.4), gravity=(0.0, 0.0, -9.81),
                               time=Time(0.01))
        simulation = build(described)
        found.append([text[:5] for text in contact.light_body(simulation.scene, simulation.model)])
    assert found == [[], ["upper"], ["upper"]]


@pytest.mark.parametrize("density, count", [(760.0, 0), (740.0, 1)])
def test_half_a_body_is_as_light_as_the_whole(density, count):
    described = plane(box(0.5, 0.5, 0.4, rest_on=0.0, density=density), 1, 0.01, cell=0.2, soil={"held": False})
    half = replace(described, grid=replace(described.grid, x=Axis(0.0, 0.6, 0.2)))
    simulation = build(half)
    assert simulation.mirrors and len(list(contact.light_body(simulation.scene, simulation.model))) == count


@pytest.mark.parametrize("height, held, count", [(0.3, False, 0), (0.2, False, 0), (0.1, False, 1), (0.1, True, 0)])
def test_faces_narrower_than_a_cell(height, held, count):
    """The four upright faces of a plate driven into soil with cells of 0.2 m; held soil sees edges as they are."""
    plate = box(1.2, 1.0, height, rest_on=0.0, driven=("x",), velocity=(0.1, 0.0, 0.0), held=("z",))
    warnings = texts(contact.narrow_face, plate, cell=0.2, soil={"held": held})
    assert len(warnings) == count
    assert all("0.1 m wide" in text and "limit 0.2 m" in text and "cells of at most 0.1 m" in text for text in warnings)


def test_the_sides_of_a_lid_over_all_of_the_soil_are_no_narrow_faces():
    lid = {"rest_on": 0.0, "driven": ("z",), "velocity": (0.0, 0.0, -0.1), "held": ("x", "y")}
    assert texts(contact.narrow_face, box(0.8, 0.8, 0.1, **lid), cell=0.25, soil={"held": False})
    assert not texts(contact.narrow_face, box(1.2, 1.2, 0.1, **lid), cell=0.25, soil={"held": False})


@pytest.mark.parametrize("length, count", [(0.6, 1), (1.2, 0)])
def test_a_platen_that_covers_the_soil_has_none_above_it(length, count):
    """Pushed down by more than its own thickness of a cell; a narrower one may be flowed over."""
    platen = box(length, length, 0.2, rest_on=0.0, driven=("z",), velocity=(0.0, 0.0, -2.5), held=("x", "y"))
    assert len(texts(contact.thin_wall, platen, cell=0.25, step=0.01, soil={"held": False})) == count


@pytest.mark.parametrize("cells, words", [
    (0.98, "limit 2: soil on both sides shares nodes"), (1.97, "limit 2: soil on both sides may, by where"), (2.0, "")])
def test_a_thin_plate_in_the_soil_is_told_whether_it_sticks_for_certain(cells, words):
    """Pulled strip plates of 0.5 and 1 cell stuck, those of 1.25 to 1.75 at two of three places in a cell, not one of 2."""
    plate = box(1.0, 1.0, 0.25 * cells, rest_on=-0.6, driven=("z",), velocity=(0.0, 0.0, 0.1), held=("x", "y"))
    found = texts(contact.thin_wall, plate, cells=(10, 10), soil={"held": False})
    assert len(found) == bool(words) and all(words in text and "up to 3.3 times" in text for text in found)
    assert not any(" 2 cells" in text for text in found)


@pytest.mark.parametrize("deep, gravity, more, told", [
    (0.4, 0.0, {}, True), (0.4, -9.81, {}, False), (0.0, 0.0, {}, False), (0.4, 0.0, {"tension": "full"}, False),
    (0.4, 0.0, {"adhesion": 0.0}, False), (0.4, 0.0, {"friction": 0.3, "adhesion": 0.5}, False), (0.4, 0.0, {}, None)],
    ids=["in place", "weight", "on it", "bonded", "smooth", "friction", "in sand"])
def test_clay_without_weight_does_not_press_on_a_body_in_it(deep, gravity, more, told):
    """None: in sand over clay."""
    block = box(0.4, 0.4, 0.6, density=1e3, position=(0.0, 0.0, 0.3 - deep), driven=("z",), velocity=(0.0, 0.0, -0.001),
                held=("x", "y", "rx", "ry", "rz"), **{"adhesion": 0.5, **more})
    clay = Material(law="von-mises", young=5e6, poisson=0.49, density=1700.0, strength=1e4)
    sand = Layer("sand", bottom=-0.8, law="drucker-prager",
                 material={"friction_angle": 30.0, "dilation_angle": 0.0, "cohesion": 100.0})
    scene = put_on_soil(block, size=0.2, x=(-0.8, 0.8), y=(-0.8, 0.8), z=(-1.2, 0.4), material=clay, steps=2,
                        layers=(sand,) if told is None else (), geostatic=gravity != 0.0)
    simulation = build(replace(scene, gravity=(0.0, 0.0, gravity)))
    found = list(contact.unpressed_adhesion(simulation.scene, simulation.model))
    assert len(found) == bool(told)
    assert all("body is in clay without weight" in text and "body.tension" in text for text in found)


@pytest.mark.parametrize("gravity, more, told", [
    (0.0, {"tension": "full", "friction": 0.5}, True), (0.0, {"tension": 1e3, "friction": 0.5}, True),
    (-9.81, {"tension": "full", "friction": 0.5}, False), (0.0, {"tension": "full"}, False),
    (0.0, {"tension": "full", "friction": 0.5, "velocity": (0.0, 0.0, -0.01)}, False),
    (0.0, {"friction": 0.5}, False)],
    ids=["bonded for ever", "bonded", "weight", "smooth", "driven down", "no bond"])
def test_a_bond_bears_no_shear(gravity, more, told):
    disc = box(0.4, 0.4, 0.2, density=1e3, position=(0.0, 0.0, 0.0), rest_on=0.0, held=("x", "y", "rx", "ry"),
               driven=("z", "rz"), spin=(0.0, 0.0, 0.01), **more)
    elastic = Material(law="hencky", young=5e6, poisson=0.3, density=1700.0)
    scene = put_on_soil(disc, size=0.2, x=(-0.8, 0.8), y=(-0.8, 0.8), z=(-1.0, 0.4), material=elastic)
    simulation = build(replace(scene, gravity=(0.0, 0.0, gravity)))
    found = list(contact.unpressed_bond(simulation.scene, simulation.model))
    assert len(found) == told and all("a bond bears no shear" in text for text in found)


@pytest.mark.parametrize("z, told", [(0.1, True), (-0.4, False)])
def test_a_light_body_in_the_soil_does_not_hit_it(z, told):
    block = box(0.4, 0.4, 0.2, density=200.0, position=(0.0, 0.0, z))
    scene = put_on_soil(block, size=0.2, x=(-0.8, 0.8), y=(-0.8, 0.8), z=(-1.0, 0.4))
    simulation = build(replace(scene, time=Time(0.01)))
    assert len(list(contact.light_body(simulation.scene, simulation.model))) == told


def test_on_a_slope_bodies_are_judged_from_the_ground_under_them():
    """At its toe, 0.8 m below the crest: a block lies on clay without weight, and a light one hits it."""
    ground = ((-0.4, 0.0), (0.4, -0.8))
    block = box(0.4, 0.4, 0.2, density=200.0, position=(0.8, 0.0, 0.0), rest_on=-0.8, adhesion=0.5)
    scene = put_on_soil(block, size=0.2, x=(-1.2, 1.2), y=(-0.8, 0.8), z=(-1.6, 0.4), ground=ground, geostatic=False)
    weightless = build(replace(scene, gravity=(0.0, 0.0, 0.0)))
    assert not list(contact.unpressed_adhesion(weightless.scene, weightless.model))
    falling = build(replace(scene, time=Time(0.01)))
    assert len(list(contact.light_body(falling.scene, falling.model))) == 1


@pytest.mark.parametrize("geometry, size, told", [
    ("cylinder.geo", 0.5, 1), ("cylinder.geo", 0.25, 0), ("sphere.geo", 0.5, 1), ("sphere.geo", 0.35, 0)])
def test_a_curved_body_of_elements_as_long_as_its_diameter_is_reported(geometry, size, told):
    body = Body(GEOMETRY / geometry, 1000.0, name="round", position=(0.0, 0.0, 0.6),
                parameters={"radius": 0.25, "size": size})
    simulation = build(plane(body, 1, 0.01))
    found = list(contact.coarse_facets(simulation.scene, simulation.model))
    assert len(found) == told and all("parameters.size" in text for text in found)
