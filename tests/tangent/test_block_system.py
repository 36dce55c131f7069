"""The assembled block system against finite differences of its residual: soil, coupling, bodies, inertia.

Slope test: with K exact, |R(u + h d) - R(u) - h K d| falls as h². Rates are asserted; a broken tangent falls as h, and
so does an exact one where a contact point opens, closes, starts or stops to slip within h: R has a kink there, which is
why d is a direction along which none does.
"""

from dataclasses import replace

import numpy as np
import pytest
from pressed_block import prepared, scene
from scipy.sparse import csr_matrix

from hybrid.body.rigid import FREEDOMS

SIZE = 1e-5     # [m, rad] of the largest step of the slope tests
STICK = 1e6     # μ at which points stick that have only just closed


def dense_tangent(step):
    system, pattern = step.system, step.pattern
    uu = csr_matrix((system.values, pattern.indices, pattern.indptr)).toarray()
    return np.block([[uu, system.uw], [system.wu, system.ww]])


def remainders(step, unknowns, direction, sizes, spoil=lambda K: K):
    """|R(u + h d) - R(u) - h K d| for each h."""
    start = step.evaluate(unknowns)
    step.assemble(start)
    slope = spoil(dense_tangent(step)) @ direction
    n = step.pattern.size
    base = np.concatenate([start.soil, start.body])
    out = []
    for h in sizes:
        there = step.evaluate(step.moved(unknowns, direction[:n], direction[n:], h))
        out.append(np.linalg.norm(np.concatenate([there.soil, there.body]) - base - h * slope))
    return np.array(out)


def observed_rate(step, unknowns, **broken):
    sizes = SIZE / 2.0 ** np.arange(4)
    r = remainders(step, unknowns, smooth_direction(step, unknowns), sizes, **broken)
    return np.polyfit(np.log(sizes), np.log(r), 1)[0]


def smooth_direction(step, unknowns):
    """The first random direction along which no contact point changes its state."""
    n, m = step.pattern.size, step.system.body_unknowns

    def states(scale, direction):
        found = step.evaluate(step.moved(unknowns, direction[:n], direction[n:], scale))
        return [np.stack([contact.active, contact.slip]) for contact in found.contacts]

    for seed in range(3, 200):
        direction = np.random.default_rng(seed).standard_normal(n + m)
        start = states(0.0, direction)
        if all(np.array_equal(one, other) for scale in SIZE * np.array([0.25, 0.5, 1.0])
               for one, other in zip(start, states(scale, direction))):
            return direction
    raise AssertionError("contact points change their state along every direction")


@pytest.mark.parametrize("law", ["hencky", "drucker-prager"])
@pytest.mark.parametrize("friction", [0.0, 0.02, 0.3, STICK])
def test_block_tangent_is_consistent(geometry, law, friction):
    step, unknowns = prepared(scene(geometry, law, friction))
    touch = step.evaluate(unknowns).contacts[0]
    assert len(touch) >= 4
    if friction == 0.02:
        assert touch.slip.all()
    if friction == STICK:
        assert not touch.slip.any()
    assert observed_rate(step, unknowns) > 1.85


def test_each_of_two_bodies_has_its_own_rows_and_columns(geometry):
    one = scene(geometry, "hencky", 0.3)
    first = one.bodies[0]
    second = replace(first, name="second", position=(1.17, 0.41, 0.25 + 0.005), velocity=(0.4, 0.0, -2.0), held=("y",),
                     friction=0.02)
    wide = replace(one.grid, x=replace(one.grid.x, end=1.6))
    step, unknowns = prepared(replace(one, grid=wide, bodies=(first, second)))
    assert all(len(contact) >= 4 for contact in step.evaluate(unknowns).contacts)
    assert step.system.body_unknowns == 11
    assert observed_rate(step, unknowns) > 1.85


def test_plastic_points_are_tested(geometry):
    step, unknowns = prepared(scene(geometry, "drucker-prager", 0.3))
    trial = step.evaluate(unknowns).soil_trial
    flow = np.abs(trial.strain.strain - trial.response.elastic).max(axis=1) > 1e-9
    apex = np.abs(trial.response.tangent).max(axis=(1, 2)) == 0.0
    assert 0.1 < flow.mean() < 1.0 and apex.any() and not apex.all()


@pytest.mark.parametrize("block", ["uu", "uw", "wu", "ww"])
def test_slope_test_fails_on_a_broken_block(geometry, block):
    step, unknowns = prepared(scene(geometry, "hencky", 0.3))
    n = step.pattern.size
    rows, columns = (slice(0, n) if field == "u" else slice(n, None) for field in block)

    def spoil(K):
        K = K.copy()
        K[rows, columns] *= 1.01
        return K

    assert observed_rate(step, unknowns, spoil=spoil) < 1.5


# ------------------------------------------------------------------ places of contact


@pytest.mark.parametrize("friction", [0.02, STICK])
@pytest.mark.parametrize("contact", ["faces", "corners"])
def test_tangent_of_contact_at_all_places(geometry, contact, friction):
    """Slip of every contact at μ = 0.02, stick of every one at μ = STICK."""
    step, unknowns = prepared(scene(geometry, "hencky", friction, contact=contact))
    touch = step.evaluate(unknowns).contacts[0]
    assert len(touch) >= 4 and (touch.slip.all() if friction == 0.02 else not touch.slip.any())
    assert observed_rate(step, unknowns) > 1.85


# ------------------------------------------------------------------ guided components


@pytest.mark.parametrize("contact", ["faces", "corners"])
@pytest.mark.parametrize("guide", ["held", "driven"])
def test_guided_components_of_a_body_are_no_unknowns(geometry, guide, contact):
    guided = ("y", "rx", "rz")
    described = scene(geometry, "hencky", 0.3, contact=contact, **{guide: guided})
    step, unknowns = prepared(described)
    assert step.system.body_unknowns == 3 and dense_tangent(step).shape == (step.pattern.size + 3,) * 2
    assert observed_rate(step, unknowns) > 1.85


@pytest.mark.parametrize("driven", [("x",), ("z", "ry"), FREEDOMS])
def test_rows_and_columns_of_driven_components_are_absent(geometry, driven):
    """K of a body that is driven along its own path is K of the free body there without those rows and columns,
    but for the moment of the spin rate that the body starts with, which guides change (3e-10 of K). Without gravity: a
    free body that touches nothing yet is expected to fall, a driven one is not, and their friction starts elsewhere."""
    tangents, poses = [], []
    for some in ((), driven):
        described = scene(geometry, "hencky", 0.3, driven=some, contact="corners")
        step, _ = prepared(replace(described, gravity=(0.0, 0.0, 0.0)))
        unknowns = step.predictor()
        step.assemble(step.evaluate(unknowns))
        tangents.append(dense_tangent(step))
        poses.append(unknowns.poses[0])
    np.testing.assert_allclose(poses[0][0], poses[1][0], rtol=0, atol=1e-15)
    np.testing.assert_allclose(poses[0][1], poses[1][1], rtol=0, atol=1e-15)
    kept = np.append(np.ones(step.pattern.size, bool), ~np.isin(FREEDOMS, driven))
    wanted = tangents[0][np.ix_(kept, kept)]
    np.testing.assert_allclose(tangents[1], wanted, rtol=0, atol=1e-9 * np.abs(wanted).max())
