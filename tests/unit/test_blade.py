"""The theory that a blade in sand is compared with, and the friction angle of cones in plane strain."""

import numpy as np
import pytest
from scipy.optimize import brentq

from hybrid.laws.cone import plane_strain_strength
from hybrid.laws.drucker_prager import DruckerPrager
from hybrid.laws.willam_warnke import WillamWarnke
from hybrid.study.blade import draft, factors

YOUNG = np.array([1e7])


def coulomb(angle, wall):
    """Coulomb's coefficient of passive pressure on an upright wall: force along its normal and that at the angle of
    friction."""
    phi, delta = np.radians([angle, wall])
    return np.cos(phi) ** 2 / (np.cos(delta) * (1 - np.sqrt(np.sin(phi + delta) * np.sin(phi) / np.cos(delta))) ** 2)


@pytest.mark.parametrize("angle, wall", [(20.0, 0.0), (32.75, 0.0), (32.75, 16.7), (36.0, 10.0)])
def test_without_crescents_the_wedge_is_coulombs(angle, wall):
    n_weight, _, n_surcharge, _ = factors(angle, wall, 0.6)
    assert n_weight == pytest.approx(coulomb(angle, wall) / 2, rel=1e-5)
    assert n_surcharge == pytest.approx(coulomb(angle, wall), rel=1e-5)


def test_smooth_wall_has_rankines_factors():
    root = np.tan(np.radians(45 + 32.75 / 2))
    assert factors(32.75, 0.0, 1.0)[:3] == pytest.approx((root**2 / 2, 2 * root, root**2), rel=1e-5)
    assert factors(32.75, 0.0, 1.0)[3] == pytest.approx(root, rel=1e-2)


def test_draft_grows_with_depth_width_and_heap():
    soil = 16.5e3, 0.0, 33.0
    narrow, wide = draft(soil, 16.7, 0.6, 0.05) / 0.05, draft(soil, 16.7, 0.6, 50.0) / 50.0
    assert narrow > 8 * wide                                # crescents carry a narrow blade
    assert draft(soil, 0.0, 1.2, 1e6) / draft(soil, 0.0, 0.6, 1e6) == pytest.approx(4.0, rel=1e-4)
    assert draft(soil, 0.0, 1.2, 1e-6) / draft(soil, 0.0, 0.6, 1e-6) == pytest.approx(8.0, rel=1e-4)
    assert draft(soil, 16.7, 0.6, 0.8, swept=0.3) > 1.2 * draft(soil, 16.7, 0.6, 0.8)


def test_crescents_are_the_integral_over_their_sectors():
    """Weight of the sectors, each with the force of the wedge in its own direction, summed numerically."""
    depth, width, angle, wall = 0.6, 0.8, 33.0, 12.0
    n_weight, _, _, r = factors(angle, wall, depth, width)
    beta, (phi, delta) = np.arctan(depth / r), np.radians([angle, wall])
    share = 1 / (np.cos(np.pi / 2 + delta) + np.sin(np.pi / 2 + delta) / np.tan(beta + phi))
    turn = (np.arange(2000) + 0.5) * np.pi / 4000
    sectors = 2 * np.sum(depth * r**2 / 6 * np.cos(turn)) * np.pi / 4000
    assert n_weight == pytest.approx(share * (depth * r / 2 * width + sectors) / (depth**2 * width), rel=1e-6)


@pytest.mark.parametrize("law", [
    DruckerPrager(YOUNG, 0.25, 32.75, 0.0, 0.0, "compression"), DruckerPrager(YOUNG, 0.25, 32.75, 8.0, 0.0, "plane strain"),
    WillamWarnke(YOUNG, 0.25, 32.75, 0.0, 0.0), WillamWarnke(YOUNG, 0.25, 40.0, 12.0, 0.0)])
def test_angle_in_plane_strain_is_that_of_a_long_shear(law):
    """Sheared on at a mean stress that is kept, without strain along the thickness."""
    mean, spread = -1e5, np.array([1.0, 0.0, 1.0])
    response = law.respond(np.full((1, 3), mean * (1 - 2 * 0.25) / 1e7))
    for _ in range(600):
        sheared = response.elastic + 1e-4 * np.array([[1.0, 0.0, -1.0]])
        wider = brentq(lambda e: law.respond(sheared + e * spread).stress.mean() - mean, -1e-3, 1e-3, xtol=1e-12)
        response = law.respond(sheared + wider * spread)
    stress = response.stress[0]
    sine = (stress[0] - stress[2]) / -(stress[0] + stress[2])
    assert plane_strain_strength(law.parameters[0])[0] == pytest.approx(np.degrees(np.arcsin(sine)), abs=0.02)


@pytest.mark.parametrize("dilation", [0.0, 2.75, 32.75])
def test_cone_matched_in_plane_strain_is_exact(dilation):
    law = DruckerPrager(YOUNG, 0.25, 32.75, dilation, 0.0, "plane strain")
    assert plane_strain_strength(law.parameters[0])[0] == pytest.approx(32.75, abs=1e-9)
