"""Pull line: residual is the gradient of the energy, tangent that of the residual; what it refuses."""

import numpy as np
import pytest
from differences import central

from hybrid.body.attitude import exp_so3
from hybrid.body.line import line_force
from hybrid.runtime.errors import StepError

POSITION, ROTATION = np.array([0.3, -0.2, 0.5]), exp_so3([0.5, -0.9, 0.3])
ATTACHMENT, TARGET = np.array([0.8, 0.1, -0.4]), np.array([4.0, 1.0, 0.7])
STIFFNESS = 2.0e4
DISTANCE = np.linalg.norm(POSITION + ROTATION @ ATTACHMENT - TARGET)


def line(step=np.zeros(6), length=0.9 * DISTANCE, tension_only=True):
    position, rotation = POSITION + step[:3], exp_so3(step[3:]) @ ROTATION
    return line_force(position, rotation, ATTACHMENT, TARGET, length, STIFFNESS, tension_only)


@pytest.mark.parametrize("factor, tension_only", [(0.9, True), (0.3, True), (0.9, False), (1.2, False)])
def test_residual_and_tangent_by_differences(factor, tension_only):
    length = factor * DISTANCE
    tension, residual, tangent, energy = line(length=length, tension_only=tension_only)
    assert tension == pytest.approx(STIFFNESS * (DISTANCE - length))
    assert energy == pytest.approx(0.5 * STIFFNESS * (DISTANCE - length) ** 2)
    gradient = central(lambda q: line(q, length, tension_only)[3], 6)
    fd = central(lambda q: line(q, length, tension_only)[1], 6)
    assert np.abs(residual - gradient).max() < 1e-8 * np.abs(residual).max()
    assert np.abs(tangent - fd).max() < 1e-8 * np.abs(tangent).max()


def test_taylor_remainder_is_second_order():
    _, residual, tangent, _ = line()
    direction = np.random.default_rng(0).normal(size=6)
    steps = 0.05 * 0.5 ** np.arange(5)
    remainders = [np.linalg.norm(line(h * direction)[1] - residual - h * tangent @ direction) for h in steps]
    assert np.polyfit(np.log(steps), np.log(remainders), 1)[0] > 1.95


def test_pulls_the_body_towards_the_target_along_the_line():
    _, residual, _, _ = line()
    end = POSITION + ROTATION @ ATTACHMENT
    force = -residual[:3]
    np.testing.assert_allclose(np.cross(force, TARGET - end), 0.0, atol=1e-9)
    assert force @ (TARGET - end) > 0
    np.testing.assert_allclose(-residual[3:], np.cross(end - POSITION, force), rtol=1e-12)


@pytest.mark.parametrize("factor", [1.0, 1.5])
def test_slack_line_does_nothing(factor):
    tension, residual, tangent, energy = line(length=factor * DISTANCE)
    assert tension == 0 and energy == 0 and not residual.any() and not tangent.any()


def test_coinciding_ends():
    end = POSITION + ROTATION @ ATTACHMENT
    args = (POSITION, ROTATION, ATTACHMENT, end, 2.0, STIFFNESS)
    tension, residual, tangent, energy = line_force(*args)
    assert tension == 0 and energy == 0 and not residual.any() and not tangent.any()
    with pytest.raises(StepError, match="no direction.*tension_only"):
        line_force(*args, tension_only=False)
