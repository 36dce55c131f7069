"""Limits of strips on few cells: laws are what was measured (demos/random/README.md), and only such strips have the note."""

import re
from dataclasses import replace

import numpy as np
import pytest
from limit_texts import limit_texts

from hybrid.monitors.limits import LIMITS, cells, footing_cells
from hybrid.scene import Axis, Grid, Layer, Load, Material, Motion, Soil, Time
from hybrid.setup.build import build
from hybrid.study.random.fresh.problem import PUSHED, WEIGHTLESS, body, scene, slice_

PRANDTL = {10: 8.345, 20: 14.835, 30: 30.140}
CLAY = {"law": "von-mises", "friction_angle": None, "dilation_angle": None, "cohesion": None, "strength": 1e4}


@pytest.mark.parametrize("angle, cells, found", [
    (10, 8, 9.459), (10, 16, 8.994), (10, 32, 8.724), (20, 8, 17.490), (20, 16, 16.407), (20, 32, 15.754), (30, 8, 36.696),
    (30, 16, 34.160), (30, 32, 32.668)])
def test_the_law_of_rough_strips_is_what_was_measured(angle, cells, found):
    assert found / PRANDTL[angle] - 1 == pytest.approx(footing_cells.strip_excess(angle, cells), abs=0.008)


@pytest.mark.parametrize("angle, dilation, n, reached, found", [
    (10, 10, 8, 33.7, 1.179), (10, 10, 16, 33.7, 1.104), (20, 20, 8, 13.5, 1.209), (20, 20, 8, 33.7, 1.249),
    (20, 20, 16, 33.7, 1.158), (20, 20, 32, 33.7, 1.107), (30, 30, 8, 19.9, 1.309), (30, 30, 8, 33.2, 1.346),
    (30, 30, 16, 33.2, 1.237), (20, 10, 8, 33.7, 1.201), (20, 10, 16, 33.7, 1.115), (20, 5, 8, 33.7, 1.161),
    (20, 0, 8, 6.7, 1.036), (20, 0, 8, 33.7, 1.044), (20, 0, 16, 33.7, 1.0), (10, 0, 8, 33.7, 1.082),
    (10, 5, 8, 16.8, 1.134)])
def test_it_rises_with_the_way_and_is_less_with_less_dilation(angle, dilation, n, reached, found):
    """Loads over Prandtl's; w E/(B c N_c) = reached."""
    over = found * PRANDTL[angle] / footing_cells.prandtl(footing_cells._reduced(angle, dilation)) - 1
    assert over == pytest.approx(footing_cells.strip_excess(angle, n, dilation / angle, reached), abs=0.04)


def test_the_reduced_angle_is_that_of_soil_which_dilates_as_it_slides():
    assert footing_cells._reduced(20.0, 20.0) == pytest.approx(20.0)
    assert np.tan(np.radians(footing_cells._reduced(30.0, 0.0))) == pytest.approx(0.5)
    assert footing_cells.prandtl(20.0) == pytest.approx(PRANDTL[20], abs=0.001)


@pytest.mark.parametrize("angle, found", [(20, 15.868), (30, 32.714)])
def test_that_of_smooth_ones_is_less(angle, found):
    law = footing_cells.SMOOTH * footing_cells.strip_excess(angle, 16)
    assert found / PRANDTL[angle] - 1 == pytest.approx(law, abs=0.006)


@pytest.mark.parametrize("angle", PRANDTL)
def test_extrapolating_as_the_note_says(angle):
    coarse, fine = {10: (8.994, 8.724), 20: (16.407, 15.754), 30: (34.160, 32.668)}[angle]
    assert fine - 1.5 * (coarse - fine) == pytest.approx(PRANDTL[angle], rel=0.02)


def strip(size=0.125, half=0.5, gravity=WEIGHTLESS, material=(), loads=(), **table):
    """Half a strip of 1 m with 8 cells in its width, on soil with c = 10 kPa and φ = 20°."""
    values = {"law": "mohr-coulomb", "young": 1e8, "poisson": 0.3, "density": 1600.0, "friction_angle": 20.0,
              "dilation_angle": 20.0, "cohesion": 1e4} | dict(material)
    foot = body("box.geo", {"length": 2 * half, "width": 1.0, "height": 0.5, "size": 5.0}, position=(0.0, 0.5, 0.0),
                **{"rest_on": 0.0, "friction": 0.5, "velocity": (0.0, 0.0, -0.001)} | PUSHED | table)
    grid = Grid(Axis(start=0.0, end=24 * size, size=size), slice_(), Axis(start=-16 * size, end=2 * size, size=size))
    soil = Soil(Material(**values), top=0.0, geostatic=bool(gravity[2]))
    described = scene("strip", grid, soil, [foot], Time(1.0, inertia=False), 5, gravity)
    return replace(described, stages=(replace(described.stages[0], loads=loads),))


