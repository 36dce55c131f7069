"""A symmetric top that spins fast about a fixed point under its weight: order, energy and vertical momentum.

    J3 W3 = const    π_z = J1 sin²θ ψ' + J3 W3 cosθ = const    E = ½ J1 (θ'² + sin²θ ψ'²) + ½ J3 W3² + P cosθ = const

so that u = cosθ goes between two roots of a cubic, u'² = f(u) (Landau and Lifshitz, Mechanics, sec. 35): from rest of
the axis at u0 the top nods to u1 and back in the time 2 ∫ du/√f. P is weight times arm; inertia, moment and driver
are about the fixed point (hybrid/study/precision/problems/tumbling.py).
"""

from dataclasses import replace

import numpy as np
import pytest
from demo_scripts import demo
from scipy.integrate import quad

from hybrid.body import motion
from hybrid.body.attitude import log_so3, right_tangent
from hybrid.body.motion import inertia_residual, momentum_rate
from hybrid.study.precision.problems import tumbling
from hybrid.study.precision.settings import PUBLISHED

DEMO = demo("tumbling")
TOP, DURATION = tumbling.HEAVY, 1.2
ENERGY_MOMENTUM = tumbling.SCHEMES["energy-momentum"]
CASES = [pytest.param(scheme, order, id=name)
         for (name, scheme), order in zip(tumbling.SCHEMES.items(), DEMO.ORDERS)]


def nodding(top):
    """Lowest u = cosθ and the time [s] to get there, for a top whose axis starts at rest."""
    j1, _, j3 = np.diag(top.inertia)
    weight, spin, u0 = -top.force[2] * top.arm[2], top.spin[2], top.rotation[2, 2]

    def bracket(u):     # u'² = (u0 - u) [2 P (1 - u²) - (J3 W3)² (u0 - u)/J1]/J1
        return (2 * weight * (1 - u * u) - (j3 * spin) ** 2 * (u0 - u) / j1) / j1

    roots = np.roots([-2 * weight, (j3 * spin) ** 2 / j1, 2 * weight - (j3 * spin) ** 2 * u0 / j1])
    u1 = roots[(roots > -1) & (roots < u0)].max()
    middle, half = (u0 + u1) / 2, (u0 - u1) / 2
    # u = middle - half cos x takes the square roots out of both ends
    time = quad(lambda x: half * np.sin(x) / np.sqrt(half * (1 + np.cos(x)) * bracket(middle - half * np.cos(x))),
                0, np.pi)[0]
    return u1, time


def test_reference_nods_as_the_closed_form():
    lowest, time = nodding(TOP)
    spin, rotation = tumbling.reference(TOP, time)
    assert rotation[2, 2] == pytest.approx(lowest, abs=1e-11) and lowest < TOP.rotation[2, 2] - 0.02
    spin, rotation = tumbling.reference(TOP, 2 * time)
    assert rotation[2, 2] == pytest.approx(TOP.rotation[2, 2], abs=1e-11)
    assert np.abs(rotation @ [spin[0], spin[1], 0.0]).max() < 1e-9 and spin[2] == pytest.approx(10.0, abs=1e-11)
    assert time < DURATION                                     # orders are seen beyond the lowest point


def observed(scheme, counts=(100, 200), **broken):
    error = tumbling.errors(TOP, DURATION, counts, scheme, **broken)
    return np.array([DEMO.order(counts, error[:, i]) for i in (0, 1)])


@pytest.mark.parametrize("scheme, order", CASES)
def test_attitude_and_spin_converge_with_the_order_of_the_scheme(scheme, order):
    assert observed(scheme) == pytest.approx([order, order], abs=0.1)


def moment_at_the_end(mass, inertia, state, *step):
    """The broken variant of energy-momentum: the gain of angular momentum from the moment at the end alone."""
    residual, tangent = inertia_residual(mass, inertia, state, *step)
    residual[3:] = (residual[3:] + momentum_rate(inertia, state)) / 2
    tangent[3:, 3:] /= 2
    return residual, tangent


def test_an_order_is_lost_without_the_mean_of_the_moments():
    assert (observed(ENERGY_MOMENTUM, inertia_of=moment_at_the_end) < (1.7, 1.3)).all()


def check_conservation(steps):
    largest, _ = DEMO.drift(TOP, 0.01, steps, ENERGY_MOMENTUM)
    assert (largest < 1e-10).all()


def test_energy_momentum_keeps_energy_and_vertical_momentum():
    check_conservation(500)


@pytest.mark.slow
def test_energy_momentum_keeps_them_over_ten_thousand_steps():
    check_conservation(10_000)


@pytest.mark.slow
@pytest.mark.parametrize("name, energy, momentum", [
    (PUBLISHED, 2e-5, 2e-4), ("generalised α, ρ∞ = 0.8", 3e-5, 2e-4),
    ("generalised α, ρ∞ = 0.5", 3e-4, 2e-3)])
def test_drift_of_the_other_schemes(name, energy, momentum):
    largest, _ = DEMO.drift(TOP, 0.01, 10_000, tumbling.SCHEMES[name])
    assert energy / 10 < largest[0] < energy and momentum / 10 < largest[1] < momentum


def test_exponential_turns_do_not_keep_the_energy_of_the_top(monkeypatch):
    """Why the turn is Cayley's: with the logarithm the momentum stays, the energy does not."""
    monkeypatch.setattr(motion, "cayley_vector", log_so3)
    monkeypatch.setattr(motion, "cayley_rate", lambda turn: np.linalg.inv(right_tangent(turn)))
    largest, _ = DEMO.drift(TOP, 0.01, 200, ENERGY_MOMENTUM)
    assert largest[1] < 1e-10 < 1e-8 < largest[0]
    free = replace(TOP, force=np.zeros(3))
    assert (DEMO.drift(free, 0.01, 50, ENERGY_MOMENTUM)[0] < 1e-10).all()
