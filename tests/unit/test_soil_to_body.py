"""Contact at corners: action and reaction, objectivity, friction anchors."""

from dataclasses import replace

import numpy as np
import pytest
from contact_bed import MU, RATIO, RIGHT_HAND, ball, body_at, box, contact_of, corners_in, found_in_bed
from contact_features import CENTRE, INSIDE, ROTATION, SURFACE, corners_at
from smooth_shapes import sphere

from hybrid.body.attitude import exp_so3
from hybrid.body.closest import closest
from hybrid.body.surface import build_surface
from hybrid.contact import assembly, soil_to_body
from hybrid.contact.interface import PlaceLimits

# ---------------------------------------------------------------- action and reaction, objectivity


def test_force_and_moment_cancel_to_round_off():
    surface, body = ball(), body_at((0.41, 0.38, 0.21), RIGHT_HAND)
    grid, corners = found_in_bed(surface, body)
    nodes = np.stack([a.ravel() for a in np.meshgrid(*grid.axes, indexing="ij")], axis=1)
    move = 0.004 * np.random.default_rng(2).standard_normal(nodes.shape)
    pose = body.position + (0.003, 0.001, -0.004), exp_so3(np.array([0.02, 0.05, -0.03])) @ body.rotation
    contact = contact_of(corners, surface, pose, corners.moved(move))
    assert len(contact) > 20 and 0 < contact.slip.sum() < len(contact)
    force = np.zeros_like(nodes)
    on_body = assembly.add_residual(contact, corners, force)
    scale = np.abs(contact.force).sum()
    np.testing.assert_allclose(force.sum(axis=0) + on_body[:3], 0.0, atol=1e-13 * scale)
    moment = np.cross(nodes + move - pose[0], force).sum(axis=0) + on_body[3:]
    np.testing.assert_allclose(moment, 0.0, atol=1e-13 * scale)


def test_tangent_of_a_rigid_motion_of_everything_vanishes_in_translation():
    """Moving corners and body together changes no force: D and Q cancel."""
    surface, body = ball(), body_at((0.41, 0.38, 0.21), RIGHT_HAND)
    _, corners = found_in_bed(surface, body)
    contact = contact_of(corners, surface, (body.position - (0, 0, 0.01), body.rotation))
    ww, Q = assembly.body_tangent(contact)
    np.testing.assert_allclose(contact.tangent + Q[:, :, :3], 0.0, atol=1e-12 * np.abs(Q).max())
    np.testing.assert_allclose(ww[:3, :3], contact.tangent.sum(axis=0), atol=1e-12 * np.abs(ww).max())


def test_a_point_that_an_edge_has_left_behind_is_not_pushed_by_the_next_face():
    """A point 2 um under the foot of a box, over which its edge has moved by 1 um: the rear face is nearer, but the face of
    the soil looks at the foot. Points that did not touch it, that are bonded to it, or look at the rear face as well, as
    under a box that tips over its edge, stay as they are."""
    y, surface = np.array([[-1.0 + 1e-6, 0.1, -0.5 + 2e-6]]), box()
    points = corners_in(surface, y, y)
    assert len(contact_of(points, surface)) == 1
    foot = replace(points, side=np.array([[0.0, 0.0, -1.0]]), outward=np.array([[0.0, 0.0, 1.0]]))
    assert len(contact_of(foot, surface)) == 0
    assert len(contact_of(foot, surface, place=y + [[2e-6, 0.0, 0.0]])) == 1       # not yet
    assert contact_of(replace(foot, rest=np.full(1, -1e-6)), surface).rest == -1e-6     # kept for the next step
    assert len(contact_of(replace(foot, touching=np.zeros(1, bool)), surface)) == 1
    bond = PlaceLimits(np.zeros(0), np.full(1, np.inf), np.zeros(1, bool))
    assert len(contact_of(replace(foot, limits=bond), surface)) == 1
    assert len(contact_of(replace(foot, side=np.array([[-0.8, 0.0, -0.6]])), surface)) == 1     # beside a blunt edge
    assert len(contact_of(replace(foot, outward=None), surface)) == 1
    round_body, y_round = build_surface(*sphere(2)), np.array([[0.99, 0.0, 0.0]])
    on_flank = replace(foot, position=y_round, start=y_round, anchor=y_round)
    assert len(contact_of(on_flank, round_body)) == 1       # around which a point may have flowed
    tipped = exp_so3(np.array([0.0, 0.2, 0.0])).T       # its rear face looks down
    assert (tipped @ [-1.0, 0.0, 0.0])[2] < -0.1
    assert len(contact_of(foot, surface, (np.zeros(3), tipped), y @ tipped.T)) == 1


