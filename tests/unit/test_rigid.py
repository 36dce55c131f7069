"""Forces on a rigid body apart from contact, its predicted pose, and guides that engage and release it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from contact_bed import RIGHT_HAND, box

from hybrid.body import rigid, stage_start
from hybrid.body.attitude import exp_so3, log_so3
from hybrid.body.rigid import Line, RigidBody
from hybrid.scheme import Scheme
from hybrid.state import BodyState

INERTIA = np.diag([2.0, 3.0, 4.5])
GRAVITY = np.array([0.0, 0.0, -9.81])
NEWMARK, STATIC = Scheme(), Scheme(inertia=False)
ALL, NONE = np.ones(6, bool), np.zeros(6)
DT = 0.01


def body_of(free=ALL, drive=NONE, line=None):
    mass = SimpleNamespace(mass=12.0, inertia=INERTIA, gravity_load=np.vstack([12.0 * np.eye(3), np.zeros((3, 3))]))
    return RigidBody("box", mass, box(), np.array(free, bool), np.array(drive, float), 0.3, 0.5, 50.0, line=line)


def state_of(**given):
    state = BodyState(np.array([0.3, -0.2, 1.0]), RIGHT_HAND, np.array([1.0, 0.5, -2.0]), np.zeros(3),
                      np.array([0.4, -0.3, 0.8]), np.zeros(3))
    return replace(state, **given)


def test_contact_stiffness_follows_the_modulus_of_soil_that_deforms():
    young = np.array([1e6, 2e6])
    np.testing.assert_allclose(rigid.with_stiffness(body_of(), young, False).contact_pressure, 50.0 * young)
    np.testing.assert_allclose(rigid.with_stiffness(body_of(), young, True).contact_pressure, [50.0, 50.0])


def test_bounding_box_of_a_turned_box():
    quarter = state_of(rotation=exp_so3(np.array([0.0, 0.0, np.pi / 2])))
    np.testing.assert_allclose(rigid.bounding_box(body_of(), quarter),
                               quarter.position + np.array([[-0.8, -1.0, -0.5], [0.8, 1.0, 0.5]]), atol=1e-12)


def test_weight_acts_at_the_centre_however_the_body_is_turned():
    state = state_of()
    trial = rigid.evaluate(body_of(), state, (state.position, state.rotation), None, GRAVITY, STATIC, DT)
    np.testing.assert_allclose(trial.weight, [0.0, 0.0, 12.0 * 9.81, 0.0, 0.0, 0.0], atol=1e-12)
    assert not trial.inertia.any() and not trial.line.any() and not trial.tangent.any() and trial.tension == 0.0


def test_line_is_laid_out_taut_and_only_once():
    line = Line(np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.6, 0.8]), np.zeros(3), 1e5, 4.0)
    body, state = body_of(line=line), state_of()
    laid = rigid.lay_out_line(body, state)
    shackle = state.position + state.rotation[:, 0]
    np.testing.assert_allclose(laid.target, shackle + [0.0, 2.4, 3.2])
    assert rigid.lay_out_line(body, laid) is laid
    assert rigid.lay_out_line(body_of(), state) is state
    taut = rigid.evaluate(body, laid, (laid.position, laid.rotation), laid.target, GRAVITY, STATIC, DT)
    assert taut.tension == pytest.approx(0.0, abs=1e-9)
    pulled = rigid.evaluate(body, laid, (laid.position, laid.rotation), laid.target + [0.0, 0.006, 0.008], GRAVITY,
                            STATIC, DT)
    assert pulled.tension == pytest.approx(1e5 * 0.01)
    np.testing.assert_allclose(-pulled.line[:3], 1e3 * np.array([0.0, 0.6, 0.8]), atol=1e-6)
    assert pulled.line_energy == pytest.approx(0.5 * 1e5 * 0.01**2)


def test_predicted_pose_keeps_the_rates():
    state, free = state_of(), np.array([1, 0, 1, 1, 1, 1], bool)
    drive = np.array([0.0, 3.0, 0.0, 0.0, 0.0, 0.0])
    position, rotation = rigid.predicted_pose(body_of(free, drive), state, NEWMARK, DT)
    np.testing.assert_allclose(position - state.position, DT * np.array([1.0, 3.0, -2.0]), atol=1e-15)
    np.testing.assert_allclose(log_so3(state.rotation.T @ rotation), DT * state.spin, atol=1e-12)
    position, rotation = rigid.predicted_pose(body_of(free, drive), state, STATIC, DT)
    np.testing.assert_allclose(position - state.position, DT * np.array([0.0, 3.0, 0.0]), atol=1e-15)
    np.testing.assert_allclose(rotation, state.rotation, atol=1e-15)


def test_moved_pose_composes_rotations_from_the_left():
    state, increment = state_of(), np.array([0.1, 0.2, 0.3, 0.0, 0.0, 0.5])
    position, rotation = rigid.moved_pose((state.position, state.rotation), increment)
    np.testing.assert_allclose(position, state.position + increment[:3])
    np.testing.assert_allclose(rotation @ state.rotation.T, exp_so3(increment[3:]), atol=1e-14)


@pytest.mark.parametrize("scheme", [NEWMARK, STATIC], ids=["newmark", "quasi-static"])
def test_accepted_state_has_the_rates_of_the_step(scheme):
    state = state_of()
    pose = rigid.predicted_pose(body_of(), state, NEWMARK, DT)
    new = rigid.accept(body_of(), state, pose, np.ones(3), NONE, scheme, DT)
    np.testing.assert_allclose(new.velocity, state.velocity, atol=1e-12)
    np.testing.assert_array_equal(new.target, np.ones(3))
    assert rigid.rotation_angle(body_of(), state, pose, scheme, DT) == pytest.approx(
        DT * np.linalg.norm(state.spin), rel=1e-6)


def test_guides_impose_their_rates_and_their_impulse_does_work():
    free, drive = np.array([1, 1, 0, 1, 1, 0], bool), np.array([0.0, 0.0, -1.0, 0.0, 0.0, 0.2])
    body, state = body_of(free, drive), state_of()
    new, work = stage_start.engage_guides(body, state, GRAVITY, NEWMARK)
    np.testing.assert_allclose(new.velocity, [1.0, 0.5, -1.0])
    spin, before = new.rotation @ new.spin, state.rotation @ state.spin
    np.testing.assert_allclose(spin, [before[0], before[1], 0.2], atol=1e-14)
    assert work == pytest.approx(rigid.kinetic_energy(body, new) - rigid.kinetic_energy(body, state))
    assert not new.reaction[free].any() and new.reaction[2] == pytest.approx(12.0 * 9.81)
    kept, none = stage_start.engage_guides(body_of(), state, GRAVITY, NEWMARK)
    assert kept is state and none == 0.0


@pytest.mark.parametrize("gravity, scheme, known", [
    (np.zeros(3), STATIC, True), (GRAVITY, STATIC, False), (np.zeros(3), NEWMARK, False)])
def test_the_reaction_of_a_joined_body_is_known_where_it_neither_weighs_nor_accelerates(gravity, scheme, known):
    """Else the work of its first step counted the force at the end over all of it."""
    body, still = body_of(np.array([1, 1, 0, 1, 1, 0], bool)), state_of(velocity=np.zeros(3), spin=np.zeros(3))
    new, _ = stage_start.engage_guides(body, still, gravity, scheme, joined=True)
    assert (new.reaction is not None) == known and (not known or not new.reaction.any())


def test_released_reaction_accelerates_the_body():
    """Held against its weight, and by a moment about the vertical: free, it falls with g and starts to turn."""
    reaction = np.array([0.0, 0.0, 12.0 * 9.81, 0.0, 0.0, 0.7])
    held = state_of(velocity=np.zeros(3), spin=np.zeros(3), reaction=reaction)
    new = stage_start.release_guides(body_of(), held)
    np.testing.assert_allclose(new.acceleration, GRAVITY)
    np.testing.assert_allclose(INERTIA @ new.spin_rate, -held.rotation.T @ reaction[3:], atol=1e-13)
    assert not new.reaction.any()
    still_held = body_of(np.array([1, 1, 0, 1, 1, 0], bool))
    assert stage_start.release_guides(still_held, held) is held
    assert stage_start.release_guides(body_of(), state_of()).reaction is None


def test_kinetic_energy():
    assert rigid.kinetic_energy(body_of(), state_of()) == pytest.approx(
        0.5 * 12.0 * 5.25 + 0.5 * (2.0 * 0.16 + 3.0 * 0.09 + 4.5 * 0.64))
