"""Limits of contact on soil that is elastic or hardly yields: the laws are what was measured, and only spheres and bases
that they are about have the notes."""

from dataclasses import replace

import numpy as np
import pytest

from hybrid.monitors.limits import LIMITS, elastic_cells
from hybrid.scene import Axis, Faces, Grid, Joint, Load, Material, Soil, Stage, Time
from hybrid.setup.build import build
from hybrid.study.random.fresh.problem import PUSHED, WEIGHTLESS, body, scene

SELF = 0.036    # of the excess: strains that are not small, and a block that is not deep


@pytest.mark.parametrize("cells, places", [(0.75, (0.33, 0.47, 0.62)), (1.06, (0.29, 0.25, 0.17)), (1.3, (0.22, 0.17, 0.15)),
                                           (1.5, (0.14, 0.14, 0.16))])
def test_the_law_is_the_worst_place_that_was_measured(cells, places):
    law = np.interp(cells, *np.transpose(elastic_cells.HIGHEST))
    assert max(places) - SELF == pytest.approx(law, abs=0.03)


def texts(depth=0.01, radius=0.5, size=0.1, law="hencky", time=None, loads=(), gravity=WEIGHTLESS,
          file="sphere.geo", **table):
    """Notes about a quarter model of a sphere of 0.5 m that is pressed in by 0.01 m: a contact radius of 0.071 m."""
    side = Axis(start=0.0, end=4 * size, size=size)
    material = Material(law=law, young=1e7, poisson=0.3, density=1800.0, **({"strength": 1e4} if law == "von-mises" else {}))
    values = {"radius": radius, "size": 0.3} | ({} if file == "sphere.geo" else {"height": 2 * radius})
    probe = body(file, values, **{"velocity": (0.0, 0.0, -depth)} | PUSHED | {"rest_on": 0.0} | table)
    described = scene("ball", Grid(side, side, Axis(start=-4 * size, end=size, size=size), Faces(z_min="fixed")),
                      Soil(material, top=0.0, geostatic=False), [probe], time or Time(1.0, inertia=False), 1, gravity)
    simulation = build(replace(described, stages=(replace(described.stages[0], loads=loads),)))
    return list(elastic_cells.unresolved_contact(simulation.scene, simulation.model))


def test_a_sphere_that_is_driven_into_elastic_soil():
    text, = texts(depth=0.03)       # √(0.5 x 0.03) = 0.122 m
    assert "radius of 0.12 m, 1.2 cells of 0.1 m, limit 1.6" in text and "up to 21% above Hertz's" in text
    assert "at most 0.077 m" in text and "sinks in" not in text
    assert "58% above Hertz's, or more" in texts()[0] and not texts(depth=0.06)


FREE = {"driven": (), "held": ("x", "y", "rx", "ry", "rz"), "velocity": (0.0, 0.0, 0.0)}


@pytest.mark.parametrize("table", [{"loads": (Load(force=((0.0, 0.0, 0.0, 0.0), (1.0, 0.0, 0.0, -5e4))),)},
                                   {"gravity": (0.0, 0.0, -9.81), "density": 9000.0}])
def test_one_that_carries_a_load_or_its_weight(table):
    """The radius of contact is that of Hertz."""
    text, = texts(**FREE | table)
    assert "sinks in by up to" in text and "too little" in text and "Use cells of at most" in text


@pytest.mark.parametrize("table", [{"law": "von-mises"}, {"depth": -0.01}, {"file": "cylinder.geo"}, FREE,
                                   {"gravity": (0.0, 0.0, -9.81), "time": Time(0.01)} | FREE])
def test_other_bodies(table):
    """In clay, lifted, with edges, without a load, or that inertia lets rebound."""
    assert not texts(**table)


def test_check_and_runs_ask_for_it():
    assert elastic_cells.unresolved_contact in LIMITS and elastic_cells.soft_springs in LIMITS


@pytest.mark.parametrize("plane_strain, tilted, found", [
    (False, 0, {4: 0.28, 8: 0.14}), (False, 1, {4: 0.66, 8: 0.29}), (True, 0, {4: 0.08, 8: 0.04, 16: 0.02}),
    (True, 1, {4: 0.37, 8: 0.22, 16: 0.15})])
def test_the_law_of_soft_springs_is_what_was_measured(plane_strain, tilted, found):
    for across, excess in found.items():
        assert elastic_cells.SOFT[plane_strain][tilted] / across == pytest.approx(excess, abs=0.05)


