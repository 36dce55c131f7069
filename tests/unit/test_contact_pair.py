"""Both passes of contact of one body: what they share, what they hand on, and what their sums are."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from contact_bed import RIGHT_HAND, ball, bed, body_at

from hybrid.body.attitude import exp_so3
from hybrid.body.samples import surface_samples
from hybrid.contact.contact_pair import ContactPair
from hybrid.linalg.stencil_pattern import make_pattern
from hybrid.state import ContactHistory

POSE = np.array([0.4, 0.4, 0.22]), RIGHT_HAND


def pair_of(second_pass=0.5, friction=0.3, history=None, inactive=None, half=None):
    """Grid and ContactPair of a ball that overlaps a bed by 30 mm."""
    grid, position, width = bed()
    surface = ball()
    body = SimpleNamespace(
        surface=surface, friction=friction, tangential=0.5, second_pass=second_pass,
        samples=surface_samples(surface, 0.05), free=np.array([True, True, True, False, True, True]),
        contact_stiffness=np.full(len(position), 8e4), contact_pressure=np.full(len(position), 3.2e7))
    points = SimpleNamespace(position=position, half_width=width, inactive=inactive)
    return grid, ContactPair(
        body, body_at(*POSE), history or ContactHistory.empty(), points, width if half is None else half, grid,
        np.ones(grid.node_count, bool), 0.08, (np.zeros((grid.node_count, 3)), POSE))


def moved(grid, seed=0, size=1e-3):
    """Nodal increments and a pose close to the start."""
    rng = np.random.default_rng(seed)
    pose = POSE[0] + size * rng.standard_normal(3), exp_so3(4 * size * rng.standard_normal(3)) @ POSE[1]
    return size * rng.standard_normal((grid.node_count, 3)), pose


@pytest.mark.parametrize("second_pass", [0.0, 0.5, 1.0])
def test_shares_of_the_passes_add_up(second_pass):
    """Without friction and motion both forces are linear in the share."""
    grid, pair = pair_of(second_pass, friction=0.0)
    found = pair.evaluate(np.zeros((grid.node_count, 3)), POSE)
    assert (found.samples is None) == (second_pass == 0.0)
    assert len(found) == sum(len(part) for part in found.passes)
    force = 0.0
    for share, number in ((1 - second_pass, 0), (second_pass, 1)):
        if share:
            alone = pair_of(float(number), friction=0.0)[1].evaluate(np.zeros((grid.node_count, 3)), POSE)
            force = force + share * alone.force
    np.testing.assert_allclose(found.force, force, rtol=1e-10, atol=1e-9 * np.abs(force).max())


def test_force_energy_and_overlap_are_those_of_both_passes():
    grid, pair = pair_of()
    displacement, pose = moved(grid)
    found = pair.evaluate(displacement, pose)
    assert len(found.corners) > 10 and len(found.samples) > 10
    nodal = np.zeros((grid.node_count, 3))
    residual = pair.add_residual(found, nodal)
    np.testing.assert_allclose(residual, -found.force, rtol=1e-12)
    np.testing.assert_allclose(nodal.sum(axis=0) + residual[:3], 0.0, atol=1e-12 * np.abs(nodal).sum())
    assert found.energy == found.corners.energy + found.samples.energy > 0.0
    assert found.largest_overlap == max(-found.corners.gap.min(), -found.samples.gap.min()) > 0.01
    stiffness = [pair.corners.stiffness[found.corners.active], pair.samples.stiffness[found.samples.active]]
    assert pair.springs(found) == pytest.approx(np.linalg.norm(np.concatenate(stiffness)), rel=1e-12)


def test_without_contact_nothing_acts():
    grid, pair = pair_of()
    away = POSE[0] + (0.0, 0.0, 0.05), POSE[1]
    found = pair.evaluate(np.zeros((grid.node_count, 3)), away)
    assert len(found) == 0 and found.largest_overlap == 0.0 and found.energy == 0.0 and pair.springs(found) == 0.0
    np.testing.assert_array_equal(found.force, np.zeros(6))


@pytest.mark.parametrize("second_pass", [0.0, 0.5, 1.0])
def test_blocks_of_the_tangent_are_derivatives_of_the_residuals(second_pass):
    """Taylor test over nodes and free body components together: the remainder falls as h²; without K_uw it does not."""
    grid, pair = pair_of(second_pass)
    pattern = make_pattern(np.ones(grid.node_count, bool), np.zeros((grid.node_count, 3), bool), grid.shape)
    free, n = pair.body.free, pattern.size
    displacement, pose = moved(grid)
    rng = np.random.default_rng(4)
    du, dw = rng.standard_normal((grid.node_count, 3)), np.zeros(6)
    dw[free] = rng.standard_normal(5)

    def residual(h):
        nodal = np.zeros((grid.node_count, 3))
        at = pose[0] + h * dw[:3], exp_so3(h * dw[3:]) @ pose[1]
        found = pair.evaluate(displacement + h * du, at)
        body = pair.add_residual(found, nodal)
        return found, np.concatenate([nodal[pattern.free], body[free]])

    found, base = residual(0.0)
    values, uw, wu = np.zeros(len(pattern.indices)), np.zeros((n, 5)), np.zeros((5, n))
    ww = pair.add_tangent(found, pattern, values, uw, wu)[np.ix_(free, free)]
    rows = np.repeat(np.arange(n), np.diff(pattern.indptr))
    soil, body = du[pattern.free], dw[free]
    uu = np.bincount(rows, values * soil[pattern.indices], minlength=n)
    slope = np.concatenate([uu + uw @ body, wu @ soil + ww @ body])
    sizes = 1e-6 / 2.0 ** np.arange(4)
    for broken, rate in ((0.0, 2.0), (np.concatenate([uw @ body, np.zeros(5)]), 1.0)):
        left = [np.linalg.norm(residual(h)[1] - base - h * (slope - broken)) for h in sizes]
        assert np.polyfit(np.log(sizes), np.log(left), 1)[0] == pytest.approx(rate, abs=0.1)


def test_augment_takes_the_pressures_as_multipliers():
    """With the same pose the springs then carry twice the force, and what does not touch has no multiplier."""
    grid, pair = pair_of(friction=0.0)
    rest = np.zeros((grid.node_count, 3))
    first = pair.evaluate(rest, POSE)
    pair.augment(first)
    np.testing.assert_array_equal(pair.corners.pressure[first.corners.active], first.corners.pressure)
    assert np.count_nonzero(pair.corners.pressure) == len(first.corners)
    assert np.count_nonzero(pair.samples.pressure) == len(first.samples)
    second = pair.evaluate(rest, POSE)
    np.testing.assert_allclose(second.force, 2 * first.force, rtol=1e-10, atol=1e-9 * np.abs(first.force).max())


def test_history_contains_what_is_in_contact():
    grid, pair = pair_of()
    displacement, pose = moved(grid)
    found = pair.evaluate(displacement, pose)
    history = pair.commit(found, displacement)
    np.testing.assert_array_equal(history.id, pair.corners.id)
    np.testing.assert_array_equal(history.position, pair.corners.moved(displacement))
    assert history.touching.sum() == len(found.corners)
    np.testing.assert_array_equal(history.sample, pair.samples.id[found.samples.active])
    _, following = pair_of(history=history)
    again = following.evaluate(np.zeros((grid.node_count, 3)), POSE)
    followed = np.isin(history.id, following.corners.id)
    np.testing.assert_array_equal(following.corners.position, history.position[followed])
    assert again.corners.dissipated <= found.corners.energy


def test_inactive_points_have_no_corners():
    grid, pair = pair_of()
    gone = np.zeros(len(bed()[1]), bool)
    gone[pair.corners.id[0] // 8] = True
    _, without = pair_of(inactive=gone)
    np.testing.assert_array_equal(without.corners.id, pair.corners.id[~gone[pair.corners.id // 8]])


def test_corners_that_pass_through_are_counted():
    """The ball's mean plane is carried below the bed's top row of corners and beyond: they come out above it."""
    grid, pair = pair_of(0.0)
    pair.corners = replace(pair.corners, touching=np.zeros(len(pair.corners), bool))
    above = pair.corners.clearance > 0.0
    displacement = np.zeros((grid.node_count, 3))
    near, far = POSE, (POSE[0] - (0.0, 0.0, 0.6), POSE[1])
    counts = [pair.tunnelled(pair.evaluate(displacement, pose), displacement, pose, 0.005) for pose in (near, far)]
    assert counts[0] == 0 < counts[1] <= above.sum()


# ------------------------------------------------------------------ multipliers


def by_id(held):
    return dict(zip(held.id.tolist(), held.pressure))


def test_multipliers_are_handed_on_to_the_next_step():
    """Those of corners and samples in contact, by their ids."""
    grid, pair = pair_of()
    still = np.zeros((grid.node_count, 3))
    pair.augment(pair.evaluate(still, POSE))
    contact = pair.evaluate(still, POSE)
    _, following = pair_of(history=pair.commit(contact, still))
    for name in ("corners", "samples"):
        before, after = by_id(getattr(pair, name)), by_id(getattr(following, name))
        active = getattr(pair, name).id[getattr(contact, name).active].tolist()
        assert len(active) > 4 and min(before[c] for c in active) > 0
        assert {c: after[c] for c in active} == {c: before[c] for c in active}
        assert not any(value for c, value in after.items() if c not in active)


def test_corners_that_lose_contact_lose_their_multipliers():
    grid, pair = pair_of()
    still, raised = np.zeros((grid.node_count, 3)), (POSE[0] + (0.0, 0.0, 0.035), POSE[1])
    pair.augment(pair.evaluate(still, POSE))
    contact = pair.evaluate(still, raised)
    lost = np.ones(len(pair.corners), bool)
    lost[contact.corners.active] = False
    history = pair.commit(contact, still)
    assert (pair.corners.pressure[lost] > 0).any() and not history.pressure[lost].any()
