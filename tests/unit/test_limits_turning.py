"""Bodies turned in clay: the note has the torque that was measured, and is not given beside its limits."""

from dataclasses import replace

import pytest
from limit_texts import limit_texts

from hybrid.monitors.limits import LIMITS, turning
from hybrid.scene import Axis, Faces, Grid, Joint, Load, Material, Motion, Soil
from hybrid.setup.build import build
from hybrid.study.random.fresh import clay
from hybrid.study.random.fresh.problem import WEIGHTLESS, body, scene

HELD = ("x", "y", "z", "rx", "ry")
TURNED = {"driven": ("rz",), "held": HELD, "spin": (0.0, 0.0, 0.002)}
PILE = "cylinder.geo", {"radius": 0.5, "height": 1.5, "size": 0.3}
BLADE = "box.geo", {"length": 1.0, "width": 0.3, "height": 1.0, "size": 2.0}


def notes(made=PILE, size=0.125, material=None, loads=(), top=0.0, **table):
    """Texts about a body in clay whose top is flush with it, or higher by `top` [m]."""
    file, values = made
    made = body(file, values, position=(0.0, 0.0, -0.5 * values["height"] + top),
                **{"adhesion": 1.0, "tension": "full"} | (table or TURNED))
    side = Axis(start=-1.5, end=1.5, size=size)
    grid = Grid(side, side, Axis(start=-2.5, end=max(0.25, size), size=size), Faces(z_min="fixed"))
    described = scene("turn", grid, Soil(material or clay.clay(2e4), top=0.0, geostatic=False), [made],
                      clay.Time(1.0, inertia=False), 4, WEIGHTLESS)
    simulation = build(replace(described, stages=(replace(described.stages[0], loads=loads),)))
    return list(turning.turned(simulation.scene, simulation.model))


@pytest.mark.parametrize("across, torque", [(7, 69.3), (10, 59.9)])
def test_the_law_of_vanes_is_what_was_measured(across, torque):
    """[kN m] of D = H = 1 m in 20 kPa after 0.02 rad, where π s_u (D² H/2 + D³/6) is 41.9."""
    assert torque / 41.9 == pytest.approx((1 + turning.SHEARED / across) ** 3, abs=0.03)


def test_a_blade_shears_the_next_cell_whatever_holds_on_to_it():
    for table in ({}, {"adhesion": None, "tension": None}):
        text, = notes(BLADE, **TURNED | table)
        assert "turned about z in clay, 8 cells of 0.125 m across" in text and "about 57% too high, limit 10%" in text
        assert "diameter as 1.16 m" in text
        assert "length as 1.16 m" in text and "cells of at most 0.026 m" in text


def test_a_blade_in_plan_view_has_no_ends():
    """A vane of 16 and 32 cells, 0.98 to 1.08 of 2 π R² s_u with 32: 1.08 to 1.25 with 16."""
    side = Axis(start=-1.5, end=1.5, size=0.125)
    made = body(*BLADE, position=(0.0, 0.0, 0.5), driven=("rz",), held=("x", "y"), spin=(0.0, 0.0, 0.002))
    described = scene("turn", Grid(side, side, Axis(start=0.0, end=1.0, collapsed=True)), Soil(clay.clay(2e4)), [made],
                      clay.Time(1.0, inertia=False), 4, WEIGHTLESS)
    simulation = build(described)
    text, = turning.turned(simulation.scene, simulation.model)
    assert "about 35% too high" in text and "1.3 cells wider. Use cells of at most 0.038 m" in text
    assert "diameter as 1.16 m where s_u follows" in text


def test_clay_that_slips_along_a_round_body():
    for adhesion in (1.0, 0.5):
        text, = notes(**TURNED, adhesion=adhesion, tension=None)
        assert "8 cells of 0.125 m across, limit 16," in text and "13 % and 6 % too low" in text
        assert "at most 0.062 m" in text
    # smooth
    assert not notes(**TURNED, adhesion=None, tension=None) and not notes(**TURNED, adhesion=None, tension="full")


def test_a_moment_turns_a_body_that_is_free():
    moment = (Load(moment=((0.0, 0.0, 0.0, 0.0), (4.0, 0.0, 0.0, 4e4))),)
    assert "about 57%" in notes(BLADE, loads=moment, held=HELD)[0]
    assert not notes(BLADE, held=HELD) and not notes(BLADE, loads=moment, held=(*HELD, "rz"))


def test_elastic_soil_and_bodies_above_the_clay_are_not_judged():
    assert not notes(BLADE, material=replace(clay.clay(2e4), law="hencky", strength=None), **TURNED, adhesion=None,
                     tension=None)
    assert not notes(BLADE, top=1.01)


