"""Interface of clay: every branch of its law against finite differences, its potential, and broken variants.

The notched cube and the torus of helpers/contact_features.py; points outside the surface by half a millimetre pull.
"""

from dataclasses import replace

import numpy as np
import pytest
from contact_features import CENTRE, KIND, RATIO, ROTATION, SHIFT, SURFACE, corners_at, tangent

from hybrid.body.attitude import exp_so3
from hybrid.body.closest import closest
from hybrid.contact import assembly, soil_to_body
from hybrid.contact.interface import PlaceLimits

OUT = 5e-4  # [m] from the surface
# branch: (pulled, μ, shear limit [N], tension limit [N], slips, breaks away)
BRANCHES = {
    "adhesion slips": (False, np.inf, 1.0, 0.0, True, False),
    "adhesion sticks": (False, np.inf, 1e9, 0.0, False, False),
    "friction below adhesion": (False, 0.01, 1e9, 0.0, True, False),
    "adhesion below friction": (False, 50.0, 1.0, 0.0, True, False),
    "bonded, pressed, slips": (False, np.inf, 1.0, 1e9, True, False),
    "pulled, sticks": (True, np.inf, 1e9, 1e9, False, False),
    "pulled, slips": (True, np.inf, 1.0, 1e9, True, False),
    "pulled, friction alone": (True, 0.3, None, 1e9, True, False),
    "pulled, smooth": (True, 0.0, None, 1e9, False, False),
    "breaks away, sticks": (True, np.inf, 1e9, 1.0, False, True),
    "breaks away, slips": (True, np.inf, 1.0, 1.0, True, True),
}
FEATURES = ("face", "curved")


def corners_of(feature, pulled, shear, tension):
    corners = corners_at(feature)
    m = len(corners)
    if pulled:      # from where they are inside, along the normal
        y = corners.start
        closest_point, normal = np.empty((m, 3)), np.empty((m, 3))
        for n in range(m):
            triangle, kind, closest_point[n], weights, gap = closest(y[n], np.inf, SURFACE[feature].tree)
            assert kind in KIND[feature]
            normal[n] = (closest_point[n] - y[n]) / -gap
        out = closest_point + OUT * normal
        corners = replace(corners, start=out, position=CENTRE + out @ ROTATION.T, side=normal,
                          anchor=corners.anchor + out - y)
    limits = PlaceLimits(np.zeros(0) if shear is None else np.full(m, shear),
                         np.full(m, tension) if tension else np.zeros(0), np.zeros(m if tension else 0, bool))
    return replace(corners, limits=limits)


def contact_at(corners, feature, mu, place=None, pose=(CENTRE, ROTATION)):
    place = corners.position if place is None else place
    return soil_to_body.evaluate(corners, place, *pose, SURFACE[feature], mu, RATIO)


def residual(corners, feature, mu, step):
    place = corners.position + step[:-6].reshape(-1, 3)
    contact = contact_at(corners, feature, mu, place, (CENTRE + step[-6:-3], exp_so3(step[-3:]) @ ROTATION))
    assert len(contact) == len(corners)
    return np.concatenate([contact.force.ravel(), assembly.add_residual(contact, corners, None)])


@pytest.mark.parametrize("branch", BRANCHES)
@pytest.mark.parametrize("feature", FEATURES)
def test_branches_are_those_they_are_named_after(feature, branch):
    pulled, mu, shear, tension, slips, breaks = BRANCHES[branch]
    contact = contact_at(corners_of(feature, pulled, shear, tension), feature, mu)
    assert len(contact) and (contact.slip == slips).all() and (contact.opened == breaks).all()
    assert ((contact.pressure < 0.0) == pulled).all()
    if breaks:
        np.testing.assert_array_equal(contact.pressure, -tension)


@pytest.mark.parametrize("branch", BRANCHES)
@pytest.mark.parametrize("feature", FEATURES)
def test_tangent_equals_central_differences(feature, branch):
    pulled, mu, shear, tension, _, _ = BRANCHES[branch]
    corners = corners_of(feature, pulled, shear, tension)
    exact, h = tangent(contact_at(corners, feature, mu)), 1e-6
    columns = [residual(corners, feature, mu, h * e) - residual(corners, feature, mu, -h * e) for e in np.eye(len(exact))]
    error = np.abs(np.array(columns).T / (2 * h) - exact).max() / np.abs(exact).max()
    assert error < 2e-6


@pytest.mark.parametrize("branch, spoilt", [("adhesion slips", "friction below adhesion"),
                                            ("breaks away, sticks", "pulled, sticks")])