def test_without_softening_the_tangent_of_a_convex_body_resists_every_motion():
    """A ball's pressure turns with its surface and pushes points aside: p/r of softening. Of plane faces nothing is taken
    away."""
    surface, rng = build_surface(*sphere(2)), np.random.default_rng(3)
    y = rng.standard_normal((40, 3))
    y *= (rng.uniform(0.9, 0.99, 40) / np.linalg.norm(y, axis=1))[:, None]
    contact = contact_of(corners_in(surface, y, y), surface, mu=0.0)
    softest, least = (np.linalg.eigvalsh(0.5 * (D + D.transpose(0, 2, 1))).min(axis=1)
                      for D in (contact.tangent, assembly.derivative(contact, kind=assembly.Tangent.DEFINITE)))
    np.testing.assert_allclose(softest, -contact.pressure / (1.0 + contact.gap), rtol=0.05)
    assert (least > 0.02 * softest).all()
    flat = contact_of(corners_at("face"), SURFACE["face"], (CENTRE, ROTATION))
    assert len(flat) == len(INSIDE["face"])
    np.testing.assert_array_equal(assembly.derivative(flat, assembly.Tangent.DEFINITE), flat.tangent)


def test_law_is_objective():
    surface, rng = ball(), np.random.default_rng(3)
    pose = np.array([0.2, 0.1, -0.3]), RIGHT_HAND
    y = rng.standard_normal((40, 3))
    y *= (rng.uniform(0.22, 0.249, 40) / np.linalg.norm(y, axis=1))[:, None]
    corners = corners_in(surface, y, y + 0.002 * rng.standard_normal(y.shape), pose)
    contact = contact_of(corners, surface, pose)
    Q, shift = exp_so3(np.array([-0.8, 0.5, 2.0])), np.array([3.0, -1.0, 2.0])
    turned_pose = Q @ pose[0] + shift, Q @ pose[1]
    turned = contact_of(corners, surface, turned_pose, corners.position @ Q.T + shift)
    assert 0 < contact.slip.sum() < len(contact)
    np.testing.assert_array_equal(turned.slip, contact.slip)
    np.testing.assert_allclose(turned.gap, contact.gap, rtol=1e-11)
    np.testing.assert_allclose(turned.anchor, contact.anchor, atol=1e-14)
    np.testing.assert_allclose(turned.force, contact.force @ Q.T, atol=1e-11 * np.abs(contact.force).max())
    expected = Q @ contact.tangent @ Q.T
    np.testing.assert_allclose(turned.tangent, expected, atol=1e-10 * np.abs(expected).max())
    assert turned.energy == pytest.approx(contact.energy, rel=1e-11)


# ---------------------------------------------------------------- anchors


def test_anchor_without_expected_motion_is_the_place_at_the_start():
    surface, body = ball(), body_at((0.4, 0.4, 0.27), RIGHT_HAND)
    _, corners = found_in_bed(surface, body)
    assert len(corners) and not corners.touching.any()
    np.testing.assert_allclose(corners.anchor, corners.start, atol=1e-15)


@pytest.mark.parametrize("touching", [True, False])
def test_slip_moves_the_anchor_to_the_friction_limit(touching):
    surface = box()
    corners = corners_in(surface, [[0.2, 0.1, -0.49]], [0.21, 0.12, -0.495], touching=touching)
    contact = contact_of(corners, surface)
    pressure = 2e4 * 0.01
    assert contact.slip.all()
    z = corners.start[0] - contact.anchor[0]
    assert RATIO * 2e4 * np.hypot(z[0], z[1]) == pytest.approx(MU * pressure, rel=1e-12)
    assert np.hypot(*contact.force[0, :2]) == pytest.approx(MU * pressure, rel=1e-12)
    assert contact.force[0] @ (0.01, 0.02, 0.0) < 0.0         # against the way from the anchor
    history = soil_to_body.commit(corners, corners.position, contact)
    again = contact_of(replace(corners, touching=history.touching, anchor=history.anchor), surface)
    np.testing.assert_allclose(again.force, contact.force, rtol=1e-12)
    assert again.dissipated == pytest.approx(0.0, abs=1e-12)


def test_stick_leaves_the_anchor():
    surface = box()
    corners = corners_in(surface, [[0.2, 0.1, -0.49]], [0.201, 0.1, -0.495])
    contact = contact_of(corners, surface)
    assert not contact.slip.any() and contact.dissipated == 0.0
    np.testing.assert_array_equal(contact.anchor, corners.anchor)
    np.testing.assert_allclose(contact.force[0, :2], (-RATIO * 2e4 * 0.001, 0.0), atol=1e-9)


