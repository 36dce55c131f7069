"""Layers that end between lines of the grid: what is told agrees with what was measured."""

import re

import pytest

from hybrid.monitors.limits.layers import off_lines
from hybrid.scene import Axis, Faces, Grid, Layer, Material, Scene, Soil, Stage, Time
from hybrid.setup.build import build


def texts(*ends, stiffness=1e6, size=0.25, held=False, lower=-3.0):
    """Of a column of 40 MPa with one softer layer, or 10 MPa above that, between these heights [m]."""
    names = ("upper", "seam")[2 - len(ends) // 2:]
    layers = tuple(Layer(name, top=ends[2 * i], bottom=ends[2 * i + 1],
                         material={"young": stiffness if name == "seam" else 10e6}) for i, name in enumerate(names))
    side = Axis(start=0.0, end=1.0, collapsed=True)
    described = Scene(
        name="column", grid=Grid(side, side, Axis(start=-3.0, end=0.25, size=size), Faces(z_min="roller")),
        soil=Soil(Material(law="hencky", young=40e6, poisson=0.3, density=1.0), top=0.0, layers=layers, held=held,
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
