"""Shapes that break contact: thin plates, blades, edges, tips, facets much finer or coarser than the soil's points.

Bodies are driven into the soil, so their overlap is known and the force has a closed form, ∫ p_f E g dA. Corners of the
soil lie 0.1 m apart, contact points on faces 0.025 m.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from hybrid.contact import contact_pair
from hybrid.scene import Body, Time
from hybrid.setup.build import build
from hybrid.study.scenes import driven, soil_scene, steel

YOUNG, STEP = 1e6, 0.01
PENALTY = 50.0      # [1/m]
PLACES = pytest.mark.parametrize("contact", ["corners", "faces"])


def pressed(body, steps=1, held=True, **scene):
    """Contact forces (steps, 3) [N] on a body that goes down 10 mm a step from the surface z = 0."""
    body = replace(body, rest_on=0.0, velocity=(0.0, 0.0, -1.0), driven=("x", "y", "z"), held=("rx", "ry", "rz"))
    simulation = build(soil_scene([body], held=held, steps=steps, young=YOUNG,
                                  time=Time(step=STEP, inertia=not held or scene.pop("inertia", True)), **scene))
    return np.array([record.bodies[0].contact_force for record in simulation.steps()])


def lift(body, steps=1, **scene):
    """Vertical forces (steps,) in units of p_f E [m³] = area times overlap."""
    return pressed(replace(body, penalty=PENALTY), steps, **scene)[:, 2] / (PENALTY * YOUNG)


@pytest.fixture
def forgetful(monkeypatch):
    """Corners that do not remember from which side they came."""
    remembering = contact_pair.find_contact_points

    def find_contact_points(*given):
        corners = remembering(*given)
        return replace(corners, side=np.zeros_like(corners.side))

    monkeypatch.setattr(contact_pair, "find_contact_points", find_contact_points)


# ------------------------------------------------------------------ thin plates


@PLACES
def test_a_plate_pressed_deeper_than_its_thickness(geometry, contact):
    """A plate of 40 mm on a column of height H, quasi-static, p_f H = 0.02, down to an overlap g of 88 mm:

    p_f E g = -E ln λ / λ,  λ = 1 - (d - g)/H,  d the way of the plate, which covers the column.
    Measured within 1e-4.
    """
    H, p = 0.4, 0.05
    plate = driven(0.6, 0.6, 0.04, velocity=(0.0, 0.0, -1.0), position=(0.2, 0.2, 0.0), rest_on=0.0,
                   penalty=p, contact=contact)
    simulation = build(soil_scene([plate], x=(0.0, 0.4), y=(0.0, 0.4), z=(-H, 0.4), steps=9, young=YOUNG,
                                  time=Time(step=STEP, inertia=False)))
    for record in simulation.steps():
        d = STEP * record.step
        g = brentq(lambda g: p * g + np.log(1 - (d - g) / H) / (1 - (d - g) / H), 0.0, d)
        assert record.bodies[0].contact_force[2] == pytest.approx(p * YOUNG * g * 0.16, rel=2e-4)
        assert record.rejections == 0
    assert g > 0.08


DEPTHS = STEP * np.arange(1, 14)


def test_a_plate_keeps_its_soil_up_to_the_rim(geometry):
    """Plate of 40 mm and 0.3 m on nine sites: F = p_f E g A for g up to 90 mm, also 50 mm from its rim."""
    plate = steel(0.3, 0.3, 0.04, position=(0.4, 0.4, 0.0), contact="corners")
    np.testing.assert_allclose(lift(plate, 9), DEPTHS[:9] * 0.09, rtol=1e-9)


def test_what_is_nearer_to_the_rim_than_deep_is_pushed_sideways(geometry):
    """The same on faces: the outermost of twelve rows is 12.5 mm from the rim, whose side is nearer than the bottom
    from the second step on. The others keep their side however deep they are."""
    plate = steel(0.3, 0.3, 0.04, position=(0.4, 0.4, 0.0), contact="faces")
    area = np.where(DEPTHS[:9] < 0.0125, 0.3**2, 0.25**2)
    np.testing.assert_allclose(lift(plate, 9), DEPTHS[:9] * area, rtol=1e-9)


def test_without_memory_of_the_side_the_force_flips(geometry, forgetful):
    """The same plate on corners: beyond half of its thickness contact would pull it into the soil."""
    plate = steel(0.3, 0.3, 0.04, position=(0.4, 0.4, 0.0), contact="corners")
    force = lift(plate, 4)
    assert force[0] == pytest.approx(STEP * 0.09) and force[2] < -0.5 * STEP * 0.09 and abs(force[3]) < 1e-15


def test_a_blade_pushes_down_what_is_under_its_edge(geometry):
    """On corners: a wall of 40 mm driven edge-down along a row of three sites: F = p_f E g A up to half its thickness;
    beyond that its walls are nearer and part the soil."""
    blade = steel(0.04, 0.3, 0.3, position=(0.4, 0.4, 0.0), contact="corners")
    force = lift(blade, 3)
    np.testing.assert_allclose(force[:1], DEPTHS[:1] * 0.03, rtol=1e-9)
    assert abs(force[2]) < 1e-9


def test_a_blade_presses_soft_ground_until_its_walls_are_nearer(geometry):
    """Driven into elastic soil, p_f E = 50 E/m, 10 mm a step: the lift grows while the overlap g and a step stay below
    half the thickness; measured g = 9 mm after 60 mm. From there on the walls part the row of soil. The first contact
    lets the soil swing."""
    g = lift(steel(0.04, 0.3, 0.3, position=(0.4, 0.4, 0.0), contact="corners"), 5, held=False) / 0.03
    assert (np.diff(g[1:]) > 0).all() and g[-1] > 2 * g[0] and 0.005 < g[-1] < 0.02


# ------------------------------------------------------------------ sharp edges and tips between corners

OFF = (0.45, 0.45, 0.0)   # in the middle between rows of corners
TIP = float(np.degrees(np.arccos(1 / np.sqrt(3))))
SHARP = {"edge": (0.0, 1.0, 0.0, 45.0), "tip": (1.0, -1.0, 0.0, TIP)}


def sharp(shape, contact):
    """A cube of 0.3 m on its edge or corner."""
    return steel(0.3, 0.3, 0.3, position=OFF, rotation=SHARP[shape], contact=contact)


@pytest.mark.parametrize("shape", SHARP)
def test_bodies_that_fit_between_corners(geometry, shape):
    """Corners are silent until the flanks reach them, 50 mm to either side; points on faces, 12.5 mm beside an edge,
    resist once it is deeper than that."""
    assert (lift(sharp(shape, "corners"), 3) == 0.0).all()
    force = lift(sharp(shape, "faces"), 4)
    assert force[0] == 0.0 and (np.diff(force[1:]) > 0.0).all() and force[2] > 0.0


def test_an_edge_on_faces_has_the_pressure_on_its_projected_area(geometry):
    """p_f E L d² cos 45°/2 for a depth d: overlap normal to the flanks, area projected on them. Points 25 mm apart
    integrate it within 1 % at d = 50 mm; where the edge reaches upright faces between domains these add to it."""
    edge = steel(0.3, 1.0, 0.3, position=(0.45, 0.4, 0.0), rotation=SHARP["edge"])      # over all of 0.8 m
    assert lift(edge, 5)[4] == pytest.approx(0.8 * np.sqrt(0.5) * DEPTHS[4]**2 / 2, rel=0.02)


# ------------------------------------------------------------------ no contact counted twice


@PLACES
@pytest.mark.parametrize("height", [0.04, 0.3])
def test_a_flat_box_on_flat_soil_costs_its_footprint_once(geometry, contact, height):
    """F = p_f E g A to round-off where the soil goes on around the box, whatever the walls' height."""
    flat = steel(0.3, 0.3, height, position=(0.4, 0.4, 0.0), contact=contact)
    assert lift(flat) == pytest.approx(STEP * 0.09, rel=1e-9)