def test_the_tangent_of_another_branch_is_found_out(branch, spoilt):
    """One where the limit follows the pressure, or the pressure the gap, though they do not."""
    pulled, mu, shear, tension, _, _ = BRANCHES[branch]
    corners, h = corners_of("face", pulled, shear, tension), 1e-6
    other = tangent(contact_at(corners_of("face", pulled, *BRANCHES[spoilt][2:4]), "face", BRANCHES[spoilt][1]))
    columns = [residual(corners, "face", mu, h * e) - residual(corners, "face", mu, -h * e) for e in np.eye(len(other))]
    assert np.abs(np.array(columns).T / (2 * h) - other).max() / np.abs(other).max() > 1e-3


@pytest.mark.parametrize("branch", ["adhesion sticks", "pulled, sticks", "pulled, smooth"])
def test_force_is_the_gradient_of_the_stored_energy(branch):
    pulled, mu, shear, tension, _, _ = BRANCHES[branch]
    corners, h = corners_of("face", pulled, shear, tension), 1e-6
    contact = contact_at(corners, "face", mu)
    for n in range(len(corners)):
        for i in range(3):
            shift = np.zeros((len(corners), 3))
            shift[n, i] = h
            there, back = (contact_at(corners, "face", mu, corners.position + s * shift).energy for s in (1, -1))
            assert (there - back) / (2 * h) == pytest.approx(contact.force[n, i], rel=1e-6,
                                                             abs=1e-6 * np.abs(contact.force).max())


def test_a_bond_that_breaks_dissipates_what_was_put_into_it():
    """Work ∫ T dg of a point that is pulled from its rest to beyond T, in one step or in many."""
    limit, stiffness = 40.0, 1e5
    for steps in (1, 7):
        corners = replace(corners_of("face", True, None, limit), stiffness=np.full(4, stiffness))
        contact, done = None, 0.0
        for share in np.arange(1, steps + 1) / steps:
            way = share * 2 * limit / stiffness
            normal = corners.side @ ROTATION.T
            base = corners.position - OUT * normal
            contact = contact_at(corners, "face", 0.0, base + way * normal)
            done += contact.dissipated
            if contact.opened.any():
                break
        assert contact.opened.all() and contact.energy == 0.0
        work = limit * (way - 0.5 * limit / stiffness)
        assert done == pytest.approx(4 * work, rel=1e-9)


def test_points_without_a_bond_have_no_shear_without_pressure():
    """As the overlap goes to zero, so does the shear, continuously; far from there it is α s_u a."""
    y, shear = SHIFT + np.array([[-0.5, -0.4, 1.0]]), 3.0
    sizes = []
    for depth in (1e-9, 1e-7, 1e-3):
        corners = replace(corners_at("face", places=y - SHIFT - (0.0, 0.0, depth)),
                          limits=PlaceLimits(np.array([shear]), np.zeros(0), np.zeros(0, bool)))
        contact = contact_at(corners, "face", np.inf)
        sizes.append(np.linalg.norm(contact.force[0] + contact.pressure[0] * contact.normal[0]))
    assert sizes[0] == pytest.approx(1e5 * 1e-9 * 10, rel=1e-6) and sizes[1] == pytest.approx(1e5 * 1e-7 * 10, rel=1e-6)
    assert sizes[2] == pytest.approx(shear, rel=1e-12)


@pytest.mark.parametrize("depth", [0.0, 1e-5])
def test_without_softening_the_ramp_of_adhesion_does_not_couple_shear_with_pressure(depth):
    """Ten times the pressure, of points that only just touch as well; no other branch loses anything."""
    y, h = SHIFT + np.array([[-0.5, -0.4, 1.0]]), 1e-7
    corners = replace(corners_at("face", places=y - SHIFT - (0.0, 0.0, depth)),
                      limits=PlaceLimits(np.array([1e9]), np.zeros(0), np.zeros(0, bool)))
    contact = contact_at(corners, "face", np.inf)
    assert contact.slip.all()
    normal = contact.normal[0]
    deeper = contact_at(corners, "face", np.inf, corners.position - h * normal)
    coupled = (deeper.shear - contact.shear)[0] / h
    np.testing.assert_allclose(-contact.ramp[0] @ normal, coupled, rtol=1e-5)
    assert np.linalg.norm(coupled) == pytest.approx(1e5 * 10, rel=1e-5)
    stiff = assembly.derivative(contact, assembly.Tangent.DEFINITE)[0]
    assert np.abs(stiff @ normal - (normal @ stiff @ normal) * normal).max() < 1e-9 * np.abs(stiff).max()
    for branch, (pulled, mu, shear, tension, *_) in BRANCHES.items():
        assert not contact_at(corners_of("face", pulled, shear, tension), "face", mu).ramp.any(), branch
