"""A pulse of small strain in a bar: speed, shape and energy (demos/ladder_wave.py)."""

import functools

import numpy as np
import pytest
from demo_scripts import demo

DEMO = demo("ladder_wave")


@functools.cache
def ride(cells, scheme="Newmark (1/4, 1/2)", **options):
    return DEMO.ride(cells, scheme=DEMO.SCHEMES[scheme], **options)


def order(coarse, fine):
    """Observed over a halving of the cells."""
    return np.log2(coarse / fine)


def test_speed_is_of_second_order():
    """It lags by 5.0 and 1.6 % at 3 and 6 cells to the pulse's width."""
    late = [1 - ride(n).speed() for n in (36, 72)]
    assert 0 < late[1] < 0.02 and order(*late) > 1.6


@pytest.mark.parametrize("wrong", [0.95, 1.05])
def test_another_speed_is_seen(wrong, monkeypatch):
    """The same ride against a speed that is wrong by 5 %: it does not converge to that."""
    rides = [ride(n) for n in (36, 72)]
    monkeypatch.setattr(DEMO, "SPEED", wrong * DEMO.SPEED)
    late = [abs(1 - r.speed()) for r in rides]
    assert order(*late) < 1.0


def test_shape_comes_back_upside_down():
    missed = [ride(n).missed() for n in (36, 72)]
    assert missed[1] < missed[0] and missed[1] < 0.25


@pytest.mark.slow
def test_energy_is_lost_in_the_transfer_alone():
    """Newmark's (1/4, 1/2) damps nothing. What the transfer loses falls faster than h²; it is never a gain. Affine
    transfer loses a third of what increments do at half the Courant number, whatever the step; theirs goes with Δt."""
    lost, by_increments = ([1 - ride(n, transfer=transfer).energy[-1] for n in (36, 72)]
                           for transfer in ("affine", "increments"))
    assert 0 < lost[1] < 0.02 and order(*lost) > 2.0 and order(*by_increments) > 2.0
    assert lost[1] < 0.5 * by_increments[1] < 0.03
    finer = [1 - ride(36, courant=0.25, transfer=transfer).energy[-1] for transfer in ("affine", "increments")]
    assert abs(order(lost[0], finer[0])) < 0.5 < order(by_increments[0], finer[1]) < 1.1
    assert all(ride(n).energy.max() == 1.0 for n in (36, 72))


def test_schemes_damp_as_they_should():
    """Generalised alpha hardly more than (1/4, 1/2) at ρ∞ = 0.8, more at 0; (0.5625, 1) takes most of the energy."""
    kept = {name: ride(36, name).energy[-1] for name in DEMO.SCHEMES}
    plain = kept["Newmark (1/4, 1/2)"]
    assert plain - 0.01 < kept["generalised α, ρ∞ = 0.8"] < plain
    assert plain - 0.3 < kept["generalised α, ρ∞ = 0"] < plain - 0.1
    assert kept["Newmark (0.5625, 1)"] < 0.3


def test_a_bar_in_three_dimensions_agrees():
    line, block = ride(36), ride(36, full=True)
    assert block.unknowns > 15 * line.unknowns
    assert np.abs(block.displacement - line.displacement).max() < 1e-7 * DEMO.AMPLITUDE
    assert np.abs(block.energy - line.energy).max() < 1e-9
