"""Round bodies at rest on soil whose cells do not resolve their contact: the force that draws them to nodes, and the note
about it."""

from types import SimpleNamespace

import numpy as np
import pytest
from contact_bed import ball, box

from hybrid.monitors.limits.rolling import (BY_PLACE, FORCE, LIMIT, RESOLVED, narrow_contact, rolls_on_lattice,
                                           towed_roller)
from hybrid.monitors.limits.shape import is_round
from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Axis, Body, Faces, Grid, Joint, Load, Material, Motion, Scene, Soil, Stage, Time
from hybrid.setup.build import build

RADIUS, CONTACT = 0.31, 0.040       # [m] of the sphere and of its contact by Hertz
ELASTIC = {"law": "hencky", "young": 10e6, "poisson": 0.3, "density": 1800.0}
CLAY = {"law": "von-mises", "young": 5e6, "poisson": 0.45, "density": 1800.0, "strength": 20e3}


def sphere(cell, material=ELASTIC, at=(0.0, 0.0), inertia=True, soil=(), gravity=(0.0, 0.0, -9.81),
           stages=(Stage("rest", 2),), joints=(), **body):
    """Simulation of a sphere put down on a bed three cells and at least 0.2 m deep."""
    n, depth, up = (int(np.ceil(max(length, rows * cell) / cell)) for length, rows in ((0.24, 3), (0.2, 3), (0.1, 1)))
    side = Axis(-n * cell, n * cell, cell)
    ball = Body(GEOMETRY / "sphere.geo", 2500.0, name="ball", position=(*at, 0.0), rest_on=0.0,
                parameters={"radius": RADIUS, "size": 0.06}, **body)
    grid = Grid(side, side, Axis(-depth * cell, up * cell, cell), Faces(z_min="fixed"))
    return build(Scene(name="ball", grid=grid, soil=Soil(Material(**material), top=0.0, **dict(soil)), bodies=(ball,),
                       gravity=gravity,
                       time=Time(0.02 if inertia else 1.0, inertia=inertia), stages=stages, joints=joints))


def notes(*given, **more):
    simulation = sphere(*given, **more)
    return list(rolls_on_lattice(simulation.scene, simulation.model))


@pytest.mark.parametrize("cell, material, words", [
    (0.11, ELASTIC, ("radius of 0.04 m, 0.37 cells", "up to 1.9% of its weight", "cells of at most 0.03 m")),
    (0.055, ELASTIC, ("0.73 cells", "up to 3.4% of its weight")),
    (0.11, CLAY, ("radius of 0.09 m, 0.82 cells", "at most 0.067 m"))])
def test_a_sphere_at_rest_on_coarse_cells_is_reported(cell, material, words):
    found, = notes(cell, material, friction=None if material is CLAY else 0.5)
    assert all(word in found for word in words) and "without gaining energy" in found and "soil.held = true" in found


def test_a_box_of_eight_vertices_is_not_round():
    """All of which are as far from its middle; a polyhedron of many faces is."""
    for surface, found in ((box(), False), (box(half=(0.3, 0.2, 0.5)), False), (ball(rings=6), True)):
        assert is_round(surface, np.linalg.norm(surface.vertices, axis=1)) == found


def test_a_tube_is_as_round_as_its_outside():
    outer, inner = (ball(rings=8, radius=r) for r in (0.3, 0.15))
    both = SimpleNamespace(vertices=np.concatenate([outer.vertices, inner.vertices]), normals=outer.normals)
    assert is_round(both, np.linalg.norm(both.vertices, axis=1))


def test_clay_that_begins_without_strength_is_reported_without_a_warning():
    """The contact is then as wide as the body; numpy's warning would be an error here."""
    gradient = {**CLAY, "strength": 0.0, "strength_gradient": 20e3}
    with np.errstate(divide="raise"):
        assert not notes(0.11, gradient, friction=None)


@pytest.mark.parametrize("more", [
    {"cell": 0.029}, {"material": {**ELASTIC, "young": 1e9}}, {"held": ("x", "y")}, {"held": ("rx", "ry")},
    {"velocity": (1.0, 0.0, 0.0)},
    {"soil": {"held": True, "geostatic": False}}, {"gravity": (-1.0, 0.0, -9.7), "soil": {"geostatic": False}}])
def test_bodies_that_do_not_feel_it_or_do_not_rest_are_not_reported(more):
    assert not notes(**{"cell": 0.11, **more})


def test_a_joined_ball_does_not_roll():
    assert notes(0.11) and not notes(0.11, joints=(Joint("pin", "ball", ("ball",), (0.0, 0.0, 1.0)),))


def tangential(cell):
    """Largest force along the surface, over the weight, on a sphere that is held without friction at four places in a
    cell."""
    forces = []
    for at in np.random.default_rng(3).uniform(0.0, cell, (4, 2)):
        *_, record = sphere(cell, at=tuple(at), inertia=False, friction=0.0, held=("x", "y", "rx", "ry", "rz")).steps()
        force = record.bodies[0].contact_force
        forces.append(np.hypot(*force[:2]) / force[2])
    return max(forces)


def test_the_force_of_the_lattice_goes_with_the_contact():
    expected = np.interp(CONTACT / 0.08, *np.transpose(FORCE)) * CONTACT / RADIUS
    assert 0.5 * expected < tangential(0.08) < 1.1 * expected and expected > LIMIT
    assert tangential(CONTACT / RESOLVED) < LIMIT