@pytest.mark.parametrize("n, found", [(8, 23.10), (12, 21.85)])
def test_square_footings_have_the_law_of_strips(n, found):
    """Rough, φ = ψ = 20°, weightless; 19.35 is what 4, 8 and 12 cells extrapolate to."""
    assert found / 19.35 - 1 == pytest.approx(footing_cells.strip_excess(20, n), abs=0.02)


def in_space(position=(0.0, 0.0, 0.0), gravity=WEIGHTLESS, size=0.2, material=(), **table):
    """A quarter of a square plate of 1.6 m with eight cells in its width."""
    values = {"law": "mohr-coulomb", "young": 2e7, "poisson": 0.3, "density": 1600.0, "friction_angle": 35.0,
              "dilation_angle": 35.0, "cohesion": 1e4} | dict(material)
    plate = body("box.geo", {"length": 1.6, "width": 1.6, "height": 0.4, "size": 20.0}, position=position,
                 **PUSHED | {"velocity": (0.0, 0.0, -0.004)} | table)
    side = Axis(0.0, 2.8, size)
    return scene("plate", Grid(side, side, Axis(-4.0, 0.4, size)), Soil(Material(**values), top=0.0, geostatic=False),
                 [plate], Time(1.0, inertia=False), 12, gravity)


def test_square_footings_and_plates_in_space():
    text, = limit_texts(footing_cells.cohesive_strips, in_space(friction=0.5))
    assert "8 cells of 0.2 m wide" in text and "24% too high" in text
    buried, sand = (0.0, 0.0, -3.4), {"gravity": (0.0, 0.0, -9.81), "material": {"cohesion": 50.0}}
    text, = limit_texts(footing_cells.lifted, in_space(buried, velocity=(0.0, 0.0, 0.006), **sand))
    assert "8 cells of 0.2 m wide, 3.2 m under the ground: its load is about 19% too high" in text
    assert not limit_texts(footing_cells.lifted, in_space(buried, **sand))
    quarter = in_space((0.4, 0.4, -3.4), velocity=(0.0, 0.0, 0.006), **sand)
    part = replace(quarter.bodies[0], parameters={"length": 0.8, "width": 0.8, "height": 0.4, "size": 20.0})
    assert limit_texts(footing_cells.lifted, replace(quarter, bodies=(part,))) == [text]


@pytest.mark.parametrize("n, found", [(6, 0.30), (8, 0.20)])
def test_the_law_of_square_plates_lifted_out_of_sand_is_what_was_measured(n, found):
    """H/B = 2, φ = ψ = 35°, over Murray & Geddes' bound."""
    slope = 2.0 * footing_cells._slope(35.0, 35.0)
    excess = footing_cells.IN_SPACE / n * (2.0 + 2.0 * slope) / (1.0 + 2.0 * slope + 4 / 3 * slope**2)
    assert excess == pytest.approx(found, abs=0.055)


def test_sand_of_a_relative_density_with_values_of_its_own():
    """Its weight and dilation are those of the density, and so is what is not given of its cohesion."""
    dense = {"law": "mohr-coulomb", "relative_density": 80.0, "young": 1e8}
    none = dict.fromkeys(("poisson", "density", "friction_angle", "dilation_angle", "cohesion"))
    own, = texts(material=none | dense | {"friction_angle": 30.0, "cohesion": 1e4})
    assert "dilation is below its friction" in own
    preset, = texts(material=none | dense)
    assert "cells of 0.125 m wide" in preset


def texts(limit=footing_cells.cohesive_strips, **table):
    return limit_texts(limit, strip(**table))


