"""A block with a V-shaped notch: its mass, signed distances around the concave edge, and soil pressed into it."""

import numpy as np
import pytest

from hybrid.body import mass, mesh
from hybrid.body.closest import closest, gap_geometry
from hybrid.body.surface import build_surface
from hybrid.runtime.errors import StepError
from hybrid.scene import Body, Faces, Time
from hybrid.setup.build import build
from hybrid.step import soil_terms
from hybrid.study.scenes import soil_scene

SIZES = {"length": 1.0, "width": 0.8, "height": 0.6, "mouth": 0.6, "size": 0.3}
PENALTY = 50.0  # [1/m]
ANGLES = pytest.mark.parametrize("angle", [60.0, 90.0, 150.0])


def notched(geometry, angle):
    """Mesh of the block, half the angle [rad] of the notch, its depth [m]."""
    half = np.radians(angle / 2)
    depth = SIZES["mouth"] / 2 / np.tan(half)
    return mesh.generate(geometry / "notched_block.geo", {**SIZES, "angle": angle}), half, depth


@ANGLES
def test_mass_is_that_of_a_box_less_a_prism(geometry, angle):
    """Prism of base b, depth h, width w: m = ρ b h w/2, its centre h/3 above the base, and about that centre
    I = m [w²/12 + h²/18, h²/18 + b²/24, b²/24 + w²/12]."""
    body, _, h = notched(geometry, angle)
    a, w, c, b = (SIZES[name] for name in ("length", "width", "height", "mouth"))
    whole, gone = 2000 * a * w * c, 2000 * b * h * w / 2
    below = -c / 2 + h / 3
    centre = np.array([0.0, 0.0, -gone * below / (whole - gone)])
    inertia = whole / 12 * np.diag([w**2 + c**2, a**2 + c**2, a**2 + w**2])
    inertia -= gone * np.diag([w**2 / 12 + h**2 / 18, h**2 / 18 + b**2 / 24, b**2 / 24 + w**2 / 12])
    inertia -= gone * below**2 * np.diag([1.0, 1.0, 0.0])
    inertia -= (whole - gone) * centre[2] ** 2 * np.diag([1.0, 1.0, 0.0])
    found = mass.condensed_mass(body, 2000.0)
    assert found.mass == pytest.approx(whole - gone, rel=1e-12)
    np.testing.assert_allclose(found.centre, centre, atol=1e-12)
    np.testing.assert_allclose(found.inertia, inertia, atol=1e-10 * whole)


@ANGLES
def test_signed_distance_around_the_concave_edge(geometry, angle):
    """In the notch the gap is the distance to the nearer flank, along its normal (±cos, 0, -sin) of half the angle; in
    the solid above the edge, between the flanks' normals, it is minus the distance to the edge. Across the middle
    plane the normal jumps from one flank to the other, the gap does not."""
    body, half, depth = notched(geometry, angle)
    tree = build_surface(body.points, body.contact).tree
    edge = -SIZES["height"] / 2 + depth
    rng = np.random.default_rng(0)
    for _ in range(400):
        x, y, down = rng.uniform(-1, 1), rng.uniform(-0.3, 0.3), rng.uniform(0.01, 0.3) * depth
        place = np.array([x * 0.98 * down * np.tan(half), y, edge - down])   # in the void
        triangle, feature, closest_point, weights, gap = closest(place, np.inf, tree)
        assert gap == pytest.approx(down * np.sin(half) - abs(place[0]) * np.cos(half), abs=1e-12)
        normal, _, _ = gap_geometry(place, closest_point, weights, gap, triangle, feature, tree)
        np.testing.assert_allclose(normal, [-np.sign(x) * np.cos(half), 0.0, -np.sin(half)], atol=1e-9)
        turn = x * (np.pi / 2 - half) * 0.98
        up = 0.1 * down * np.array([np.sin(turn), 0.0, np.cos(turn)])
        assert closest(np.array([0.0, y, edge]) + up, np.inf, tree)[4] == pytest.approx(-0.1 * down, abs=1e-12)


def pressing(geometry, height, steps):
    """Simulation of a notch of 90° driven down, 10 mm a step, over a free column 0.4 m wide; it meets the
    column's edges when it was put down from `height` to 0.2 m."""
    block = Body(geometry=geometry / "notched_block.geo", density=2000.0, position=(0.0, 0.1, height),
                 parameters={**SIZES, "angle": 90.0}, velocity=(0.0, 0.0, -1.0), driven=("x", "y", "z"),
                 held=("rx", "ry", "rz"), contact="corners", penalty=PENALTY)
    return build(soil_scene(
        [block], x=(-0.6, 0.6), y=(0.0, 0.2), lower=(-0.2, 0.0, -0.4), upper=(0.2, 0.2, 0.0), poisson=0.2, steps=steps,
        faces=Faces("free", "free", "roller", "roller", "fixed", "free"), time=Time(step=0.01, inertia=False)))


def test_soil_pressed_into_the_notch(geometry):
    """Driven 0.2 m, 5 mm of it before the flanks are met.

    Both flanks push, towards the middle: normals (±1, 0, -1)/√2 only, as many of one as of the other, and side forces
    that cancel. No corner leaks or flips: the lift grows, and is twice the penalty p_f E A/4 Σ g on one flank times
    1/√2. Measured: 26 kN, overlap 30 mm, no increment halved.
    """
    simulation = pressing(geometry, 0.205, 20)
    lifts = []
    for record in simulation.steps():
        contact = simulation.evaluation.contacts[0]
        left = contact.normal[:, 0] > 0
        assert record.rejections == 0 and 2 * left.sum() == len(contact) >= 8
        flank = np.stack([np.where(left, 1, -1), 0 * left, -np.ones(len(left))], axis=1)
        np.testing.assert_allclose(contact.normal, flank / np.sqrt(2), atol=1e-9)
        fx, _, fz = record.bodies[0].contact_force
        assert abs(fx) < 1e-6 * fz
        stiffness = PENALTY * 1e6 * 0.1**2 / 4
        assert fz == pytest.approx(-2 * stiffness * contact.gap[left].sum() / np.sqrt(2), rel=1e-6)
        lifts.append(fz)
    assert (np.diff(lifts) > 0).all() and lifts[-1] > 2e4


def test_a_touch_of_round_off_is_no_residual(geometry, monkeypatch):
    """Put down from 0.4 m the flanks meet the edges after 20 steps to 1e-16 m, with 1e-11 N: nothing to iterate on."""
    records = list(pressing(geometry, 0.4, 20).steps())
    assert 0 < records[-1].bodies[0].overlap < 1e-14 and records[-1].rejections == 0
    monkeypatch.setattr(soil_terms, "ROUNDING", 0.0)
    try:    # rejected until the increment ends short of the contact, or is too short
        assert list(pressing(geometry, 0.4, 20).steps())[-1].rejections > 0
    except StepError as failure:
        assert "step 20 failed" in str(failure)
