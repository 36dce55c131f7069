"""Contact of two bodies with one another: its stiffness by differences, and forces that cancel."""

from dataclasses import replace

import numpy as np
import pytest

from hybrid.body.attitude import exp_so3
from hybrid.contact import body_to_body
from hybrid.setup.build import build
from hybrid.step.equations import begin
from hybrid.step.workspace import Workspace
from hybrid.study.scenes import box, plane, sphere

SLIDING, STICKING = (4e-3, 2e-3), (2e-6, 1e-6)


def bodies(kind, friction):
    ball = sphere(0.25, 0.1, name="one", position=(0.0, 0.0, 2.0), friction=friction)
    brick = box(0.6, 0.5, 0.4, name="one", position=(0.0, 0.0, 2.05), friction=friction)
    tilted = {"rotation": (0.3, 1.0, 0.2, 3.0)} if kind != "box on box" else {}
    other = box(0.6, 0.5, 0.4, name="two", position=(0.1, 0.05, 2.454), friction=friction, **tilted)
    return [brick if kind == "box on box" else ball, other]


def contact(kind, friction, slid):
    """PairsStep and poses at which the upper body is pressed into the lower one and has slid by `slid` (2,) [m]."""
    first, second = bodies(kind, friction)
    scene = plane(first, 1, 0.01, gravity=(0.0, 0.0, -9.81))
    simulation = build(type(scene)(**{**vars(scene), "bodies": (first, second)}))
    pairs = begin(simulation.model, simulation.state, 0.01, False, Workspace(simulation.model)).pairs
    poses = list(pairs.poses)
    turned = exp_so3([4e-4, 2e-4, 1e-3]) @ poses[1][1] if slid != SLIDING else poses[1][1]
    for sunk in np.arange(0.0, 0.02, 2e-4):
        poses[1] = pairs.poses[1][0] + (*slid, -sunk), turned
        terms = pairs.evaluate(poses)
        if sum(np.count_nonzero(side.gap < -1e-5) for side in terms.contacts[0]) > 60:
            return pairs, poses
    raise AssertionError("no contact")


def moved(poses, step):
    return [(c + step[6 * i:6 * i + 3], exp_so3(step[6 * i + 3:6 * i + 6]) @ turn) for i, (c, turn) in enumerate(poses)]


def residual(pairs, poses):
    terms = pairs.evaluate(poses)
    return np.concatenate([terms.on_body(0), terms.on_body(1)])


CASES = [("ball", 0.3, SLIDING), ("ball", 5.0, STICKING), ("ball", 0.0, STICKING), ("box on box", 0.3, SLIDING)]


@pytest.mark.parametrize("kind, friction, slid", CASES)
def test_stiffness_by_differences(kind, friction, slid):
    pairs, poses = contact(kind, friction, slid)
    terms, K, h = pairs.evaluate(poses), np.zeros((12, 12)), 1e-8
    slipping = np.concatenate([side.slip for side in terms.contacts[0]])
    assert slipping.all() if slid == SLIDING else not slipping.all()
    terms.add_tangent(K)
    expected = np.array([(residual(pairs, moved(poses, h * e)) - residual(pairs, moved(poses, -h * e))) / (2 * h)
                         for e in np.eye(12)]).T
    assert np.abs(K - expected).max() < 2e-6 * np.abs(K).max()
    K[9:, :3] *= 0.99
    assert np.abs(K - expected).max() > 1e-5 * np.abs(K).max()


@pytest.mark.parametrize("kind, friction, slid", CASES)
def test_forces_and_moments_on_both_bodies_cancel(kind, friction, slid):
    pairs, poses = contact(kind, friction, slid)
    on = residual(pairs, poses)
    scale = np.abs(on).max()
    np.testing.assert_allclose(on[:3] + on[6:9], 0.0, atol=1e-12 * scale)
    moments = on[3:6] + np.cross(poses[0][0], on[:3]) + on[9:] + np.cross(poses[1][0], on[6:9])
    np.testing.assert_allclose(moments, 0.0, atol=1e-11 * scale)
    assert on[2] > 0.0      # minus the force on the lower body, which is pressed down


@pytest.mark.parametrize("friction, slid", [(0.0, STICKING), (0.3, SLIDING)])
def test_stiffness_of_places_whose_overlap_is_bounded(friction, slid, monkeypatch):
    """Their pressure is that of the bound, here 10 µm however far they have moved."""
    monkeypatch.setattr(body_to_body, "DEEPER", 0.0)
    pairs, poses = contact("ball", friction, slid)
    bounded = tuple(replace(one, sides=tuple(replace(side, overlap=np.full(len(side), 1e-5)) for side in one.sides))
                    for one in pairs.near)
    pairs = replace(pairs, near=bounded)
    terms, K, h = pairs.evaluate(poses), np.zeros((12, 12)), 1e-8
    terms.add_tangent(K)
    for side, one in zip(terms.contacts[0], bounded[0].sides):
        pressure = np.einsum("mi,mi->m", side.force, side.normal)
        assert np.abs(pressure / one.stiffness[side.active]).max() == pytest.approx(1e-5, rel=1e-9)
    expected = np.array([(residual(pairs, moved(poses, h * e)) - residual(pairs, moved(poses, -h * e))) / (2 * h)
                         for e in np.eye(12)]).T
    assert np.abs(K - expected).max() < 1e-4 * np.abs(K).max()
