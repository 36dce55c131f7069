"""Limit of spheres on elastic soil whose cells do not resolve the contact: the law is what was measured, and only such
spheres have the note."""

from dataclasses import replace

import numpy as np
import pytest

from hybrid.monitors.limits import LIMITS, elastic_cells
from hybrid.scene import Axis, Faces, Grid, Load, Material, Soil, Time
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
    assert elastic_cells.unresolved_contact in LIMITS
