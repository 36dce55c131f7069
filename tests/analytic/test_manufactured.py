"""Manufactured solutions in one and three dimensions: orders in space and time.

The problem: hybrid/study/precision/problems/manufactured.py.
"""

import functools

import numpy as np
import pytest

from hybrid.study.precision.problems import manufactured as ladder

QUIET, LARGE, DRIFTING = ladder.Wave(1e-4), ladder.Wave(0.05), ladder.Wave(0.05, 5.0)
STANDARD = {"basis": "mpm", "domain": "none", "transfer": "increments"}


@functools.cache
def vibrate(wave, cells, **options):
    found = ladder.vibrate(wave, cells, 2 * cells, **options)
    assert found.increments == 2 * cells    # none was halved
    return found


def orders(wave, cells=(16, 32, 64), **options):
    """Observed orders of displacement and stress over the last halving, and the last Outcome."""
    coarse, fine = (vibrate(wave, n, **options) for n in cells[-2:])
    return np.log2([coarse.displacement / fine.displacement, coarse.stress / fine.stress]), fine


@pytest.mark.parametrize("solution", [ladder.Wave(0.05), ladder.Wave(0.05, 3.0)])
def test_body_force_in_closed_form(solution):
    """It is the divergence of the stress by differences."""
    X = np.random.default_rng(1).random((20, 3))
    exact = solution.divergence(0.01, X)
    np.testing.assert_allclose(ladder.Solution.divergence(solution, 0.01, X), exact, atol=1e-7 * np.abs(exact).max())


def test_swirl_has_no_traction_on_rollers():
    X = np.random.default_rng(2).random((20, 3))
    swirl = ladder.Swirl(0.1)
    for axis in range(3):
        X[:, axis], others = axis % 2, [i for i in range(3) if i != axis]
        assert np.abs(swirl.shape(X)[0][:, axis]).max() < 1e-15
        assert np.abs(swirl.stress(0.0, X)[:, axis, others]).max() < 1e-10 * ladder.YOUNG
        X = np.random.default_rng(axis).random((20, 3))


def test_quiet_points_have_the_orders_of_linear_elements():
    """Two in the displacement, one in the stress at points in the quarters of their cell; both methods."""
    for options in ({}, STANDARD):
        observed, fine = orders(QUIET, scheme=(("scheme", "newmark"),), **options)
        assert fine.crossed == 0
        assert 1.75 < observed[0] < 2.3 and observed[1] == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("wave", [LARGE, DRIFTING], ids=["shaken", "drifting"])
def test_moving_points_keep_second_order_with_gimp(wave):
    """Every point crosses 4 and 19 nodes; the stress gains an order by it."""
    observed, fine = orders(wave)
    assert fine.crossed > 4 and fine.displacement < 0.005 and fine.stress < 0.01
    assert observed == pytest.approx([2.0, 1.9], abs=0.15)


@pytest.mark.parametrize("wave", [LARGE, DRIFTING], ids=["shaken", "drifting"])
def test_moving_points_spoil_the_standard_method(wave):
    """No order is left, and the stress is ten times as wrong on the finest grid."""
    observed, fine = orders(wave, **STANDARD)
    assert (observed < 0.2).all() and fine.stress > 10 * vibrate(wave, 64).stress


def test_domains_that_do_not_stretch_settle_at_a_level():
    observed, fine = orders(LARGE, domain="none")
    assert observed[1] < 0.3 and fine.stress > 5 * vibrate(LARGE, 64).stress


def test_a_wrong_law_is_seen():
    """With the body force of P = E (F - 1/F)/2 instead of Hencky's nothing converges."""
    def neo_hookean(t, X):
        _, slope, bend = LARGE._along(X[:, 2]) * np.cos(LARGE.frequency * t)
        force = LARGE.motion(t, X)[2]
        force[:, 2] -= ladder.YOUNG / ladder.DENSITY * 0.5 * (1 + (1 + slope) ** -2) * bend
        return force

    observed, fine = orders(LARGE, force=neo_hookean)
    assert observed[0] < 0.5 and fine.displacement > 10 * vibrate(LARGE, 64).displacement


@pytest.mark.parametrize("scheme, wanted, counts, reference", [
    ({"scheme": "newmark"}, 2, (8, 16, 32), 192),
    ({"scheme": "generalised-alpha", "spectral_radius": 0.8}, 2, (8, 16, 32), 192),
    ({}, 2, (32, 64, 128), 512),
    ({"beta": 0.5625, "gamma": 1.0}, 1, (12, 24, 48), 384)], ids=["newmark", "alpha", "default", "pair"])
def test_order_in_time(scheme, wanted, counts, reference):
    """Against a fine step on the same grid of 64 cells, so that only the step is seen."""
    errors = ladder.in_time(QUIET, 64, counts, reference, tuple(scheme.items()))
    assert np.log2(errors[:-1] / errors[1:])[-1] == pytest.approx(wanted, abs=0.03)


@pytest.mark.parametrize("transfer, low, high", [("increments", 0.5, 1.4), ("affine", 1.8, 2.2)])
def test_order_in_time_on_coarse_grids(transfer, low, high):
    """Without their gradients accelerations are smoothed on the way there and back: an error of Δt (kh)², the larger
    part at 16 cells."""
    errors = ladder.in_time(QUIET, 16, (48, 96), 384, transfer=transfer)
    assert low < np.log2(errors[0] / errors[1]) < high and errors[1] < 1.5e-3


def test_swirl_in_three_dimensions():
    """From 4³ to 6³ cells: 1.6 and 1.5."""
    displacement, stress = swirl_orders(4, 6)
    assert displacement > 1.5 and stress > 1.3


@functools.cache
def swirl(cells, **options):
    return ladder.vibrate(ladder.Swirl(0.1), cells, 2 * cells, solver={"tolerance": 1e-7}, **options)


def swirl_orders(*cells, **options):
    """Observed orders of displacement and stress from one number of cells to another."""
    coarse, fine = (swirl(n, **options) for n in cells)
    gain = np.log([coarse.displacement / fine.displacement, coarse.stress / fine.stress])
    return gain / np.log(cells[1] / cells[0])


@pytest.mark.slow
def test_swirl_on_finer_cells():
    """From 8³ to 12³ cells, half a crossing a point: 1.9 and 1.7 with GIMP, 1.5 and 0.7 with standard points."""
    assert (swirl_orders(8, 12) > (1.8, 1.5)).all()
    displacement, stress = swirl_orders(8, 12, **STANDARD)
    assert 1.3 < displacement < 1.7 and 0.5 < stress < 1.0
    assert swirl(12, **STANDARD).stress > 1.5 * swirl(12).stress
