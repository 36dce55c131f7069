"""Errors of joints in an increment: what is within the tolerance, and what is not."""

import numpy as np
import pytest

from hybrid.body.joints import Joint
from hybrid.step.joint_terms import JointStep

LINE = Joint("rope", (0, 1), np.zeros((2, 3)), False, length=2.0, slack=True)
STIFFNESS, RADIUS = 1e12, 0.2


def error(distance, multiplier):
    """Of a rope of 2 m between two bodies at a `distance` [m] that pulls with a force [N]."""
    one = np.array([1.0])
    step = JointStep((LINE,), np.arange(12)[None], np.zeros(1), np.zeros(1), np.array([True]), np.array(LINE.bounds),
                     STIFFNESS * one, STIFFNESS, RADIUS * one, 12)
    poses = tuple((np.array([x, 0.0, 0.0]), np.eye(3)) for x in (0.0, distance))
    return step.evaluate(poses, multiplier * one).error()


@pytest.mark.parametrize("force, expected", [(0.0, 0.0), (1e-50, 0.0), (-1e-50, 0.0), (100.0, 1.0)])
def test_a_rope_that_has_gone_slack_pulls_with_nothing_but_round_off(force, expected):
    """A ball on a rope that hit a block was stopped: 1e-59 N were far more than a share of the largest force, 1e-59 N."""
    assert error(1.999, force) == expected


def test_a_taut_rope_may_be_longer_by_a_share_of_the_radius():
    assert error(2.0 + 1e-3 * RADIUS * 1e-4, 100.0) == pytest.approx(1e-4, rel=1e-6)
