"""Rate at which round bodies roll in the first guess of an increment without inertia."""

from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.step.rolling import rolling_rate

R, DRIVE = 0.5, np.array([0.1, 0.02, -0.01])


def rate(half_width, free=(True, True, True), curved=True, friction=0.3, drive=DRIVE):
    """Of a ball of radius R that touches ground over an arc of `half_width` [rad] about its lowest point."""
    angle = np.linspace(-half_width, half_width, 21)
    position = np.array([1.0, 2.0, R]) + R * np.stack([np.sin(angle), 0 * angle, -np.cos(angle)], axis=1)
    body = SimpleNamespace(free=np.array([True, True, True, *free]), drive=np.array([*drive, 0.0, 0.0, 0.0]),
                           friction=friction,
                           outline=SimpleNamespace(curved=np.array([curved])))
    history = SimpleNamespace(position=np.concatenate([position, [[9.0, 9.0, 9.0]]]),
                              touching=np.array([True] * 21 + [False]))
    return rolling_rate(body, SimpleNamespace(position=np.array([1.0, 2.0, R])), history)


def test_the_lowest_point_of_a_ball_stands_still():
    found = rate(0.01)
    np.testing.assert_allclose(found[3:], [-DRIVE[1] / R, DRIVE[0] / R, 0.0], rtol=1e-4)
    assert not found[:3].any()


@pytest.mark.parametrize("changes", [{"half_width": 1.5}, {"free": (False, False, False)}, {"curved": False},
                                     {"friction": 0.0},
                                     {"drive": (0.0, 0.0, 0.0)}, {"free": (True, False, True)}])
def test_bodies_that_slide_are_not_turned(changes):
    """Buried to the axis; kept from turning, or from turning along their way; blocks; smooth; not drawn along."""
    assert not rate(**{"half_width": 0.1} | changes).any()