def test_a_body_that_stands_on_clay_has_no_round_side_in_it():
    assert not notes(("cylinder.geo", {"radius": 0.5, "height": 0.5, "size": 0.3}), top=0.5, **TURNED, adhesion=1.0)


def test_what_stands_above_the_clay_bears_nothing():
    """A blade of 1 m, three quarters of it above the clay: that of one of 0.25 m."""
    text, = notes(BLADE, top=0.75)
    expected = (1 + 1.3 * 0.125) ** 2 * (1 + 1.3 * 0.125 / 0.25) - 1
    assert f"about {expected:.0%} too high" in text


# ------------------------------------------------------------------ turned over


def over(depth=0.0, space=False, size=0.125, law="von-mises", spin=0.01, foot=2.5, loads=(), stage_held=(),
         sand=False, stiffening=False, lower=None, **table):
    """Texts about a box of 1 m by 1 m by 2 m whose base is at a `depth` [m], turned about y by so many radians a step;
    lower: height of the foot of the soil [m], where that is above the base of the grid."""
    values = {"length": 1.0, "width": 1.0, "height": 2.0, "size": 2.0}
    table = {"driven": ("ry",), "held": ("x", "y", "z", "rx", "rz"), "spin": (0.0, spin, 0.0)} | table
    made = body("box.geo", values, position=(0.0, 0.0, 1.0 - depth), **table)
    side, across = Axis(start=-1.5, end=1.5, size=size), Axis(start=-0.5, end=0.5, collapsed=True)
    grid = Grid(side, side if space else across, Axis(start=-foot, end=0.25, size=size), Faces(z_min="fixed"))
    material = clay.clay(2e4) if law == "von-mises" else replace(clay.clay(2e4), law=law, strength=None)
    if stiffening:
        material = replace(material, young=None, reference_young=1e7, stiffness_exponent=0.5)
    if sand:
        material = Material(law="mohr-coulomb", young=2e7, poisson=0.3, density=1700.0, friction_angle=33.0,
                            dilation_angle=0.0, cohesion=100.0)
    soil = Soil(material, top=0.0, geostatic=stiffening, lower=lower and (-1.5, -0.5, lower))
    described = scene("over", grid, soil, [made], clay.Time(1.0, inertia=False), 4,
                      (0.0, 0.0, -9.81) if stiffening else WEIGHTLESS)
    simulation = build(replace(described, stages=(replace(described.stages[0], loads=loads, held=stage_held),)))
    return list(turning.turned_over(simulation.scene, simulation.model))


@pytest.mark.parametrize("moment, limit", [((0.989, 0.883, 0.828), 0.77), ((101.2, 91.7, 85.9), 81.0)])
def test_the_law_of_bodies_turned_over_is_what_was_measured(moment, limit):
    """Strips on clay, M/(s_u B²), and walls in it, M [kN m/m], with 8, 16, 32 cells."""
    for n, found in zip((8, 16, 32), moment):
        assert found / limit == pytest.approx(1 + turning.OVER / n, abs=0.03)


def test_a_footing_or_a_wall_that_is_turned_over_drives_the_next_cells():
    text, = over()
    assert "turned about y, 8 cells of 0.125 m across" in text and "up to 28% too high, limit 10%" in text
    assert "up to 32% too high" in over(space=True, size=0.125)[0]
    assert "12 cells of 0.125 m across" in over(depth=1.5)[0]
    buried, = over(depth=3.0, foot=4.0)     # all of it, 2 m high
    assert "16 cells of 0.125 m across" in buried and "up to 35% too high" in buried
    assert "up to 28%" in over(spin=0.0, driven=(), held=("x", "y", "z", "rx", "rz"),
                               loads=(Load(moment=((0.0, 0.0, 0.0, 0.0), (4.0, 0.0, 4e4, 0.0))),))[0]


def test_clay_whose_modulus_follows_the_stress_is_taken_to_flow():
    assert "up to 28%" in over(stiffening=True)[0]


def test_what_is_not_turned_over_in_soil_that_flows_has_no_text():
    assert not over(spin=1e-5)                  # the clay is elastic
    assert not over(law="hencky")
    small = (Load(moment=((0.0, 0.0, 0.0, 0.0), (4.0, 0.0, 1.0, 0.0))),)
    free = {"spin": 0.0, "driven": (), "held": ("x", "y", "z", "rx", "rz")}
    assert not over(loads=small, **free)        # 1 N m
    assert not over(loads=(Load(moment=((0.0, 0.0, 0.0, 0.0), (4.0, 0.0, 4e4, 0.0))),), **free, stage_held=("ry",))
    assert not over(depth=1.5, foot=1.5)        # a wall beside all of the soil
    assert not over(depth=-1.0)                 # in the air
    assert not over(depth=1.0, lower=-0.5) and over(depth=0.25, lower=-0.5)     # a tray that carries the soil


