"""Limit of few cells behind a wall that clay follows: the law is what was measured, and only such walls have the note."""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from limit_texts import limit_texts

from hybrid.monitors.limits import clay_cells
from hybrid.scene import Axis, Faces, Grid, Joint, Layer, Load, Material, Motion, Pull, Soil, Stage, Time
from hybrid.setup.build import build
from hybrid.study import plasticity
from hybrid.study.random.fresh.problem import body, scene, slice_

WEIGHT, HEIGHT = 1700 * 9.81, 3.0
HELD = ("y", "z", "rx", "ry", "rz")
AWAY, AGAINST = ({"driven": ("x",), "held": HELD, "velocity": (v, 0.0, 0.0)} for v in (-0.0015, 0.0015))
ROCK = Layer("rock", top=-HEIGHT, material={"strength": 200e3, "young": 50e6})
STEP = ((0.0, -HEIGHT), (0.001, 0.0))


def texts(number=6.4, cells=20, ground=STEP, layers=(ROCK,), limit=clay_cells.drawn_walls, gravity=-9.81, material=None,
          **table):
    """Warnings about a wall 3 m high on rock, at x < 0, with clay of γ H / s_u = number beside it."""
    size, values = HEIGHT / cells, {"law": "von-mises", "poisson": 0.49, "strength": WEIGHT * HEIGHT / number,
                                    **(material or {})}
    wall = body("box.geo", {"length": 0.53, "width": 1.0, "height": 3.2, "size": 20.0}, position=(-0.265, 0.5, -1.4),
                **(table or AWAY))
    grid = Grid(Axis(start=-12 * size, end=6.0, size=size), slice_(),
                Axis(start=-HEIGHT - 6 * size, end=2 * size, size=size))
    soil = Soil(Material(young=5e6, density=1700.0, **values), top=0.0, ground=ground, layers=layers, geostatic=False)
    return limit_texts(limit, scene("wall", grid, soil, [wall], Time(1.0, inertia=False), 10, (0.0, 0.0, gravity)))


def missing(found):
    """Share [-] of the load that a note gives."""
    return 0.01 * float(re.search(r"about (\d+)% too low", found[0])[1])


@pytest.mark.parametrize("number, cells, found", [
    (6.375, 5, 0.167), (6.375, 10, 0.507), (6.375, 20, 0.741), (6.375, 40, 0.869), (10, 10, 0.691), (10, 20, 0.825),
    (16, 10, 0.766), (16, 20, 0.884)])
def test_the_law_is_what_was_measured(number, cells, found):
    """Over γ H²/2 - 2 s_u H (demos/random/README.md)."""
    assert 1.0 - missing(texts(number, cells)) == pytest.approx(found, abs=0.07)