@PLACES
def test_a_box_that_covers_all_the_soil(geometry, contact):
    """A is then the area of the soil."""
    flat = steel(1.0, 1.0, 0.3, size=0.06, position=(0.4, 0.4, 0.0), contact=contact)
    assert lift(flat) == pytest.approx(STEP * 0.64, rel=1e-9)


# ------------------------------------------------------------------ facets finer and coarser than the soil


@PLACES
def test_facets_of_a_flat_plate_do_not_matter(geometry, contact):
    """A 20th of a cell, or the whole side of 20 cells: the same force, p_f E g A."""
    fine, coarse = (steel(edge, edge, 0.04, size=size, position=(x, x, 0.0), contact=contact)
                    for edge, size, x in ((0.3, 0.01, 0.4), (4.1, 10.0, 2.1)))
    assert lift(fine)[0] == pytest.approx(STEP * 0.3**2, rel=1e-9)
    wide = {"x": (0.0, 4.2), "y": (0.0, 4.2), "z": (-0.2, 0.2)}
    assert lift(coarse, **wide)[0] == pytest.approx(STEP * 4.1**2, rel=1e-9)


def test_a_finely_faceted_sphere_over_coarse_soil(geometry):
    """r = 0.25 m over the middle of four corners 0.1 m apart: they are met from d = r - √(r² - s²/2) = 10.2 mm on.

    Faces feel p_f E ∫ g N_z² dA = 2π p_f E r³ c² (c - 1 - ln c), c = 1 - d/r, and upright faces between domains add to
    it as the overlap grows: measured 0.5, 2.8 and 4.9 %.
    """
    def ball(contact):
        return Body(geometry=geometry / "sphere.geo", density=3000.0, position=OFF, contact=contact,
                    parameters={"radius": 0.25, "size": 0.02, "growth": 0.5})

    c = 1 - DEPTHS[:3] / 0.25
    smooth = 2 * np.pi * 0.25**3 * c**2 * (c - 1 - np.log(c))
    on_corners, on_faces = lift(ball("corners"), 3), lift(ball("faces"), 3)
    assert on_corners[0] == 0.0 and on_corners[1] > 0.0
    excess = on_faces / smooth - 1
    assert (np.abs(excess) < [0.01, 0.04, 0.06]).all() and (np.diff(excess) > 0.0).all()