def test_a_strip_on_soil_with_cohesion_and_friction():
    text, = texts()
    assert "base 8 cells of 0.125 m wide" in text and "(N_c) is about 18% too high, limit 10%" in text
    enough = float(re.search(r"at most ([\d.]+) m", text)[1])
    assert footing_cells.strip_excess(20.0, 1.0 / enough) == pytest.approx(0.1, abs=0.004)
    assert "about 11%" in texts(friction=0.0)[0] and len(texts(half=0.46)) == 1


@pytest.mark.parametrize("bottom, count", [(-0.5, 0), (-1.75, 1)])
def test_one_that_is_punched_through_into_clay(bottom, count):
    """Half a width below it; 1.75 widths below it counts no more."""
    described = strip()
    clay = Layer("clay", bottom, law="von-mises", material={"strength": 1e4})
    layered = replace(described, soil=replace(described.soil, layers=(clay,)))
    assert len(limit_texts(footing_cells.cohesive_strips, layered)) == count


def test_one_on_soil_that_dilates_less_and_one_that_goes_far():
    """5 mm of 1 m, E/c = 10⁴, and ten times as stiff: 34 B c N_c/E."""
    text, = texts(material={"dilation_angle": 0.0})
    assert "(N_c of 18.9 degrees, as its dilation is below its friction) is about 12% too high, limit" in text
    stiffer = {"young": None, "reference_young": 1e9, "stiffness_exponent": 0.5}     # with its stress, not one number
    assert "end of its travel" not in texts(material=stiffer, gravity=(0.0, 0.0, -9.81))[0]
    text, = texts(material={"young": 1e9})
    assert "(N_c) is about 27% too high at the end of its path, with which that rises, limit 10%" in text


def test_one_that_a_stage_loads_and_one_on_soil_with_weight():
    force = Load(force=((0.0, 0.0, 0.0, 0.0), (5.0, 0.0, 0.0, -1e5)))
    text, = texts(driven=(), held=("x", "y", "rx", "ry", "rz"), velocity=(0.0, 0.0, 0.0), loads=(force,))
    assert "settlement under lower loads is within 5 %" in text and "settlement" not in texts()[0]
    assert len(texts(gravity=(0.0, 0.0, -9.81))) == 1


@pytest.mark.parametrize("size, found", [(1 / 16, 0.29), (1 / 32, 0.18)])
def test_an_inclined_load_has_the_excess_of_a_combined_one(size, found):
    """V = 0.8 of its limit, then along x by a force, or driven: what slip lines have, with 16 and 32 cells."""
    excess = footing_cells.strip_excess(20.0, 1 / size, 1.0, 1.0)
    assert footing_cells.COMBINED * excess == pytest.approx(found, abs=0.06)
    down = Load(force=((0.0, 0.0, 0.0, 0.0), (5.0, 0.0, 0.0, -1e5)))
    along = Load(force=((0.0, 0.0, 0.0, 0.0), (5.0, 2e4, 0.0, -1e5)))
    free = {"held": ("y", "rx", "ry", "rz"), "velocity": (0.0, 0.0, 0.0), "driven": ()}
    pushed = {**free, "driven": ("x",), "velocity": (0.001, 0.0, 0.0)}
    for table, load in ((free, along), (pushed, down)):
        described = strip(**table, loads=(load,))
        grid = replace(described.grid, x=Axis(start=-2.0, end=2.0, size=size), z=replace(described.grid.z, size=size))
        text, = limit_texts(footing_cells.cohesive_strips, replace(described, grid=grid))
        assert "the horizontal one that it carries is up to" in text and f"N_c is by {excess:.0%}" in text
        assert "within 5 %" not in text


def test_one_that_is_loaded_beside_its_middle_stands_on_fewer_cells():
    """On B - 2 e: 5 of 8 cells, and so half as much more."""
    def loaded(x):
        load = Load(point=(x, 0.0, 0.0), force=((0.0, 0.0, 0.0, 0.0), (5.0, 0.0, 0.0, -1e5)))
        free = strip(driven=(), held=("y", "rx", "rz"), velocity=(0.0, 0.0, 0.0), loads=(load,))
        grid = replace(free.grid, x=Axis(start=-2.0, end=2.0, size=0.125))
        text, = limit_texts(footing_cells.cohesive_strips, replace(free, grid=grid))
        return text

    assert "base 8 cells" in loaded(0.0) and "about 18% too high" in loaded(0.0)
    assert "base 5 cells" in loaded(0.1875) and "about 25% too high" in loaded(0.1875)


