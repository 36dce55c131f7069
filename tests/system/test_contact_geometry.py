"""Shapes that break contact: thin plates, blades, edges, tips, facets much finer or coarser than the soil's points.

Bodies are driven into the soil, so their overlap is known and the force has a closed form, ∫ p_f E g dA. Corners of the
soil lie 0.1 m apart.
"""

from dataclasses import replace

import numpy as np
import pytest
from scenes import box, driven, soil_scene
from scipy.optimize import brentq

from hybrid.build import build
from hybrid.contact import pair
from hybrid.scene import Body, Time

YOUNG, STEP = 1e6, 0.01


def pressed(body, steps=1, held=True, **scene):
    """Contact forces (steps, 3) [N] on a body that goes down 10 mm a step from the surface z = 0."""
    body = replace(body, rest_on=0.0, velocity=(0.0, 0.0, -1.0), driven=("x", "y", "z"), held=("rx", "ry", "rz"))
    simulation = build(soil_scene([body], held=held, steps=steps, young=YOUNG,
                                  time=Time(step=STEP, inertia=not held or scene.pop("inertia", True)), **scene))
    return np.array([record.bodies[0].contact_force for record in simulation.steps()])


def lift(body, steps=1, **scene):
    """Vertical forces (steps,) in units of p_f E [m³] = area times overlap."""
    return pressed(body, steps, **scene)[:, 2] / (body.penalty * YOUNG)


@pytest.fixture
def forgetful(monkeypatch):
    """Corners that do not remember from which side they came."""
    remembering = pair.find_corners

    def find_corners(*given):
        corners = remembering(*given)
        return replace(corners, side=np.zeros_like(corners.side))

    monkeypatch.setattr(pair, "find_corners", find_corners)


# ------------------------------------------------------------------ thin plates


def test_a_plate_pressed_deeper_than_its_thickness(geometry):
    """A plate of 40 mm on a column of height H, quasi-static, p_f H = 0.02, down to an overlap g of 88 mm:

    p_f E g = -E ln λ / λ,  λ = 1 - (d - g)/H,  d the way of the plate. Measured within 1e-4; the plate covers the column.
    """
    H, p = 0.4, 0.05
    plate = driven(geometry, 0.6, 0.6, 0.04, velocity=(0.0, 0.0, -1.0), position=(0.2, 0.2, 0.0), rest_on=0.0, penalty=p)
    simulation = build(soil_scene([plate], x=(0.0, 0.4), y=(0.0, 0.4), z=(-H, 0.4), steps=9, young=YOUNG,
                                  time=Time(step=STEP, inertia=False)))
    for record in simulation.steps():
        d = STEP * record.step
        g = brentq(lambda g: p * g + np.log(1 - (d - g) / H) / (1 - (d - g) / H), 0.0, d)
        assert record.bodies[0].contact_force[2] == pytest.approx(p * YOUNG * g * 0.16, rel=2e-4)
        assert record.rejections == 0
    assert g > 0.08


DEPTHS = STEP * np.arange(1, 10)
SHARES = pytest.mark.parametrize("second_pass", [0.0, 0.5, 1.0])


@SHARES
def test_a_plate_keeps_its_soil_up_to_the_rim(geometry, second_pass):
    """Plate of 40 mm and 0.3 m on nine sites: F = p_f E g A for g up to 90 mm, also 50 mm from its rim."""
    plate = box(geometry, 0.3, 0.3, 0.04, position=(0.4, 0.4, 0.0), second_pass=second_pass)
    np.testing.assert_allclose(lift(plate, 9), DEPTHS * 0.09, rtol=1e-9)


def test_without_memory_of_the_side_the_force_flips(geometry, forgetful):
    """The same plate: from half its thickness on it would be drawn into the soil."""
    force = lift(box(geometry, 0.3, 0.3, 0.04, position=(0.4, 0.4, 0.0)), 4)
    assert force[0] == pytest.approx(STEP * 0.09) and force[2] < -0.5 * STEP * 0.09 and force[3] == 0.0


def test_a_blade_stays_on_the_soil_under_its_edge(geometry):
    """A wall of 20 mm driven edge-down along a row of three sites, with 10 mm to either side: F = p_f E g A."""
    blade = box(geometry, 0.02, 0.3, 0.3, position=(0.4, 0.4, 0.0))
    np.testing.assert_allclose(lift(blade, 9), DEPTHS * 0.03, rtol=1e-9)


def test_without_memory_a_blade_cuts_as_if_there_were_no_soil(geometry, forgetful):
    force = lift(box(geometry, 0.02, 0.3, 0.3, position=(0.405, 0.4, 0.0)), 3)
    assert abs(force[2]) < 0.1 * DEPTHS[2] * 0.03
