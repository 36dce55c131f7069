"""Limits of soil: each warns where the failure study saw the default fail, and not on the safe side of it."""

import re
from dataclasses import replace

import numpy as np
import pytest

from hybrid.monitors.limits import soil, stepping
from hybrid.scene import Axis, Body, Faces, Grid, Layer, Load, Material, Scene, Soil, Stage, Time
from hybrid.setup.build import build
from hybrid.study.failure.registry import MODES
from hybrid.study.scenes import box, soil_scene


ROLLERS = {"y_min": "roller", "y_max": "roller", "x_min": "fixed"}


def warned(limit, material=(), time=(), faces=Faces(), **values):
    """Texts of one limit about a small block of soil."""
    side = Axis(start=0.0, end=2.0, size=1.0)
    m = Material(**{"law": "hencky", "young": 1e6, "poisson": 0.3, "density": 1800.0, **dict(material)})
    scene = Scene(name="block", grid=Grid(side, side, side, faces), soil=Soil(m, **values),
                  time=Time(**{"step": 0.1, **dict(time)}), stages=(Stage("go", 1),))
    return list(limit(scene, build(scene).model))


def test_soil_that_locks_is_reported():
    """Without F-bar; at 0.4 by 6 % and more, at 0.39 by less. Not with the defaults, and not of held soil."""
    (text,) = warned(soil.volumetric_locking, {"poisson": 0.4}, fbar=False)
    assert re.search(MODES["locking"].message, text)
    assert warned(soil.volumetric_locking, fbar=False, layers=(Layer("clay", top=1.0, material={"poisson": 0.49}),))
    assert not warned(soil.volumetric_locking, {"poisson": 0.39}, fbar=False)
    assert not warned(soil.volumetric_locking, {"poisson": 0.49})
    assert not warned(soil.volumetric_locking, {"poisson": 0.49}, fbar=False, held=True)


def slab_notes(width=2.0, held=False, faces=ROLLERS, gravity=(0.0, 0.0, -9.81), bodies=(), force=None, loads=(), **soil_of):
    """Texts about soil 2 m long in y between faces, of cells of 1 m."""
    side = Axis(start=0.0, end=2.0, size=1.0)
    grid = Grid(side, Axis(start=0.0, end=width, size=1.0), side, Faces(**faces))
    material = Material(law="hencky", young=1e6, poisson=0.3, density=1800.0)
    described = Scene(name="block", grid=grid, soil=Soil(material, **{"top": 1.0, **soil_of}, held=held),
                      time=Time(step=0.1), stages=(Stage("go", 1, loads=loads),), gravity=gravity, bodies=bodies)
    return list(soil.slab(described, build(described, body_force=force).model))


def bar(**values):
    return Body(**{"geometry": "box.geo", "density": 1000.0, "position": (1.0, 1.0, 1.25),
                   "parameters": {"length": 1.0, "width": 2.0, "height": 0.5, "size": 5.0}, **values})


def test_a_row_of_single_cells_between_rollers_is_told_to_be_plane_strain():
    (text,) = slab_notes(1.0)
    assert text.startswith("grid.y is one cell between rollers: that is plane strain. Set grid.y.collapsed = true")
    assert not slab_notes(1.0, held=True) and not slab_notes(1.0, faces={"y_max": "fixed", "x_min": "fixed"})


def test_cells_between_rollers_along_which_nothing_varies_are_told_to_be_plane_strain():
    """Along y, and along x where the ground is level; bodies that go from end to end and stay in the plane."""
    (text,) = slab_notes(ground=((0.0, 0.5), (2.0, 1.0)))
    assert "grid.y is 2 cells between rollers, along which nothing varies: that is plane strain" in text
    assert "grid.x" in slab_notes(faces={"y_min": "fixed", "x_min": "roller", "x_max": "roller"})[0]
    assert slab_notes(bodies=(bar(held=("y", "rx", "rz"), velocity=(0.1, 0.0, 0.0)),))
    assert slab_notes(bodies=(bar(held=("y", "rx", "rz")),), loads=(Load("body", force=(0.0, 0.0, -5.0)),))


@pytest.mark.parametrize("varies", [
    {"lower": (0.0, 1.0, 0.0), "geostatic": False}, {"upper": (2.0, 1.0, 1.0), "geostatic": False},
    {"gravity": (0.0, 1.0, -9.81), "geostatic": False}, {"force": lambda time, x: 0.0 * x},
    {"bodies": (bar(parameters={"length": 1.0, "width": 1.0, "height": 0.5, "size": 5.0}),)},
    {"bodies": (bar(velocity=(0.0, 0.1, 0.0)),)}, {"bodies": (bar(spin=(0.1, 0.0, 0.0)),)},
    {"bodies": (bar(rotation=(0.0, 0.0, 1.0, 10.0)),)},
    {"bodies": (bar(),), "loads": (Load("body", force=(0.0, 0.0, -5.0)),)}])