def pads(depth=0.0, force=0.0, arm=0.0, size=0.25, law="von-mises", kind="box.geo", **table):
    """Notes about a square or round pad of 2 m on soil with 6 s_u B/E = 24 mm, driven by a `depth` [m] or with a `force`
    [N]."""
    side = Axis(start=-3.0, end=3.0, size=size)
    given = {"strength": 10e3} if law == "von-mises" else {"friction_angle": 30.0, "dilation_angle": 0.0, "cohesion": 5e2}
    soil = Soil(Material(law=law, young=5e6, poisson=0.45, density=1700.0, **given), top=0.0, geostatic=False)
    how = {"velocity": (0.0, 0.0, -depth)} | PUSHED if depth else {"held": ("x", "y", "rx", "rz")}
    shape = {"length": 2.0, "width": 2.0, "height": 0.5, "size": 5.0}
    if kind == "cylinder.geo":
        shape = {"radius": 1.0, "height": 0.5, "size": 0.3}
    pad = body(kind, shape, **{"rest_on": 0.0} | how | table)
    load = Load(force=(0.0, 0.0, -force), point=(arm, 0.0, 0.0))
    described = scene("pad", Grid(side, side, Axis(start=-3.0, end=0.5, size=size), Faces(z_min="fixed")), soil, [pad],
                      Time(1.0, inertia=False), 1, WEIGHTLESS)
    if force:
        described = replace(described, stages=(Stage("load", 1, loads=(load,)),))
    simulation = build(described)
    return list(elastic_cells.soft_springs(simulation.scene, simulation.model))


@pytest.mark.parametrize("inertia, told", [(False, 1), (True, 0)])
def test_a_base_on_which_joints_hand_on_what_others_carry(inertia, told):
    """A pad of 2 m, eight cells, welded to a mast that is loaded; without inertia, where settlement is asked for."""
    side = Axis(start=-3.0, end=3.0, size=0.25)
    soil = Soil(Material(law="von-mises", young=5e6, poisson=0.45, density=1700.0, strength=10e3), top=0.0, geostatic=False)
    pad = body("box.geo", {"length": 2.0, "width": 2.0, "height": 0.5, "size": 5.0}, name="pad", rest_on=0.0)
    mast = body("box.geo", {"length": 0.4, "width": 0.4, "height": 1.0, "size": 5.0}, name="mast", rest_on=0.5)
    grid = Grid(side, side, Axis(start=-3.0, end=0.5, size=0.25), Faces(z_min="fixed"))
    described = scene("mast", grid, soil, [pad, mast], Time(1.0, inertia=inertia), 1, WEIGHTLESS)
    load = Load("mast", force=(0.0, 0.0, -50e3))
    weld = Joint("weld", "weld", ("mast", "pad"), point=(0.0, 0.0, -0.5))
    described = replace(described, joints=(weld,), stages=(Stage("load", 1, loads=(load,)),))
    simulation = build(described)
    found = list(elastic_cells.soft_springs(simulation.scene, simulation.model))
    assert len(found) == told
    assert all(text.startswith("pad") and "settles by about 14% too much" in text for text in found)


def test_a_base_that_soft_springs_let_settle_too_much():
    text, = pads(depth=0.01)
    assert "8 cells of 0.25 m wide" in text and "settles by about 14% too much" in text and "penalty = 2000," in text
    loaded = {"force": 50e3, "law": "mohr-coulomb"}
    assert "settles by about 14%" in pads(**loaded)[0] and "it settles by about 14% and tilts by about 32% too much" in (
        pads(**loaded, arm=0.5)[0])
    assert not pads(depth=0.01, kind="cylinder.geo")    # 8 %
    assert "settles by about 17%" in pads(depth=0.01, kind="cylinder.geo", size=0.5)[0]
    assert "settles by about 17% and tilts by about 65%" in pads(**loaded, arm=0.5, kind="cylinder.geo", size=0.5)[0]
    assert not pads(force=-50e3, law="mohr-coulomb")    # it is lifted
    assert not pads(force=50e3) and not pads(force=150e3) and not pads(depth=0.05)     # clay that bears it; that flows
    assert not pads(depth=0.01, position=(0.0, 0.0, 0.3), rest_on=None)     # it does not reach the ground
    assert not pads(depth=0.01, law="mohr-coulomb") and not pads(depth=0.01, penalty=2e3) and not pads(depth=-0.01)
