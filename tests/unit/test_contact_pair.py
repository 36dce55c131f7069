"""Contact of one body: forces and tangent on soil and body, and what a step hands on to the next one."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from contact_bed import PLACES, PRESSURE, RIGHT_HAND, ball, bed, body_at, domains_of, id_of

from hybrid.body.attitude import exp_so3
from hybrid.contact import contact_points
from hybrid.contact.contact_pair import ContactPair
from hybrid.contact.contact_points import SoilSurface
from hybrid.contact.search import Reach
from hybrid.linalg.stencil_pattern import make_pattern
from hybrid.state import ContactHistory

POSE = np.array([0.4, 0.4, 0.22]), RIGHT_HAND


def pair_of(places="faces", friction=0.3, history=None, included=True):
    """Grid and ContactPair of a ball that overlaps a bed by 30 mm."""
    grid, position, half = bed()
    body = SimpleNamespace(
        surface=ball(), friction=friction, tangential=0.5, places=PLACES[places],
        free=np.array([True, True, True, False, True, True]), contact_pressure=np.full(len(position), PRESSURE),
        soft_edges=None)
    soil = SoilSurface(domains_of(position, half, included), grid, np.ones(grid.node_count, bool))
    return grid, ContactPair(soil, body, body_at(*POSE), history or ContactHistory.empty(), Reach(0.08, 0.0),
                             (np.zeros((grid.node_count, 3)), POSE), begins=history is None)


def moved(grid, seed=0, size=1e-3):
    """Nodal increments and a pose close to the start."""
    rng = np.random.default_rng(seed)
    pose = POSE[0] + size * rng.standard_normal(3), exp_so3(4 * size * rng.standard_normal(3)) @ POSE[1]
    return size * rng.standard_normal((grid.node_count, 3)), pose


@pytest.mark.parametrize("places", PLACES)
def test_forces_and_moments_on_soil_and_body_cancel(places):
    grid, pair = pair_of(places)
    displacement, pose = moved(grid)
    found = pair.evaluate(displacement, pose)
    assert len(found) > 10 and 0 < found.slip.sum() < len(found)
    nodes = np.stack([a.ravel() for a in np.meshgrid(*grid.axes, indexing="ij")], axis=1)
    nodal = np.zeros((grid.node_count, 3))
    residual = pair.add_residual(found, nodal)
    np.testing.assert_allclose(residual, -found.resultant, rtol=1e-12)
    scale = np.abs(nodal).sum()
    np.testing.assert_allclose(nodal.sum(axis=0) + residual[:3], 0.0, atol=1e-12 * scale)
    moment = np.cross(nodes + displacement - pose[0], nodal).sum(axis=0) + residual[3:]
    np.testing.assert_allclose(moment, 0.0, atol=1e-12 * scale)
    assert found.largest_overlap == -found.gap.min() > 0.01
    assert pair.springs(found) == pytest.approx(np.linalg.norm(pair.points.stiffness[found.active]), rel=1e-12)


def test_without_contact_nothing_acts():
    grid, pair = pair_of()
    away = POSE[0] + (0.0, 0.0, 0.05), POSE[1]
    found = pair.evaluate(np.zeros((grid.node_count, 3)), away)
    assert len(found) == 0 and found.largest_overlap == 0.0 and found.energy == 0.0 and pair.springs(found) == 0.0
    np.testing.assert_array_equal(found.resultant, np.zeros(6))


@pytest.mark.parametrize("places", PLACES)
def test_blocks_of_the_tangent_are_derivatives_of_the_residuals(places):
    """Taylor test over nodes and free body components together: the remainder falls as h²; without K_uw it does not."""
    grid, pair = pair_of(places)
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


def test_history_contains_what_is_in_contact(monkeypatch):
    monkeypatch.setattr(contact_points, "SUNK", np.inf)
    grid, pair = pair_of()
    displacement, pose = moved(grid)
    found = pair.evaluate(displacement, pose)
    history = pair.commit(found, displacement)
    np.testing.assert_array_equal(id_of(history), id_of(pair.points))
    np.testing.assert_array_equal(history.position, pair.points.moved(displacement))
    assert history.touching.sum() == len(found)
    _, following = pair_of(history=history)
    again = following.evaluate(np.zeros((grid.node_count, 3)), POSE)
    common = np.isin(id_of(following.points), id_of(history))
    np.testing.assert_array_equal(following.points.position[common],
                                  history.position[np.isin(id_of(history), id_of(following.points))])
    assert history.touching[np.isin(id_of(history), id_of(following.points))].sum() == history.touching.sum()
    assert again.dissipated <= found.energy


def following(change, **values):
    """Forces p by contact point before a step and at the start of the next, whose history `change` has altered."""
    grid, pair = pair_of(**values)
    still = np.zeros((grid.node_count, 3)), POSE
    found = pair.evaluate(*still)
    _, after = pair_of(history=change(pair.commit(found, still[0])), **values)
    again = after.evaluate(*still)
    return (dict(zip(id_of(p.points)[f.active].tolist(), f.pressure)) for p, f in ((pair, found), (after, again)))


def test_contact_points_that_are_found_inside_a_body_start_without_force():
    """They resist from there on, and press as others do once they have come out."""
    grid, pair = pair_of()
    still = np.zeros((grid.node_count, 3))
    history = pair.commit(pair.evaluate(still, POSE), still)
    unknown = replace(history, **{name: values[:1] for name, values in vars(history).items()})
    _, after = pair_of(history=unknown)
    assert len(after.evaluate(still, POSE)) <= 1
    deeper = after.evaluate(still, (POSE[0] - (0.0, 0.0, 1e-3), POSE[1]))
    new = deeper.active > 0
    assert new.any() and (deeper.pressure[new] < 1.1e-3 * after.points.stiffness[deeper.active[new]]).all()
    out = after.evaluate(still, (POSE[0] + (0.0, 0.0, 1.0), POSE[1]))
    assert (after.points.rest[1:] < 0.0).any() and (out.rest == 0.0).all()


def test_points_left_out_have_no_contact_points():
    _, pair = pair_of()
    stays = np.ones(len(bed()[1]), bool)
    stays[pair.points.point[0]] = False
    _, without = pair_of(included=stays)
    np.testing.assert_array_equal(id_of(without.points), id_of(pair.points)[stays[pair.points.point]])


@pytest.mark.parametrize("places", PLACES)
def test_contact_points_that_pass_through_are_counted(places):
    """The ball's mean plane is carried below the surface of the bed and beyond: its points come out above it."""
    grid, pair = pair_of(places)
    pair.points = replace(pair.points, touching=np.zeros(len(pair.points), bool))
    above = pair.points.clearance > 0.0
    displacement = np.zeros((grid.node_count, 3))
    near, far = POSE, (POSE[0] - (0.0, 0.0, 0.6), POSE[1])
    counts = [pair.tunnelled(pair.evaluate(displacement, pose), displacement, pose, 0.005) for pose in (near, far)]
    assert counts[0] == 0 < counts[1] <= above.sum()
