"""Half-widths of the points' domains as soil deforms."""

import numpy as np
import pytest

from hybrid.soil.domains import updated_half

AXES = (np.arange(9.0),) * 3
PLACE, HALF = np.full((1, 3), 4.5), np.array([[0.1, 0.2, 0.3]])
TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


@pytest.mark.parametrize("rule, expected", [("none", [0.1, 0.2, 0.3]), ("moments", [0.2, 0.2, 0.3])])
def test_a_domain_that_is_stretched_and_turned(rule, expected):
    """F = R U doubles the box along x, then turns it by 90 degrees about z: `moments` gives it as it lies."""
    F = (TURN @ np.diag([2.0, 1.0, 1.0]))[None]
    np.testing.assert_allclose(updated_half(rule, HALF, F, PLACE, AXES)[0], expected, rtol=1e-9)


def test_moments_keep_the_volume_of_the_domain():
    F = np.eye(3)[None] + 0.2 * np.random.default_rng(2).uniform(-1, 1, (1, 3, 3))
    half = updated_half("moments", HALF, F, PLACE, AXES)
    assert half.prod() == pytest.approx(np.linalg.det(F[0]) * HALF.prod(), rel=1e-12)


def test_a_domain_is_no_wider_than_its_cell_and_stays_inside_the_grid():
    F = np.diag([20.0, 1.0, 1.0])[None]
    assert updated_half("moments", HALF, F, PLACE, AXES)[0, 0] == 0.5
    assert updated_half("none", HALF, F, np.array([[4.5, 0.05, 4.5]]), AXES)[0, 1] == pytest.approx(0.05)
