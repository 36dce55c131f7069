"""Principal values and directions of symmetric matrices, many at a time."""

import numpy as np
import pytest

from hybrid.soil.principal import LANES, from_principal, principal


def symmetric(n, scale, seed=0):
    a = np.random.default_rng(seed).standard_normal((n, 3, 3))
    return np.eye(3) + scale * (a + a.swapaxes(1, 2))


@pytest.mark.parametrize("n", (0, 1, LANES - 1, LANES, 3 * LANES + 5))
@pytest.mark.parametrize("scale", (1e-9, 1e-3, 1.0, 1e8))
def test_values_are_those_of_lapack_and_directions_build_the_matrix(n, scale):
    matrices = symmetric(n, scale)
    values, directions = principal(matrices)
    size = np.abs(matrices).max(initial=1.0)
    np.testing.assert_allclose(np.sort(values, axis=1), np.linalg.eigvalsh(matrices), atol=4e-15 * size)
    np.testing.assert_allclose(from_principal(values, directions), matrices, atol=1e-14 * size)
    identity = np.broadcast_to(np.eye(3), (n, 3, 3))
    np.testing.assert_allclose(directions.swapaxes(1, 2) @ directions, identity, atol=4e-15)


@pytest.mark.parametrize("values", ((2.0, 2.0, 2.0), (1.0, 3.0, 3.0), (0.0, 0.0, 0.0), (1.0, 1.0 + 1e-13, 5.0)))
def test_repeated_values_are_exact(values):
    """Closed formulas lose half of the digits here."""
    turn = np.linalg.qr(symmetric(1, 1.0)[0])[0]
    found, _ = principal(((turn * values) @ turn.T)[None])
    np.testing.assert_allclose(np.sort(found[0]), np.sort(values), atol=3e-15 * max(1.0, max(values)))


def test_a_matrix_does_not_depend_on_its_neighbours():
    """All lanes take the sweeps of the slowest; more of them leave a diagonal matrix as it is."""
    matrices = symmetric(LANES, 1.0)
    matrices[3] = np.diag([3.0, 1.0, 2.0])
    values, directions = principal(matrices)
    np.testing.assert_array_equal(values[3], [3.0, 1.0, 2.0])
    np.testing.assert_array_equal(directions[3], np.eye(3))
