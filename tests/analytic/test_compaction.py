"""The compaction column of 50 m against Lambert's W (hybrid/study/precision/problems/column.py); see test_column.py."""

import functools

import numpy as np
import pytest

from hybrid.study.precision.problems import column as ladder

CELLS = (16, 32, 64, 128)
STANDARD = {"basis": "mpm", "domain": "none"}


@functools.cache
def settle(column, cells, **options):
    found = ladder.settle(column, cells, **options)
    assert found.increments == column.steps     # none was halved
    return found


def orders(column, **options):
    """Observed orders of stress and height over all cells."""
    found = [settle(column, n, **options) for n in CELLS]
    return ladder.rates(CELLS, [s.stress_error for s in found]), ladder.rates(CELLS, [s.height_error for s in found])


def test_reference_heights():
    assert ladder.STIFF.height() == pytest.approx(49.037991, abs=5e-7)
    assert ladder.SOFT.height() == pytest.approx(24.059646, abs=5e-7)
    assert ladder.SELF_WEIGHT.height() == pytest.approx(0.538602, abs=5e-7)


@pytest.mark.parametrize("column, stress, height", [(ladder.STIFF, 3e-4, 3e-7), (ladder.SOFT, 3e-4, 5e-5)],
                         ids=["1 MPa", "10 kPa"])
def test_on_128_cells(column, stress, height):
    """Error of the stress relative to the largest, of the height relative to the length."""
    found = settle(column, 128)
    assert found.stress_error < stress and found.height_error < height


def test_gimp_converges_under_small_strains():
    stress, _ = orders(ladder.STIFF)
    assert stress > 1.6


def test_gimp_converges_when_squeezed_to_a_half():
    """First order at least, though the lowest domains shrink to a fifth."""
    stress, height = orders(ladder.SOFT)
    assert stress > 1.2 and height > 1.2


@pytest.mark.parametrize("column", [ladder.STIFF, pytest.param(ladder.SOFT, marks=pytest.mark.slow)],
                         ids=["1 MPa", "10 kPa"])
def test_standard_points_do_not_converge(column):
    stress, height = orders(column, **STANDARD)
    assert stress < 0.1 and height < 0.1
    assert settle(column, 128, **STANDARD).stress_error > 50 * settle(column, 128).stress_error


def test_rigid_domains_settle_at_a_level():
    stress, _ = orders(ladder.SOFT, domain="none")
    assert stress < 0.2


def test_three_dimensions_agree():
    """Fifteen times the unknowns give the same numbers to round-off."""
    line, block = settle(ladder.SOFT, 16), settle(ladder.SOFT, 16, full=True)
    assert block.unknowns > 15 * line.unknowns
    assert block.height == pytest.approx(line.height, rel=1e-10)
    _, level = np.unique(np.round(block.Z, 9), return_inverse=True)
    np.testing.assert_allclose(block.stress, line.stress[np.argsort(line.Z)][level], atol=1e-8 * ladder.SOFT.weight)