def test_a_wall_that_moves_away_from_clay():
    """Cells of 0.052 m leave 10 %: (H - 1.4 h)(H - H_c) over H (H - H_c)."""
    text, = texts()
    assert "box moves away from 3 m of clay that stands by itself up to 1.88 m only, 20 cells of 0.15 m" in text
    assert "about 24% too low" in text and "unsafe" in text
    finest = float(re.search(r"cells of at most ([\d.]+) m", text)[1])
    assert missing(texts(cells=HEIGHT // finest)) <= 0.11 and texts(cells=round(1.2 * HEIGHT / finest)) == []


def test_other_walls():
    """Clay that stands by itself, is pushed against, has no weight, or stands on both sides; sand."""
    assert texts(number=3.9) == [] and texts(**AGAINST) == [] and texts(gravity=0.0) == []
    assert texts(ground=((0.0, 0.0), (1.0, 0.0))) == []
    sand = {"law": "drucker-prager", "friction_angle": 30.0, "dilation_angle": 0.0, "cohesion": 1e3, "poisson": 0.3,
            "strength": None}
    assert texts(material=sand, layers=()) == []


def test_a_wall_that_is_pushed_against_clay():
    """As in sand, by a law of its own; not one that moves away, and not in front of sand."""
    text, = texts(cells=10, limit=clay_cells.pushed_walls, **AGAINST)
    assert "box ends 3 m deep in clay, 10 cells of 0.3 m" in text and "at least 15% too high" in text
    finest = float(re.search(r"cells of at most ([\d.]+) m", text)[1])
    assert texts(cells=round(1.1 * HEIGHT / finest), limit=clay_cells.pushed_walls, **AGAINST) == []
    assert texts(cells=10, limit=clay_cells.pushed_walls) == []
    hardly = AGAINST | {"velocity": (1e-5, 0.0, 0.0)}
    assert texts(cells=10, limit=clay_cells.pushed_walls, **hardly) == []
    sand = {"law": "drucker-prager", "friction_angle": 30.0, "dilation_angle": 0.0, "cohesion": 1e3, "poisson": 0.3,
            "strength": None}
    assert texts(cells=10, limit=clay_cells.pushed_walls, material=sand, layers=(), **AGAINST) == []


@pytest.mark.parametrize("cells, least, most", [(4, 1.366, 1.501), (8, 1.197, 1.277), (16, 1.107, 1.157)])
def test_the_law_of_a_pushed_wall_is_a_lower_bound_of_what_was_measured(cells, least, most):
    """Over 2 s_u d, after travels of 1 and 5 % of the depth (demos/random/README.md)."""
    assert 1.0 + clay_cells.IN_CLAY.foot / cells < 1.02 * least and most < 1.0 + 2.6 / cells


def test_the_mean_of_all_clay_behind_the_wall_counts():
    """Clay as strong in its upper half as is needed to stand; a strength that grows with depth; sand on clay, of which
    nothing is known."""
    upper = Layer("upper", bottom=-0.5 * HEIGHT, material={"strength": 3 * WEIGHT * HEIGHT / 6.4})
    assert texts(layers=(upper, ROCK)) == []
    su = WEIGHT * HEIGHT / 6.4
    assert "up to 1.87 m only" in texts(material={"strength": 0.5 * su, "strength_gradient": su / HEIGHT})[0]
    sand = Layer("sand", bottom=-0.5 * HEIGHT, law="drucker-prager",
                 material={"friction_angle": 30.0, "dilation_angle": 0.0, "cohesion": 1e3})
    assert texts(layers=(sand, ROCK)) == []


def test_clay_that_hangs_on_the_wall_is_not_judged():
    assert texts(tension="full", **AWAY) == []


def test_a_free_wall_in_front_of_clay():
    text, = texts(limit=clay_cells.clay_walls, held=("z", "ry"))
    assert "retains 3 m of clay" in text and "where it gives way, the pressure of the clay is about 24% too low" in text
    assert texts(limit=clay_cells.clay_walls) == []


@pytest.mark.parametrize("adhesion", [1.0, 0.5])
def test_a_strip_slides_over_clay_which_stays_attached_with_the_force_of_its_base(adhesion):
    """α s_u B, over a fifth of its width, on 10 cells: the grid goes along with it."""
    strip = body("box.geo", {"length": 1.0, "width": 1.0, "height": 0.3, "size": 20.0}, position=(0.0, 0.5, 0.15),
                 driven=("x",), held=HELD, velocity=(0.01, 0.0, 0.0), adhesion=adhesion, tension="full")
    grid = Grid(Axis(start=-2.0, end=2.4, size=0.1), slice_(), Axis(start=-1.0, end=0.3, size=0.1), Faces(z_min="fixed"))
    soil = Soil(Material(law="von-mises", young=5e6, poisson=0.49, density=1.0, strength=1e4), top=0.0, geostatic=False)
    simulation = build(scene("strip", grid, soil, [strip], Time(1.0, inertia=False), 20, (0.0, 0.0, 0.0)))
    over = [-record.bodies[0].contact_force[0] / (1e4 * adhesion) for record in simulation.steps()]
    assert np.mean(over[5:]) == pytest.approx(1.0, abs=0.03) and np.abs(np.subtract(over[5:], 1.0)).max() < 0.08


@pytest.mark.parametrize("across, adhesion, said", [
    (4, None, "about 19%"), (6, None, None), (3, 1.0, "about 17%"), (4, 1.0, None)])
def test_a_cylinder_deep_in_clay_on_few_cells(across, adhesion, said):
    simulation = build(plasticity.buried(across, adhesion=adhesion))
    found = list(clay_cells.flow_around(simulation.scene, simulation.model))
    assert len(found) == (said is not None)
    assert all(said in text and f"{across} cells of" in text and "limit 10%" in text for text in found)


def on_ground(cells, travel=0.5, across=1.0, load=0.0, **motion):
    """Warnings about a pipe of 1 m in plane strain, so many cells wide, on cells `across` times as wide as high, that is
    driven down by `travel` [m], or has a load [N] beside its weight of 7.7 kN."""
    size = 1.0 / cells
    motion = motion or ({} if load else {"driven": ("z",), "velocity": (0.0, 0.0, -0.1 * travel)})
    pipe = body("cylinder.geo", {"radius": 0.5, "height": 1.0, "size": 0.1}, rotation=(1.0, 0.0, 0.0, 90.0), rest_on=0.0,
                position=(0.0, 0.5, 0.0), **motion)
    grid = Grid(Axis(start=-2.0, end=2.0, size=across * size), slice_(), Axis(start=-2.0, end=2 * size, size=size))
    clay = Soil(Material(law="von-mises", young=2e6, poisson=0.49, density=1600.0, strength=5e3), top=0.0)
    described = scene("pipe", grid, clay, [pipe], Time(1.0, inertia=False), 10, (0.0, 0.0, -9.81))
    if load:
        described = replace(described, stages=(Stage("load", 10, loads=(Load(force=(0.0, 0.0, -load)),)),))
    simulation = build(described)
    return [text for limit in (clay_cells.pushed_pipes, clay_cells.laid_pipes)
            for text in limit(simulation.scene, simulation.model)]


@pytest.mark.parametrize("cells, across, said", [(4, 1.0, "about 16%"), (6, 1.0, None), (8, 2.0, "4 cells of 0.25 m")])
def test_a_pipe_pushed_into_clay_on_few_cells(cells, across, said):
    """Cells twice as wide as high count by their width."""
    found = on_ground(cells, across=across)
    assert len(found) == (said is not None) and all(said in text and "at most 0.2 m" in text for text in found)


def test_a_pipe_that_stays_on_the_clay_or_goes_aside_is_not_judged():
    assert not on_ground(4, travel=0.05)
    assert not on_ground(4, driven=("x", "z"), velocity=(0.05, 0.0, 0.0), held=("ry",))


@pytest.mark.parametrize("cells, load, said", [(4, 8e3, "its depth is about 31% too small"), (8, 8e3, None), (4, 1.0, None)])
def test_a_pipe_laid_on_clay_by_its_load_on_few_cells(cells, load, said):
    """To 0.12 of its width; by its own weight alone to 0.007 of it."""
    found = on_ground(cells, load=load)
    assert len(found) == (said is not None) and all(said in text and "at most 0.13 m" in text for text in found)


def test_a_box_with_a_load_is_no_pipe():
    """Its contact surface has not all of its triangles in plane strain, which have no ends."""
    box = body("box.geo", {"length": 1.0, "width": 1.0, "height": 0.5, "size": 20.0}, rest_on=0.0, position=(0.0, 0.5, 0.0))
    grid = Grid(Axis(start=-2.0, end=2.0, size=0.25), slice_(), Axis(start=-2.0, end=0.5, size=0.25))
    clay = Soil(Material(law="von-mises", young=2e6, poisson=0.49, density=1600.0, strength=5e3), top=0.0)
    simulation = build(scene("box", grid, clay, [box], Time(1.0, inertia=False), 10, (0.0, 0.0, -9.81)))
    assert not list(clay_cells.laid_pipes(simulation.scene, simulation.model))


def test_the_law_of_pipes_is_what_was_measured():
    """Means over depths of 0.1 to 0.5 of the width, smooth, over 16 cells, which are 1 % over 5.3 (w/D)^0.25."""
    for cells, measured in ((4, 0.15), (5, 0.09), (6, 0.07), (8, 0.04)):
        assert clay_cells.PIPE / cells**2 == pytest.approx(measured, abs=0.012)


@pytest.mark.parametrize("share, count", [(1.0, 1), (0.4, 0)])
def test_a_cylinder_that_a_force_pushes_through_clay_is_told_as_a_driven_one(share, count):
    """By what it carries, and by two fifths of that."""
    described = plasticity.buried(4)
    pipe = replace(described.bodies[0], driven=(), velocity=(0.0, 0.0, 0.0))
    force = share * 9.14 * 0.125 * described.soil.material.strength      # of 1 m in a slice of half a cell
    push = replace(described.stages[0], loads=(Load(force=(force, 0.0, 0.0)),))
    simulation = build(replace(described, bodies=(pipe,), stages=(push,)))
    found = list(clay_cells.flow_around(simulation.scene, simulation.model))
    assert len(found) == count and all("about 19%" in text for text in found)


def test_a_pile_in_plan_is_deep_in_clay():
    """The slice has no top."""
    pile = body("cylinder.geo", {"radius": 0.5, "height": 1.0, "size": 0.1}, position=(0.0, 0.0, 0.5), driven=("x",),
                held=("y", "rz"), velocity=(0.01, 0.0, 0.0), tension="full")
    across = Axis(start=-4.0, end=4.0, size=0.25)
    clay = Soil(Material(law="von-mises", young=5e6, poisson=0.49, density=1600.0, strength=1e4), geostatic=False)
    grid = Grid(across, across, Axis(start=0.0, end=1.0, collapsed=True))
    simulation = build(scene("pile", grid, clay, [pile], Time(1.0, inertia=False), 10, (0.0, 0.0, 0.0)))
    text, = clay_cells.flow_around(simulation.scene, simulation.model)
    assert "is round and 4 cells of 0.25 m wide" in text and "about 59%" in text


@pytest.mark.parametrize("factor, measured", [(clay_cells.AROUND, {4: 0.183, 6: 0.085, 8: 0.051, 12: 0.029, 16: 0.018}),
                                              (clay_cells.ROUGH, {4: 0.094, 6: 0.049, 8: 0.033, 12: 0.016})])
def test_the_law_of_flow_around_a_cylinder_is_what_was_measured(factor, measured):
    for across, excess in measured.items():
        assert factor / across**2 == pytest.approx(excess, abs=0.01)


def test_a_cylinder_that_clay_stays_attached_to_is_judged_by_its_own_law():
    """Smooth 50, 34, 15 % with 4, 5, 8 cells; α = 1: 25, 14, 6 %; α = 0.5: 23, 5 % with 5, 10."""
    for adhesion, measured in ((0.0, {4: 0.5, 5: 0.34, 8: 0.15}), (1.0, {4: 0.25, 5: 0.14, 8: 0.06}),
                               (0.5, {5: 0.23, 10: 0.05})):
        pipe = SimpleNamespace(interface=SimpleNamespace(adhesion=adhesion, tension=np.inf))
        clay = SimpleNamespace(law=None)
        for across, excess in measured.items():
            assert clay_cells._around(pipe, clay) / across**2 == pytest.approx(excess, abs=0.07)
    buried = plasticity.buried(5, adhesion=1.0)
    simulation = build(replace(buried, bodies=(replace(buried.bodies[0], tension="full"),)))
    text, = clay_cells.flow_around(simulation.scene, simulation.model)
    assert "about 17% too high" in text
    far = replace(buried.bodies[0], tension="full", velocity=tuple(30.0 * np.array(buried.bodies[0].velocity)))
    simulation = build(replace(buried, bodies=(far,)))
    assert "about 40% too high" in list(clay_cells.flow_around(simulation.scene, simulation.model))[0]


@pytest.mark.parametrize("number, cells, found", [
    (clay_cells.PRISM, 3, 1.65), (clay_cells.PRISM, 6, 1.30), (clay_cells.PRISM, 6, 1.26), (clay_cells.PRISM, 12, 1.11),
    (clay_cells.PRISM, 24, 1.04), (clay_cells.OFF_LINES, 3, 1.41), (clay_cells.OFF_LINES, 6, 1.20)])
def test_the_law_of_plates_lifted_out_of_clay_is_what_was_measured(number, cells, found):
    assert found == pytest.approx(1 + number / cells, abs=0.12 if cells == 3 else 0.04)


def lifted(depth=0.75, half=1.0, speed=0.01, gravity=0.0, strength=1e4, strength_gradient=0.0, height=0.5, stages=None,
           joint=None, slack=0.0, end=None, **table):
    """Warnings about a half of a strip under so much clay, on cells of 0.25 m; joint: its kind, to a driven body above; end:
    of the clay along x."""
    moves = {"driven": ("z",), "velocity": (0.0, 0.0, speed)} | table
    plate = body("box.geo", {"length": 2 * half, "width": 1.0, "height": height, "size": 20.0},
                 position=(0.0, 0.5, -depth - 0.5 * height), **moves)
    grid = Grid(Axis(start=0.0, end=4.0, size=0.25), slice_(), Axis(start=-12.0, end=0.5, size=0.25), Faces(z_min="fixed"))
    clay = Soil(Material(law="von-mises", young=5e6, poisson=0.49, density=1600.0, strength=strength,
                         strength_gradient=strength_gradient), top=0.0, geostatic=False, upper=end and (end, 1.0, 0.0))
    described = scene("plate", grid, clay, [plate], Time(1.0, inertia=False), 10, (0.0, 0.0, gravity))
    if joint:
        ends = {"kind": joint, "point": (0.0, 0.0, 0.5 * height), "end": (0.0, 0.0, -0.2)}
        ends |= {"length": 1.8 + depth + slack} if slack else {}
        tug = body("box.geo", {"length": 0.4, "width": 1.0, "height": 0.4, "size": 20.0}, name="tug", held=("x", "ry"),
                   position=(0.0, 0.5, 2.0))
        stages = (Stage("lift", 10, motions=(Motion(body="tug", component="z", velocity=speed),)),)
        described = replace(described, bodies=(plate, tug), joints=(Joint("rope", bodies=(plate.name, "tug"), **ends),))
    simulation = build(replace(described, stages=stages or described.stages))
    return list(clay_cells.lifted_plates(simulation.scene, simulation.model))


def test_a_plate_lifted_out_of_clay_on_few_cells():
    text, = lifted()
    assert "0.75 m of it, 3 cells of 0.25 m" in text and "about 53% too high" in text and "at most 0.047 m" in text
    assert not lifted(end=0.75)     # as wide as the clay on it: a platen
    assert "about 40%" in lifted(half=1.06)[0]      # edges off lines of the grid
    assert "about 42%" in lifted(gravity=-9.81)[0]  # of 0.39 that the strength of the clay bears, and 2/3 of that of weight
    assert "about 11%" in lifted(3.75)[0]
    assert "about 53%" in lifted(strength=5e3, strength_gradient=1e3)[0] and lifted(strength=0.0, strength_gradient=1e3)
    assert not lifted(-0.25)    # on the ground
    assert not lifted(6.5) and not lifted(speed=-0.01) and not lifted(adhesion=1.0, tension="full")
    assert not lifted(tension=1e6) and lifted(tension=1e5)      # one that clay of s_u = 10 kPa never reaches
    assert not lifted(height=0.25) and lifted(height=0.3)       # soil on both sides of it shares nodes, which is told


FREE = {"driven": (), "velocity": (0.0, 0.0, 0.0), "held": ("x", "ry")}


def test_a_plate_that_a_line_or_a_rope_lifts_is_judged_as_a_driven_one():
    def drawn(*velocity):
        return lifted(pull=Pull((0.0, 0.0, 0.25), velocity, 1e6, 3.0), **FREE)

    assert drawn(0.0, 0.0, 0.01) == lifted() == lifted(joint="line", **FREE) == lifted(joint="rod", **FREE)
    assert not drawn(0.01, 0.0, 0.0) and not drawn(0.0, 0.0, -0.01) and not lifted(joint="rod", speed=-0.01, **FREE)
    assert not lifted(joint="line", slack=0.2, **FREE) and lifted(joint="line", slack=0.05, **FREE)


@pytest.mark.parametrize("force, told", [(0.9, False), (1.2, True)])
def test_a_force_below_its_weight_lifts_no_plate(force, told):
    """Half of a plate of 2 x 1 x 0.5 m of steel."""
    load = Stage("lift", 1, loads=(Load(force=(0.0, 0.0, force * 7850 * 0.5 * 9.81)),))
    assert bool(lifted(gravity=-9.81, stages=(load,), density=7850.0, **FREE)) == told


def balls(cells, depth=3.0, velocity=(0.0, 0.0, -0.01), **shape):
    """Warnings about a quarter of a ball, 1 m and so many cells wide, driven in clay with its centre at a `depth` [m]."""
    size = 1.0 / cells
    ball = body("sphere.geo", {"radius": 0.5, "size": 0.2, **shape}, position=(0.0, 0.0, -depth), driven=("z",),
                velocity=velocity, tension="full")
    across = Axis(start=0.0, end=6 * size, size=size)
    grid = Grid(across, across, Axis(start=-round(5 / size) * size, end=size, size=size), Faces(z_min="fixed"))
    clay = Soil(Material(law="von-mises", young=2e6, poisson=0.49, density=1600.0, strength=5e3), top=0.0)
    simulation = build(scene("ball", grid, clay, [ball], Time(1.0, inertia=False), 10, (0.0, 0.0, -9.81)))
    return list(clay_cells.balls(simulation.scene, simulation.model))


def test_a_ball_deep_in_clay_on_few_cells():
    """54, 46, 25 % with 3, 4, 6 cells."""
    text, = balls(4)
    assert "cells of 0.25 m wide, deep in the clay" in text and "about 41% too high" in text and "at most 0.062 m" in text
    assert not balls(4, depth=1.0, velocity=(0.0, 0.0, 0.05))


def penetrators(cells, travel=2.0, **motion):
    """Warnings about a quarter of a cone on clay, 1 m and so many cells wide, that is driven down by `travel` [m] if its
    motion is not given."""
    size = 1.0 / cells
    motion = motion or {"driven": ("z",), "velocity": (0.0, 0.0, -0.1 * travel)}
    cone = body("cone.geo", {"radius": 0.5, "angle": 60.0, "shaft": 2.0, "size": 0.25}, rest_on=0.0, **motion)
    across = Axis(start=0.0, end=6 * size, size=size)
    grid = Grid(across, across, Axis(start=-6 * size, end=size, size=size), Faces(z_min="fixed"))
    clay = Soil(Material(law="von-mises", young=2e6, poisson=0.49, density=1600.0, strength=5e3), top=0.0)
    time = Time(1.0, inertia=False) if "driven" in motion else Time(0.001)
    simulation = build(scene("cone", grid, clay, [cone], time, 10, (0.0, 0.0, -9.81)))
    return list(clay_cells.penetrators(simulation.scene, simulation.model))


@pytest.mark.parametrize("cells, said", [(2, "about 110%"), (3, "about 55%"), (4, None)])
def test_a_penetrometer_on_few_cells(cells, said):
    found = penetrators(cells)
    assert len(found) == (said is not None)
    assert all(said in text and f"{cells} cells of" in text and "at most 0.25 m" in text for text in found)


def test_a_penetrometer_that_stays_at_the_surface_is_not_judged():
    assert not penetrators(3, travel=0.5) and not penetrators(3, driven=("z",), velocity=(0.0, 0.0, 0.1))


def test_a_body_that_falls_into_clay_is_judged_by_its_speed():
    """Its energy is used up by ten times the strength after 2.6 and 0.3 widths."""
    assert len(penetrators(3, velocity=(0.0, 0.0, -12.0))) == 1 and not penetrators(3, velocity=(0.0, 0.0, -4.0))


def test_the_law_of_penetrometers_is_what_was_measured():
    """The mean of a cone and of a rod with a round tip."""
    for cells, cone, rod in ((2, 1.0, 1.1), (2.5, 0.85, 1.1), (3, 0.43, 0.7), (3.5, 0.18, 0.2), (4, 0.03, 0.07)):
        law = clay_cells.PENETRATED * (clay_cells.RESOLVED - cells)
        assert law == pytest.approx(0.5 * (cone + rod), abs=0.16)