@pytest.mark.parametrize("motion", [{"velocity": -0.001}, {"displacement": ((0.0, 0.0), (2.0, -0.005), (5.0, 0.0))}])
def test_one_that_a_stage_drives(motion):
    """All the travel, or there and back."""
    described = strip(driven=(), held=("x", "y", "rx", "ry", "rz"), velocity=(0.0, 0.0, 0.0))
    motions = (Motion(component="z", **motion),)
    simulation = build(replace(described, stages=(replace(described.stages[0], motions=motions),)))
    text, = footing_cells.cohesive_strips(simulation.scene, simulation.model)
    assert text == texts()[0]


@pytest.mark.parametrize("table", [
    {"half": 1.2}, {"velocity": (0.0, 0.0, 0.001)}, {"rest_on": -1.5},
    {"gravity": (0.0, 0.0, -9.81), "material": {"cohesion": 100.0}},
    {"material": CLAY}])
def test_other_strips(table):
    """On cells small enough, lifted, deep in the soil, on sand with hardly any cohesion, on clay."""
    assert not texts(**table)


@pytest.mark.parametrize("growth, n, found", [
    (0, 8, 7.1), (0, 16, 3.7), (0, 32, 2.0), (1, 8, 9.3), (1, 16, 5.0), (1, 32, 2.7), (2, 8, 10.4), (2, 16, 5.6),
    (2, 32, 3.1), (5, 8, 13.7), (5, 16, 6.9), (5, 32, 3.9)])
def test_the_law_of_clay_whose_strength_grows_is_what_was_measured(growth, n, found):
    """Smooth strips, k B/s_u = growth, n cells in the width, excess [%] over slip lines."""
    law = 2 * cells.EDGE / n * (1.0 + cells.GROWTH * growth**cells.GROWING)
    assert found == pytest.approx(100 * law, abs=0.7)


@pytest.mark.parametrize("gradient, words", [(0.0, ""), (2e4, "up to 11% too high"), (2e6, "up to 27% too high")])
def test_a_strip_on_clay_whose_strength_grows_with_depth(gradient, words):
    """No note for uniform clay, 7.5 %."""
    found = texts(cells.few_cells, material=CLAY | {"strength_gradient": gradient})
    assert len(found) == bool(words) and all(words in text and "as its strength grows" in text for text in found)


@pytest.mark.parametrize("depth, angle, n, found", [
    (1, 30, 8, 1.281), (1, 30, 16, 1.146), (2, 30, 4, 1.332), (2, 30, 8, 1.160), (2, 30, 16, 1.076), (4, 30, 8, 1.112),
    (2, 40, 8, 1.132)])
def test_the_law_of_plates_lifted_out_of_sand_is_what_was_measured(depth, angle, n, found):
    """Over γ H (B + H tan φ), ψ = φ."""
    slope = footing_cells._slope(angle, angle)
    assert slope == pytest.approx(np.tan(np.radians(angle)))
    assert found - 1 == pytest.approx(footing_cells.LIFTED / n / (1 + depth * slope), abs=0.045)


@pytest.mark.parametrize("depth, dilation, n, found", [
    (2, 0, 4, 1.49), (2, 0, 8, 1.177), (2, 0, 16, 1.139), (1, 0, 8, 1.212), (2, 15, 8, 1.231)])
def test_and_of_those_in_sand_that_dilates_less(depth, dilation, n, found):
    """Over γ H (B + s H), φ = 30°; over γ H (B + H tan φ) it is 0.86 with ψ = 0, H/B = 2 and n = 8."""
    law = footing_cells.LIFTED / n / (1 + depth * footing_cells._slope(30, dilation))
    assert found - 1 == pytest.approx(law, abs=0.08)
    assert footing_cells._slope(30, 0) == pytest.approx(0.5 * np.tan(np.pi / 6))


SAND = {"law": None, "cohesion": 0.0, "dilation_angle": 0.0, "friction_angle": 30.0}
LIFT = {"limit": footing_cells.lifted, "gravity": (0.0, 0.0, -9.81), "velocity": (0.0, 0.0, 0.001), "rest_on": -1.5,
        "material": SAND}