@pytest.mark.parametrize("n, moment", [(4, 41.7), (6, 36.9), (8, 34.3)])
def test_a_caisson_deep_in_clay_has_the_law_of_footings_in_space(n, moment):
    """[kN m] of one as deep as wide, towards 26.6; the law of vanes gave twice the excess."""
    assert moment / 26.6 == pytest.approx(1 + turning.OVER_IN_SPACE / n, rel=0.06)
    text, = over(depth=1.5, space=True)
    assert "is turned about y" in text and "up to 22% too high" in text


def test_a_box_deep_in_sand_in_space_has_the_law_that_was_measured():
    """24.8 and 21.9 kN m with 4 and 8 cells in its width, towards 19.0."""
    for n, moment in ((4, 24.8), (8, 21.9)):
        assert moment / 19.0 == pytest.approx(1 + turning.IN_SAND / n, abs=0.02)
    text, = over(depth=0.5, space=True, sand=True)
    assert "up to 15% too high" in text


@pytest.mark.parametrize("rise, cells", [(0.5, 3.1), (0.3, 5.1), (1.2, 0.0)])
def test_a_blade_that_is_turned_into_clay_is_judged_where_most_of_it_is_in_it(rise, cells):
    """Level at the start on a hinge above the clay, turned by 90 degrees."""
    values = {"length": 0.8, "width": 1.0, "height": 0.2, "size": 2.0}
    made = body("box.geo", values, position=(0.0, 0.0, rise), name="blade")
    side, across = Axis(start=-1.5, end=1.5, size=0.1), Axis(start=-0.5, end=0.5, collapsed=True)
    grid = Grid(side, across, Axis(start=-1.5, end=1.8, size=0.1), Faces(z_min="fixed"))
    described = scene("blade", grid, Soil(clay.clay(2e4), top=0.0, geostatic=False), [made],
                      clay.Time(1.0, inertia=False), 4, WEIGHTLESS)
    turn = replace(described.stages[0], motions=(Motion(component="ry", displacement=((0.0, 0.0), (4.0, 90.0))),))
    pin = Joint("pin", "hinge", ("blade",), (-0.4, 0.0, 0.0), axis=(0.0, 1.0, 0.0))
    simulation = build(replace(described, stages=(turn,), joints=(pin,)))
    found = list(turning.turned_over(simulation.scene, simulation.model))
    assert len(found) == bool(cells) and all(f"{cells:.2g} cells of 0.1 m across" in text for text in found)


def test_check_and_runs_ask_for_it():
    assert turning.turned in LIMITS and turning.turned_over in LIMITS


@pytest.mark.parametrize("cells, least, most", [(10, 1.4, 1.71), (20, 1.27, 1.31)])
def test_the_law_of_a_vane_deep_in_clay_in_plane_strain_is_what_was_measured(cells, least, most):
    """Over 2 π R² s_u, of blades 0.2 m thick and 1 m across."""
    assert least - 0.02 < (1 + turning.BURIED / cells) ** 2 < most


@pytest.mark.parametrize("depth, size, spin, told", [
    (0.95, 0.1, 0.005, 1), (0.9, 0.05, 0.005, 1), (0.95, 0.1, 0.0, 0), (1.0, 0.1, 0.005, 0), (0.5, 0.2, 0.005, 0)])
def test_a_body_that_is_turned_just_above_the_base_is_told(depth, size, spin, told):
    """A strip 1 m wide over a base 1 m under the ground; one that stands on it, and one far above, are not."""
    strip = body("box.geo", {"length": 1.0, "width": 1.0, "height": 0.3, "size": 20.0}, position=(0.0, 0.5, 0.0),
                 rest_on=-depth, driven=("ry",), held=("x", "z"), spin=(0.0, spin, 0.0), adhesion=1.0)
    grid = Grid(Axis(-2.0, 2.0, size), Axis(0.0, 1.0, collapsed=True), Axis(-1.0, 0.4, size), Faces(z_min="fixed"))
    described = scene("turn", grid, Soil(clay.clay(1e4), top=0.0, geostatic=False), [strip],
                      clay.Time(1.0, inertia=False), 4, WEIGHTLESS)
    found = limit_texts(turning.turned_on_base, described)
    assert len(found) == told and all("above the fixed base of the grid, limit 3" in text for text in found)
