"""Layers that end between lines of the grid: what is told agrees with what was measured."""

import re

import pytest

from hybrid.monitors.limits.layers import off_lines
from hybrid.scene import Axis, Faces, Grid, Layer, Material, Scene, Soil, Stage, Time
from hybrid.setup.build import build


SOFT = Material(law="hencky", young=40e6, poisson=0.3, density=1.0)


def texts(*ends, stiffness=1e6, size=0.25, held=False, lower=-3.0, material=SOFT, seam=None):
    """Of a column of 40 MPa, or a `material`, with one softer layer, or a `seam`, or 10 MPa above that, between these
    heights [m]."""
    names = ("upper", "seam")[2 - len(ends) // 2:]
    layers = tuple(Layer(name, top=ends[2 * i], bottom=ends[2 * i + 1],
                         material=seam or {"young": stiffness if name == "seam" else 10e6}) for i, name in enumerate(names))
    side = Axis(start=0.0, end=1.0, collapsed=True)
    described = Scene(
        name="column", grid=Grid(side, side, Axis(start=-3.0, end=0.25, size=size), Faces(z_min="roller")),
        soil=Soil(material, top=0.0, layers=layers, held=held,
                  lower=(0.0, 0.0, lower),
                  geostatic=False),
        time=Time(1.0, inertia=False), stages=(Stage("one", 1),), gravity=(0.0, 0.0, 0.0))
    simulation = build(described)
    return list(off_lines(simulation.scene, simulation.model))


@pytest.mark.parametrize("ends, measured", [((0.0, -1.1, -1.1, -1.5), 3.21 / 4.03), ((-1.1, -1.3), 0.60 / 2.0)])
def test_the_share_of_the_settlement_is_what_was_measured(ends, measured):
    text, = texts(*ends)
    assert float(re.search(r"settles by (\S+) times", text)[1]) == pytest.approx(measured, abs=0.01)
    assert "Set grid.z.size = 0.05" in text and ("0.125 m thick, 0.2 m given" in text) == (len(ends) == 2)


def test_a_layer_below_the_soil_ends_with_it():
    text, = texts(0.0, -1.1, -1.1, -50.0, lower=-2.0)
    assert "settles by" in text and "thick" not in text


def test_layers_on_lines_or_hardly_different_or_held_are_not_told():
    assert not texts(0.0, -1.0, -1.0, -1.5)
    assert not texts(-1.1, -1.45, stiffness=35e6)
    assert not texts(-1.1, -1.3, held=True)
    assert not texts(-1.1, -1.3, size=0.05)


@pytest.mark.parametrize("top, bottom, ratio", [(-1.0, -1.125, 5.5), (-1.125, -1.375, 5.5), (-1.0, -1.25, None),
                                                (0.0, -0.125, None)])
def test_a_weak_seam_that_fills_no_row_of_cells_is_too_strong(top, bottom, ratio):
    """Of 6 kPa in 60: half a cell, two halves, a whole one, and at the surface, where bodies slide on its points."""
    clay = Material(law="von-mises", young=2e7, poisson=0.49, density=1800.0, strength=6e4)
    found = texts(top, bottom, material=clay, seam={"strength": 6e3})
    assert len(found) == (ratio is not None)
    assert ratio is None or f"sliding along seam meets {ratio} times its strength" in found[0]


def test_friction_counts_under_the_weight_above():
    """A seam of tan φ = 0.2 in sand of 0.8, half a cell."""
    sand = Material(law="mohr-coulomb", young=2e7, poisson=0.3, density=1800.0, friction_angle=38.66, dilation_angle=0.0,
                    cohesion=0.0)
    text, = texts(-1.0, -1.125, material=sand, seam={"friction_angle": 11.31})
    assert 1.8 < float(re.search(r"meets (\S+) times", text)[1]) < 2.7
