"""Collapse loads of clay with nothing set but the physics, against exact ones: hybrid/study/plasticity.py.

Cells in half the width or in the radius, excess over the exact load:

    strip     4, 8, 16     7.4, 3.9, 2.2 %     first order
    circle    2, 3, 4, 6   6.6, 1.0, -0.3, -2.4 %

A cylinder that is moved sideways, cells in its diameter:

    smooth            4, 6, 8, 12, 16   18, 8.5, 5.2, 2.9, 1.8 %     second order
    friction of 1     4                 9 %

The nodes at the edge of a rigid footing go down with it, and soil is sheared in the cell beyond. There is no contact within
half a cell of its edge (`hybrid.body.sharp_edges`): without that the circle has 46, 27, 16 % on 2, 3, 4 cells.
"""

import functools

import numpy as np
import pytest
from options import options_set

from hybrid.setup.build import build
from hybrid.soil import fbar
from hybrid.study import plasticity


@functools.cache
def excess(shape, across):
    """Of the load over the exact one, relative to that."""
    exact = plasticity.STRIP if shape == "strip" else plasticity.SMOOTH
    return plasticity.push(shape, across).factor[-1] / exact - 1


@pytest.mark.parametrize("scene", [plasticity.footing("strip", 4), plasticity.footing("circle", 3, 1.0)],
                         ids=["strip", "circle"])
def test_nothing_is_set_but_the_physics(scene):
    assert options_set(scene) == []


def test_the_strip_converges_at_first_order():
    assert np.log2(excess("strip", 4) / excess("strip", 8)) == pytest.approx(0.92, abs=0.1)
    assert 0 < excess("strip", 8) < 0.045


def test_the_load_reaches_a_plateau():
    factor = plasticity.push("strip", 4).factor
    assert factor[-1] / factor[-3] - 1 < 2e-3


@pytest.mark.slow
def test_the_strip_is_within_three_per_cent_on_sixteen_cells():
    assert 0 < excess("strip", 16) < 0.03
    assert np.log2(excess("strip", 8) / excess("strip", 16)) == pytest.approx(0.9, abs=0.15)


@pytest.mark.parametrize("across", [3, pytest.param(4, marks=pytest.mark.slow)])
def test_the_circle_carries_its_load(across, monkeypatch):
    """With a sharp edge it carries 46 % more on two cells, instead of 7 %."""
    assert abs(excess("circle", across)) < 0.03
    if across == 3:
        monkeypatch.setattr("hybrid.setup.contact.round_off", lambda surface, edges: surface)
        assert plasticity.push("circle", 2).factor[-1] / plasticity.SMOOTH - 1 > 0.4


def test_the_cylinder_converges_at_second_order():
    """Errors of 19.8, 9.7 and 5.5 % with 4, 6, 8 cells in 20 steps; its force hardly depends on their number."""
    errors = [np.mean(plasticity.sideways(across, steps=20).factor[-5:]) / plasticity.DEEP - 1 for across in (4, 6)]
    assert np.log(errors[0] / errors[1]) / np.log(1.5) == pytest.approx(1.8, abs=0.25) and 0 < errors[1] < 0.11


@pytest.mark.slow
def test_the_cylinder_is_within_three_per_cent_on_twelve_cells():
    found = [np.mean(plasticity.sideways(12, steps=steps).factor[-5:]) for steps in (40, 80)]
    assert found[0] == pytest.approx(plasticity.DEEP, rel=0.03) and found[1] == pytest.approx(found[0], rel=0.003)


def lost():
    """Soil in the way of a cylinder under a pressure of 60 s_u that the rest does not make room for, as a share of the way:
    what the surface sinks by."""
    simulation = build(plasticity.buried(4, steps=20))
    start, soil = simulation.state.points.position[:, 2].copy(), simulation.model.soil.constants
    upper = soil.position[:, 2] + soil.half_width[:, 2]
    top = upper > upper.max() - 1e-6
    for _ in simulation.steps():
        pass
    sunk = (start - simulation.state.points.position[:, 2])[top]
    return float(sunk @ (2 * soil.half_width[top, 0])) / 0.1


def test_soil_in_cells_that_a_body_cuts_keeps_its_volume(monkeypatch):
    """At the centres of such cells F-bar lets a sixth of it vanish: the pressure then does the work of the cylinder."""
    monkeypatch.setattr(plasticity, "PRESSURE", 60.0)
    assert abs(lost()) < 0.02
    monkeypatch.setattr(fbar, "CUT", np.inf)
    assert lost() > 0.1


def test_friction_alone_takes_no_more_of_the_clay_than_its_strength():
    """A rough cylinder on four cells: 10 % too much, as with an adhesion of 1, and far more where nothing but friction
    limits the shear."""
    assert np.mean(plasticity.sideways(4, friction=1.0, steps=20).factor[-5:]) == pytest.approx(
        1.1 * plasticity.deep_factor(1.0), rel=0.02)