@pytest.mark.parametrize("cell, told", [
    ({"size": 0.1}, "0.34 m, 3.4 cells of 0.1 m, limit 6.5"), ({"size": 0.05}, ""), ({"size": 0.1, "held": ("ry",)}, ""),
    ({"size": 0.1, "stage": ("ry",)}, ""), ({"size": 0.1, "motion": ("ry",)}, ""),
    ({"size": 0.1, "speed": 0.0}, ""), ({"size": 0.1, "load": 0.0}, "0.15 m, 1.5 cells"),
    ({"size": 0.1, "material": ELASTIC}, "")])
def test_a_roller_that_is_towed_over_clay(cell, told):
    """Of 1 m diameter and 1 t/m³ in a slice of 1 m, under another 10 kN."""
    def texts(size, held=(), stage=(), motion=(), speed=0.4, load=-10e3, material={**CLAY, "strength": 10e3}):
        wheel = Body(GEOMETRY / "cylinder.geo", 1000.0, name="wheel", position=(0.0, 0.5, 0.0), rest_on=0.0, friction=0.5,
                     rotation=(1.0, 0.0, 0.0, 90.0), parameters={"radius": 0.5, "height": 1.0, "size": 0.1}, held=held)
        grid = Grid(Axis(-1.5, 3.0, size), Axis(0.0, 1.0, collapsed=True), Axis(-1.5, 0.5, size), Faces(z_min="fixed"))
        motions = Motion(component="x", velocity=speed), *([Motion(held=motion)] if motion else [])
        tow = Stage("tow", 10, held=stage, motions=motions, loads=(Load(force=(0.0, 0.0, load)),))
        simulation = build(Scene(name="tow", grid=grid, soil=Soil(Material(**material), top=0.0), bodies=(wheel,),
                                 time=Time(0.05, inertia=False), stages=(tow,)))
        return list(towed_roller(simulation.scene, simulation.model))

    found = texts(**cell)
    assert len(found) == bool(told) and all(told in text and "rolled along clay" in text for text in found)


SANDY = {"young": 1e7, "poisson": 0.3, "density": 1800.0, "friction_angle": 32.0, "dilation_angle": 4.0, "cohesion": 500.0}


def laid(size=0.1, material=None, load=-9e3, x=0.0, stages=(), ground=None, parts=1, **table):
    """Texts about a cylinder of 0.6 m laid on soil in a slice of 1 m."""
    material = material or {**CLAY, "strength": 15e3}
    pipe = Body(GEOMETRY / "cylinder.geo", 100.0, name="pipe", position=(x, 0.5, 0.0), friction=0.4,
                rotation=(1.0, 0.0, 0.0, 90.0), parameters={"radius": 0.3, "height": 1.0, "size": 0.1},
                **{"rest_on": 0.0} | table)
    grid = Grid(Axis(-0.8, 0.8, size), Axis(0.0, 1.0, collapsed=True), Axis(-0.6, 0.8, size), Faces(z_min="fixed"))
    lay = Stage("lay", 4, held=("x", "ry"), loads=(Load(force=(0.0, 0.0, load / parts)),) * parts)
    soil = Soil(Material(**material), top=0.0, ground=ground, geostatic=ground is None)
    simulation = build(Scene(name="lay", grid=grid, soil=soil, bodies=(pipe,),
                             time=Time(1.0, inertia=False), stages=(lay, *stages)))
    return [text for limit in (narrow_contact, towed_roller) for text in limit(simulation.scene, simulation.model)]


@pytest.mark.parametrize("kind, cells, apart", [
    ("clay", 1.2, (8.5, 2.4)), ("clay", 2.3, (8.5, 6.6)), ("elastic soil", 0.5, (3.8, 2.6)),
    ("elastic soil", 1.0, (3.8, 3.3)), ("sand", 2.3, (11.2, 15.1)), ("sand", 4.5, (11.2, 8.9))])
def test_the_law_of_narrow_contacts_is_what_was_measured(kind, cells, apart):
    """[mm] that a cylinder lies deep, towards, and where it differs most from that by its place in a cell."""
    share, power = BY_PLACE[kind]
    assert abs(apart[1] / apart[0] - 1.0) == pytest.approx(share * cells**-power, abs=0.08)


@pytest.mark.parametrize("given, told", [
    ({}, "lies on clay on about 0.12 m, 1.2 cells of 0.1 m, limit 3.2"), ({"size": 0.025}, ""),
    ({"material": {**ELASTIC, "young": 5e6}}, "on elastic soil"), ({"material": SANDY}, "on sand"),
    ({"parts": 3}, "about 0.12 m, 1.2 cells"), ({"ground": ((-0.8, 0.0), (0.8, 0.0))}, "on clay"),
    ({"ground": ((-0.8, -0.16), (0.8, 0.0)), "rest_on": "ground"}, "on clay"),
    ({"load": -1.6e4}, ""), ({"held": ("z",), "load": 0.0}, "")])
def test_a_cylinder_laid_on_a_contact_narrower_than_cells_is_told_by_how_much_its_depth_depends_on_its_place(given, told):
    """Not one that sinks so deep that another note tells of it, nor one that is held."""
    found = laid(**given)
    assert len(found) == bool(told) and all(told in text and "where in a cell it touches" in text for text in found)


def test_a_cylinder_that_rolls_after_it_was_laid_is_told_as_one_that_is_rolled_at_once():
    push = Stage("push", 4, loads=(Load(force=(1500.0, 0.0, 0.0)),))
    text, = laid(stages=(push,))
    assert "is rolled along clay" in text