def test_a_plate_lifted_out_of_sand():
    """Half of one 1 m wide with its top at a depth of 1 m, ψ = 0: 3 cells of 0.125 m over 1.289 m."""
    text, = texts(**LIFT)
    assert "8 cells of 0.125 m wide, 1 m under the ground" in text
    assert "about 29% too high, limit 10%, over γ H (B + 0.29 H)" in text
    assert "at most 0.043 m" in text
    density = {name: None for name in ("young", "poisson", "density", *SAND)} | {"relative_density": 38.0}
    assert "too high" in texts(**LIFT | {"material": density})[0]


def test_what_cohesion_adds_to_a_lifted_plate_and_which_load_is_meant():
    """2 c cos φ H of soil that keeps its volume, which cells do not change: 0.104 m of sand of 1700 kg/m³. Drawn obliquely,
    the load of an upright way is not named."""
    clayey = SAND | {"cohesion": 1e3, "density": 1700.0}
    text, = texts(**LIFT | {"material": clayey})
    assert "about 27% too high" in text and "over γ H (B + 0.29 H) + 0.1 γ H, that of" in text
    assert not texts(**LIFT | {"material": clayey | {"cohesion": 3e4}})
    dilates = Material("mohr-coulomb", friction_angle=30.0, dilation_angle=30.0, cohesion=1e3, density=2000.0)
    assert footing_cells._bond(dilates, 10.0) == pytest.approx(0.1)
    sand = Material("mohr-coulomb", friction_angle=30.0, dilation_angle=0.0)
    text, = footing_cells._lifted(body("box.geo", {}), 1.0, 1.0, 0.125, sand, plane=True, upright=False, bond=0.0)
    assert "over γ" not in text and "limit 10%, that of a plate 3 cells wider" in text
    few, more = (list(footing_cells._lifted_in_space(body("box.geo", {}), np.array([1.0, 2.0]), 1.0, 0.2, sand, bond))
                 for bond in (0.0, 4.0))
    assert "about 48% too high" in few[0] and not more      # 0.4 (3 + 2 s)/(2 + 3 s + 4/3 s²), s = 0.289


@pytest.mark.parametrize("deep, n, found", [(1.75, 8, (1.19, 1.26)), (1.75, 16, (1.12, 1.16)), (1.0, 8, (1.16, 1.25)),
                                            (2.5, 8, (1.14, 1.27)), (1.25, 12, (1.14, 1.15))])
def test_the_law_of_pipes_lifted_out_of_sand_is_what_was_measured(deep, n, found):
    """Over γ (H D + s H² - π D²/8), φ = 36°, ψ = 6°, friction 0.4, `deep` = H/D."""
    law = 1 + footing_cells.PIPE / n * deep / (deep + footing_cells._slope(36.0, 6.0) * deep**2 - np.pi / 8)
    assert found[0] - 0.04 < law < found[1] + 0.04


@pytest.mark.parametrize("speed, told", [(0.001, True), (-0.001, False)])
def test_a_pipe_lifted_out_of_sand(speed, told):
    """Half of one 1 m wide with its axis 1.25 m deep, ψ = 0: 2 cells of 0.125 m times 1.25 m over 1.309 m². Pressed down."""
    pipe = body("cylinder.geo", {"radius": 0.5, "height": 1.0, "size": 0.1}, position=(0.0, 0.5, -1.25),
                rotation=(1.0, 0.0, 0.0, 90.0), **PUSHED | {"velocity": (0.0, 0.0, speed)})
    described = replace(strip(gravity=LIFT["gravity"], material=SAND), bodies=(pipe,))
    simulation = build(described)
    found = list(footing_cells.lifted(simulation.scene, simulation.model))
    assert len(found) == told
    for text in found:
        assert "8 cells of 0.125 m wide, 1.25 m under the ground" in text and "that of a pipe 2 cells wider" in text
        assert "about 24% too high, limit 10%, over γ (H (D + 0.29 H) - π D²/8)" in text and "at most 0.052 m" in text


@pytest.mark.parametrize("table", [{"velocity": (0.0, 0.0, -0.001)}, {"rest_on": -0.5}, {"gravity": WEIGHTLESS},
                                   {"material": CLAY | {"strength": 1e5}}])
def test_other_plates(table):
    """Pressed down, at the surface, without weight, in clay."""
    assert not texts(**LIFT | table)


def test_check_and_runs_ask_for_it():
    assert set(footing_cells.LIMITS) <= set(LIMITS) and np.isclose(footing_cells.strip_excess(0.0, 1), 0.41)