def slide(surface, mu=MU, steps=30):
    """Forces on a corner that slides and turns back under a box, with history from step to step."""
    corners = corners_in(surface, [[-0.6, -0.31, -0.49]], [-0.6, -0.31, -0.49])
    forces, work = [], 0.0
    for angle in np.linspace(0, 3.0, steps):
        y = np.array([[-0.6 + 0.9 * np.sin(angle), -0.31 + 0.2 * angle, -0.49]])
        contact = contact_of(corners, surface, place=y, mu=mu)
        history = soil_to_body.commit(corners, y, contact)
        corners = replace(corners, position=y, start=y, touching=history.touching, anchor=history.anchor)
        forces.append(contact.force[0])
        work += contact.dissipated
    return np.array(forces), work


def test_history_survives_hopping_between_triangles():
    coarse, fine = slide(box(1)), slide(box(9))
    np.testing.assert_allclose(fine[0], coarse[0], atol=1e-9)
    assert fine[1] == pytest.approx(coarse[1], rel=1e-12)


def test_friction_work_is_force_times_way():
    forces, work = slide(box(1), steps=300)
    angle = np.linspace(0, 3.0, 300)
    way = np.diff(np.stack([0.9 * np.sin(angle), 0.2 * angle], axis=1), axis=0)
    assert work == pytest.approx(np.sum(forces[1:, :2] * way), rel=5e-3)
    assert work > 0


def test_without_friction_the_force_is_normal():
    contact = contact_of(corners_in(box(), [[0.2, 0.1, -0.49]], [0.5, 0.5, -0.4]), box(), mu=0.0)
    np.testing.assert_allclose(contact.force, [[0.0, 0.0, 200.0]], atol=1e-9)
    assert not contact.slip.any()


# ---------------------------------------------------------------- clearance


def touched(clearance):
    """Ids and forces of corners about a ball that everything moves towards, with their clearance scaled."""
    surface, body = ball(), body_at((0.4, 0.4, 0.2))
    _, corners = found_in_bed(surface, body)
    corners = replace(corners, clearance=corners.clearance * clearance, side=np.zeros_like(corners.side))
    found = []
    for seed, way in enumerate((0.0, 0.005, 0.02, 0.08)):
        motion = way * np.random.default_rng(seed).standard_normal((len(corners), 3))
        pose = body.position - [0.0, 0.0, way], body.rotation
        contact = contact_of(corners, surface, pose, corners.position + motion)
        found.append((contact.active, contact.force))
    return found


def test_corners_that_go_less_than_their_clearance_are_rightly_passed_over():
    for (active, force), (all_active, all_force) in zip(touched(1.0), touched(0.0)):
        np.testing.assert_array_equal(active, all_active)
        np.testing.assert_array_equal(force, all_force)


def test_too_much_clearance_is_found_out():
    assert any(len(active) < len(wanted) for (active, _), (wanted, _) in zip(touched(1.5), touched(0.0)))


def test_clearance_is_the_distance_at_the_start():
    surface, body = ball(), body_at((0.4, 0.4, 0.2))
    _, corners = found_in_bed(surface, body)
    wanted = [closest(tuple(y), np.inf, surface.tree)[4] for y in corners.start]
    np.testing.assert_allclose(corners.clearance, wanted, atol=1e-15)
    assert corners.clearance.min() < 0.0 < corners.clearance.max()


# ---------------------------------------------------------------- energy


@pytest.mark.parametrize("touching, path", [(True, 1.0), (False, 3.0)])
def test_energy_is_that_of_the_springs_whether_they_stick_or_slip(touching, path):
    """Σ p²/(2 ε_N) + |t|²/(2 ε_T). Slip works μ p along the path, less what the spring keeps, μ p/ε_T: the path from
    the anchor of corners that touched before, from the start of the step of others."""
    surface, rng = box(), np.random.default_rng(5)
    y = np.column_stack([rng.uniform(-0.5, 0.5, (40, 2)), rng.uniform(-0.499, -0.49, 40)])
    slide = rng.uniform(-0.005, 0.005, (40, 3)) * (1, 1, 0)
    contact = contact_of(corners_in(surface, y - 3 * slide, y - slide, touching=touching), surface, place=y)
    stiffness, along = 2e4, contact.force + contact.pressure[:, None] * contact.normal
    size = np.linalg.norm(along, axis=1)
    assert len(contact) == 40 and 5 < contact.slip.sum() < 35
    energy = 0.5 * contact.pressure**2 / stiffness + 0.5 * size**2 / (RATIO * stiffness)
    assert contact.energy == pytest.approx(energy.sum(), rel=1e-12)
    slipped = path * np.linalg.norm(slide, axis=1) - size / (RATIO * stiffness)
    assert contact.dissipated == pytest.approx((size * slipped)[contact.slip].sum(), rel=1e-12)