def test_what_varies_along_an_axis_is_no_plane_strain(varies):
    assert not slab_notes(**varies, faces=ROLLERS | {"x_min": "fixed"})


@pytest.mark.parametrize("gravity, count", [((-9.81, 0.0, 0.0), 1), ((3.0, 0.0, -9.81), 0), ((0.0, 0.0, 0.0), 0)])
def test_gravity_along_the_ground_is_reported_where_soil_yields(gravity, count):
    side = Axis(start=0.0, end=2.0, size=1.0)
    for law, strength in (("von-mises", 1e4), ("hencky", None)):
        m = Material(law=law, young=1e6, poisson=0.3, density=1800.0, strength=strength)
        described = Scene(name="block", grid=Grid(side, side, side, Faces()), soil=Soil(m, geostatic=False), gravity=gravity,
                          time=Time(step=0.1), stages=(Stage("go", 1),))
        found = list(soil.turned_gravity(described, build(described).model))
        assert len(found) == count * (law == "von-mises") and all("acts along x" in text for text in found)


def test_domains_that_do_not_follow_the_soil_are_reported():
    (text,) = warned(soil.domain_update, domain="none")
    assert re.search(MODES["domain_gap"].message, text)
    assert not warned(soil.domain_update) and not warned(soil.domain_update, domain="none", held=True)
    assert not warned(soil.domain_update, domain="none", basis="mpm")      # has none


def test_plastic_strain_that_locks_is_reported():
    """Of all plastic laws, without F-bar."""
    clay = {"law": "von-mises", "strength": 2e4}
    (text,) = warned(soil.plastic_locking, clay, geostatic=False, fbar=False)
    assert re.search(MODES["flow_locking"].message, text)
    sand = {"law": "drucker-prager", "friction_angle": 30.0, "dilation_angle": 0.0, "cohesion": 300.0}
    rock = (Layer("rock", top=1.0, law="hencky"),)
    (text,) = warned(soil.plastic_locking, sand, fbar=False, layers=rock)
    assert text.startswith('soil.material.law = "drucker-prager":')
    assert not warned(soil.plastic_locking, clay, geostatic=False) and not warned(soil.plastic_locking, sand)
    assert not warned(soil.plastic_locking, fbar=False)


def test_softening_is_reported():
    """With the slip over which strength is lost: (c - c_r)/H times a cell of 1 m."""
    clay = {"law": "von-mises", "strength": 2e4}
    (text,) = warned(soil.softening, {**clay, "hardening": -1e5, "residual_strength": 1e4}, geostatic=False)
    assert re.search(MODES["softening"].message, text) and "slip of 0.17 m in cells of 1 m" in text
    assert not warned(soil.softening, {**clay, "hardening": 1e5}, geostatic=False)
    assert not warned(soil.softening, clay, geostatic=False) and not warned(soil.softening)
    assert "slips along" not in text
    layer = Layer("peat", top=1.0, material={"hardening": -1e4, "residual_strength": 1e3})
    assert warned(soil.softening, clay, geostatic=False, layers=(layer,))


STATIC = {"inertia": False}


def test_one_point_along_a_cell_is_reported_without_inertia():
    (text,) = warned(stepping.singular_stiffness, time=STATIC, points_per_axis=(2, 1, 2))
    assert re.search(MODES["singular"].message, text)
    assert not warned(stepping.singular_stiffness, time=STATIC)
    assert not warned(stepping.singular_stiffness, points_per_axis=1)


def test_soil_that_nothing_holds_is_reported_without_inertia():
    """By faces of the grid that it does not reach either."""
    free = Faces("free", "free", "free", "roller", "roller")
    (text,) = warned(stepping.singular_stiffness, time=STATIC, faces=free, upper=(2.0, 1.0, 2.0), geostatic=False)
    assert re.search(MODES["singular"].message, text) and "along x, y:" in text
    assert not warned(stepping.singular_stiffness, time=STATIC, faces=Faces("free", "free", "free", "free", "fixed"))
    assert not warned(stepping.singular_stiffness, faces=free)


