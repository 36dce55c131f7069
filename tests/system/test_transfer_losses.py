"""What is lost between points and grid, by transfer: the blocks of demos/transfers.py, for a shorter time."""

import numpy as np
import pytest
from demo_scripts import demo

DEMO = demo("transfers")


def test_affine_transfer_loses_least():
    """A quarter turn in 50 steps, and three periods of the swing: in both increments lose more.

    Lost of momentum, energy, swing: affine 0.001, 0.002, 0.03; increments 0.03, 0.05, 0.06.
    """
    lost = {name: (1 - np.array(DEMO.rotating(name, 50, turns=0.25)), 1 - DEMO.free(name, 96))
            for name in DEMO.TRANSFERS}
    (turning, swing), (more_turning, more_swing) = lost["affine"], lost["increments"]
    assert (0 < turning).all() and (turning < 0.1 * more_turning).all() and swing < 0.7 * more_swing


def test_dissipation_is_the_schemes_where_it_is_asked_for():
    """The dissipative pair takes the swing within three periods of 32 steps, the default a sixth of its energy, the
    others hardly anything."""
    assert DEMO.free("affine", 96, beta=0.5625, gamma=1.0) < 0.4
    assert DEMO.free("affine", 96) > 0.93
    assert DEMO.free("affine", 96, scheme="generalised-alpha", spectral_radius=0.8) > 0.93
    assert 0.8 < DEMO.free("affine", 96, scheme="generalised-alpha") < 0.9


@pytest.mark.slow
def test_figures_of_the_demo():
    for name, swing, momentum in (("increments", 0.806, 0.919), ("affine", 0.922, 0.996)):
        assert DEMO.free(name) == pytest.approx(swing, abs=0.02)
        assert DEMO.rotating(name)[0] == pytest.approx(momentum, abs=0.01)
