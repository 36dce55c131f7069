"""Joints: gradients of their rows, and the derivatives of their forces, by differences."""

import numpy as np
import pytest
from differences import central

from hybrid.body.attitude import exp_so3
from hybrid.body.joints import Joint

POSES = ((np.array([0.3, -0.2, 0.5]), exp_so3([0.5, -0.9, 0.3])), (np.array([1.1, 0.4, 0.1]), exp_so3([-0.2, 0.4, 1.3])))
POINTS = np.array([[0.8, 0.1, -0.4], [-0.3, 0.2, 0.6]])
E = np.eye(3)
JOINTS = {
    "ball": Joint("j", (0, 1), POINTS, True),
    "hinge": Joint("j", (0, 1), POINTS, True, ((E[0], E[1]), (E[0], E[2])), turning=(E[1], E[1], E[2]),
                   limits=(-0.5, 0.7), friction=3.0),
    "weld": Joint("j", (0, 1), POINTS, True, ((E[0], E[1]), (E[1], E[2]), (E[2], E[0]))),
    "rod": Joint("j", (0, 1), POINTS, False, length=0.4),
    "line": Joint("j", (0, 1), POINTS, False, length=0.4, slack=True),
}
every_joint = pytest.mark.parametrize("joint", JOINTS.values(), ids=JOINTS)


def moved(step):
    return tuple((c + step[6 * i:6 * i + 3], exp_so3(step[6 * i + 3:6 * i + 6]) @ turn)
                 for i, (c, turn) in enumerate(POSES))


@every_joint
def test_gradients_and_curvature_by_differences(joint):
    values, gradients = joint.rows(POSES, 0.1)
    n = len(joint.bounds)
    assert values.shape == (n,) and gradients.shape == (n, 12) and joint.angular.shape == (n,)
    np.testing.assert_allclose(gradients, central(lambda q: joint.rows(moved(q), 0.1)[0], 12), atol=1e-9)
    multipliers = np.random.default_rng(2).normal(size=n)
    expected = central(lambda q: joint.rows(moved(q), 0.1)[1].T @ multipliers, 12)
    np.testing.assert_allclose(joint.curvature(POSES, multipliers), expected, atol=1e-8)


@every_joint
def test_forces_on_both_bodies_balance(joint):
    (c, turn), (_, other) = POSES
    together = (c, turn), (c + turn @ POINTS[0] - other @ POINTS[1], other)      # no rod has a direction then
    poses = together if joint.at_point else POSES
    _, gradients = joint.rows(poses, 0.1)
    np.testing.assert_allclose(gradients[:, :3] + gradients[:, 6:9], 0.0, atol=1e-14)
    moments = [g[3:6] + g[9:12] + np.cross(poses[0][0], g[:3]) + np.cross(poses[1][0], g[6:9]) for g in gradients]
    np.testing.assert_allclose(moments, 0.0, atol=1e-14)


def test_angles_of_a_hinge_and_which_rows_are_angles():
    hinge = JOINTS["hinge"]
    turned = (POSES[1][0], POSES[1][1] @ exp_so3([0.6, 0.0, 0.0]))
    assert hinge.angle((turned, POSES[1])) == pytest.approx(0.6)
    assert hinge.angular.tolist() == [False] * 3 + [True] * 5
    assert JOINTS["rod"].angular.tolist() == [False]