def test_a_cone_that_is_too_strong_in_plane_strain_is_reported():
    """Where a scene asks for it, with its friction angle there; in space where soil may be sheared in a plane."""
    def of(collapsed, **material):
        side = Axis(start=0.0, end=2.0, size=1.0)
        m = Material(**{"law": "drucker-prager", "relative_density": 38.0, **material})
        grid = Grid(side, Axis(start=0.0, end=1.0, collapsed=True) if collapsed else side, side)
        scene = Scene(name="block", grid=grid, soil=Soil(m, geostatic=False), time=Time(step=0.1), stages=(Stage("go", 1),))
        simulation = build(scene)
        return list(soil.strong_cone(simulation.scene, simulation.model))

    (text,) = of(True, cone="compression")
    assert re.search("50.6 degrees in plane strain.*Leave soil.material.cone out", text)
    (text,) = of(False)
    assert re.search('law = "drucker-prager", in space.*50.6 degrees where it is sheared.*Leave soil.material.law out', text)
    assert not of(False, cone="plane strain") and not of(True) and not of(True, law="willam-warnke")
    arc = {"law": "willam-warnke", "relative_density": None, "young": 1e6, "poisson": 0.3, "density": 1800.0,
           "friction_angle": 33.0, "dilation_angle": 0.0, "cohesion": 0.0}
    (text,) = of(True, **arc)
    assert re.search("friction angle of 36.4 degrees in plane strain, the 33 given.*Leave soil.material.law out", text)
    assert not of(False, **arc) and not of(True, **arc | {"law": "mohr-coulomb"})
    (text,) = of(True, **arc | {"friction_angle": 0.0, "cohesion": 1e4})
    assert "friction angle of 0 degrees" in text and "1.15 of the cohesion" in text
    clay = {"law": "von-mises", "relative_density": None, "young": 1e6, "poisson": 0.3, "density": 1800.0, "strength": 1e4}
    assert len(of(True, **clay, cone="compression")) == 1 and not of(True, **clay)


def test_a_slope_of_sand_that_slides_along_a_plane_is_reported():
    """With ψ = 0 and φ = 35° from 29.8° on (Davis 1968): creeping faster and faster at 33°, at rest at 28°."""
    def of(slope, dilation=0.0, cohesion=0.0, x=4.0):
        sand = Material(law="drucker-prager", young=1e7, poisson=0.3, density=1700.0, friction_angle=35.0,
                        dilation_angle=dilation, cohesion=cohesion)
        fall = x * float(np.tan(np.radians(slope)))
        grid = Grid(Axis(start=0.0, end=6.0, size=1.0), Axis(start=0.0, end=1.0, collapsed=True),
                    Axis(start=-5.0, end=1.0, size=1.0), Faces(z_min="fixed"))
        scene = Scene(name="slope", grid=grid, soil=Soil(sand, top=0.0, ground=((0.0, 0.0), (x, -fall)), geostatic=False),
                      time=Time(step=0.1), stages=(Stage("go", 1),))
        simulation = build(scene)
        return list(soil.steep_slopes(simulation.scene, simulation.model))

    (text,) = of(33.0)
    assert "falls by 33 degrees" in text and "from 29.8 degrees on" in text
    assert not of(28.0) and not of(33.0, dilation=35.0) and not of(33.0, cohesion=5e3) and not of(33.0, x=1.0)


def test_softening_does_not_reach_clay_that_slips_along_a_body():
    clay = Material(law="von-mises", young=5e6, poisson=0.49, density=1600.0, strength=1e4, hardening=-2e4,
                    residual_strength=4e3)
    rock = Material(law="drucker-prager", young=5e6, poisson=0.3, density=1600.0, friction_angle=30.0, dilation_angle=0.0,
                    cohesion=1e4, hardening=-2e4, residual_cohesion=4e3)
    told = ["along box and", "body.adhesion times 0.4,"]
    for values, words, material in (({"adhesion": 1.0}, told, clay), ({}, [], clay), ({"friction": 0.3}, [], rock)):
        block = box(1.0, 1.0, 0.5, name="box", rest_on=0.0, driven=("x",), velocity=(0.1, 0.0, 0.0), **values)
        described = soil_scene([block], time=Time(1.0, inertia=False))
        simulation = build(replace(described, soil=replace(described.soil, material=material)))
        text, = soil.softening(simulation.scene, simulation.model)
        assert all(word in text for word in words) and ("slips along" in text) == bool(words)


SAND = {"law": "mohr-coulomb", "friction_angle": 30.0, "dilation_angle": 0.0, "cohesion": 1e3}


@pytest.mark.parametrize("material, values, told", [
    (SAND, {"upper": (1.0, 2.0, 2.0)}, 1), (SAND, {}, 0),
    (SAND, {"ground": ((0.0, 2.0), (2.0, 0.4)), "geostatic": False}, 1),
    (SAND, {"upper": (1.0, 2.0, 2.0), "faces": Faces(z_min="fixed")}, 0), ({}, {"upper": (1.0, 2.0, 2.0)}, 0),
    (SAND, {"ground": ((0.0, 2.0), (2.0, 1.0)), "geostatic": False}, 0),
    (SAND, {"upper": (1.0, 2.0, 2.0), "lower": (0.0, 0.0, 1.0)}, 0)])
def test_soil_that_can_spread_on_a_base_without_friction_is_reported(material, values, told):
    """Not where it fills the grid, lies deep under a slope, is elastic, or does not reach the base."""
    found = warned(soil.smooth_base, material, **values)
    assert len(found) == told and all("a roller (grid.faces.z_min)" in text for text in found)
