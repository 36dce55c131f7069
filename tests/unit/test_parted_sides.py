"""The monitor of clay that stands away from the sides of a body, on bodies that are made up and on a pile that is driven."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.monitors import StepView
from hybrid.monitors.parted_sides import STEPS, PartedSides
from hybrid.scene import Axis, Faces, Grid, Layer, Material, Motion, Scene, Soil, Stage, Time
from hybrid.setup.build import build
from hybrid.study.scenes import NO_OUTPUT, box

CLAY = Material(law="von-mises", young=2e6, poisson=0.49, density=1700.0, strength=4e3)
SIDES = 2 * 1.2 * 0.5 * 4e3     # α s_u A [N] of both sides of a slice of 1 m


def pile(size=0.25, layers=(), strength=4e3, ground=None, **table):
    """Simulation of a strip 0.5 m wide, 1.2 m deep in clay from the start, half of it where x begins at 0."""
    start = table.pop("start", -1.5)
    body = box(0.5, 3.0, 2.0, size=20.0, name="pile", **{
        "position": (0.0, 0.5, -0.2), "held": ("x", "ry"), "driven": ("z",), "velocity": (0.0, 0.0, 0.01),
        "adhesion": 0.5} | table)
    grid = Grid(Axis(start, 1.5, size), Axis(0.0, 1.0, collapsed=True), Axis(-2.0, 1.5, size), Faces(z_min="fixed"))
    soil = Soil(replace(CLAY, strength=strength), top=0.0, layers=layers, ground=ground, geostatic=ground is None)
    return build(Scene(name="pile", grid=grid, soil=soil, bodies=(body,), time=Time(1.0, inertia=False),
                       stages=(Stage("draw", 1),), output=NO_OUTPUT))


def notes(simulation, ways=((0.0, 0.0, 0.02),) * STEPS, shear=0.0, force=1e4, normal=(1.0, 0.0, 0.0), **body):
    """Of steps in which the pile goes these ways, with a side that bears so much [N]."""
    model = simulation.model
    model = replace(model, bodies=tuple(replace(one, **body) for one in model.bodies))
    monitor, motion, found = PartedSides(model, simulation.state), simulation.state.bodies[0], []
    for way in ways:
        motion = replace(motion, position=motion.position + way)
        contact = SimpleNamespace(normal=np.array([normal]), shear=np.array([(0.0, 0.0, shear)]),
                                  resultant=np.array([0.0, 0.0, force, 0.0, 0.0, 0.0]))
        report = SimpleNamespace(evaluation=SimpleNamespace(contacts=[contact]))
        found += monitor.notes(StepView(model, SimpleNamespace(time=1.0, bodies=(motion,)), None, report, {}))
    return found


@pytest.mark.parametrize("table, sides", [
    ({}, SIDES), ({"start": 0.0}, SIDES / 2), ({"ground": ((-1.5, -0.5), (1.5, -0.5))}, SIDES * 0.7 / 1.2),
    ({"layers": (Layer("lower", top=-0.6, material={"strength": 8e3}),)}, 1.5 * SIDES)],
    ids=["whole", "half", "lower ground", "layers"])
def test_sides_that_bear_little_are_told_with_the_adhesion_of_all_of_them(table, sides):
    simulation = pile(**table)
    text, = notes(simulation, shear=-0.3 * sides)
    assert text.startswith("the sides of pile bear ") and "limit 60%" in text
    bears, of = (float(word) for word in (text.split()[5], text.split()[9]))
    assert bears == pytest.approx(0.3 * sides, rel=0.01) and of == pytest.approx(sides, rel=0.07)
    assert notes(simulation, shear=-0.7 * sides) == []


UP = (0.0, 0.0, 0.02)


@pytest.mark.parametrize("given", [
    {"ways": (UP,) * (STEPS - 1)}, {"ways": ((0.0, 0.0, 1e-4),) * 9}, {"ways": ((0.0, 0.0, 0.01), (0.0, 0.0, -0.01)) * 9},
    {"ways": ((0.02, 0.0, 0.02),) * 9}, {"ways": ((0.0, 0.0, 0.0),) * 9}, {"force": 1e6}, {"friction": 0.3},
    {"interface": None}])
def test_others_are_not(given):
    """Too few steps, too short ones, to and fro, along the ground, at rest, where other forces are much larger, and without
    adhesion."""
    assert notes(pile(), **given) == []


def test_what_stands_on_the_base_of_the_body_is_not_borne_by_its_sides():
    assert len(notes(pile(), shear=-SIDES, normal=(0.0, 0.0, -1.0))) == 1


def test_a_pile_that_is_pressed_in_and_drawn_out_is_told():
    simulation = pile(strength=12e3, position=(0.0, 0.5, 0.75), velocity=(0.0, 0.0, -0.05))
    draw = Stage("draw", 8, motions=(Motion(component="z", velocity=0.02),))
    scene = replace(simulation.scene, stages=(Stage("press", 24), draw))
    found = [text for record in build(scene).steps() for text in record.notes if "the sides of pile bear" in text]
    assert len(found) == 1
