"""Schemes: how they are chosen, what a stage changes, and what they are called."""

from dataclasses import replace

import numpy as np
import pytest

from hybrid.scene import Time
from hybrid.scheme import Scheme
from hybrid.state import BodyState, Points, State
from hybrid.step.equations import for_increment

ALPHA, CONSERVING = Scheme.generalised_alpha(0.5), Scheme.energy_momentum()


@pytest.mark.parametrize("options, scheme, name", [
    ({"scheme": "newmark"}, Scheme(0.25, 0.5), "Newmark, beta = 0.25, gamma = 0.5"),
    ({"beta": 0.5625, "gamma": 1.0}, Scheme(0.5625, 1.0), "Newmark, beta = 0.5625, gamma = 1"),
    ({"scheme": "generalised-alpha", "spectral_radius": 0.5}, ALPHA, "generalised-alpha, spectral radius 0.5"),
    ({"scheme": "generalised-alpha"}, Scheme.default(), "generalised-alpha, spectral radius 0, of bodies in flight 0.5"),
    ({"scheme": "generalised-alpha", "spectral_radius": 0.0}, Scheme.generalised_alpha(0.0),
     "generalised-alpha, spectral radius 0"),
    ({"scheme": "energy-momentum"}, CONSERVING, "energy-momentum"),
    ({"scheme": "energy-momentum", "inertia": False}, Scheme(inertia=False), "none, the scene is quasi-static"),
])
def test_the_scheme_of_a_scene_and_its_name(options, scheme, name):
    found = Scheme.of(Time(0.1, **options))
    assert found == scheme and str(found) == name


def test_a_stage_puts_a_pair_of_newmark_in_place_of_any_scheme():
    dissipative = Scheme(0.5625, 1.0)
    for scheme in (Scheme.newmark(), ALPHA, CONSERVING):
        assert scheme.with_pair() is scheme
        assert scheme.with_pair(0.5625, 1.0) == dissipative
        assert scheme.with_pair(beta=0.3) == Scheme(0.3, 0.5)      # not the gamma of another rule
    assert dissipative.with_pair(beta=0.6) == Scheme(0.6, 1.0)
    assert not Scheme(inertia=False).with_pair(0.5625, 1.0).inertia


@pytest.mark.parametrize("rho", [0.0, 0.3, 0.8, 1.0])
def test_generalised_alpha_is_of_second_order_and_stable(rho):
    """Chung and Hulbert: γ = 1/2 - αm + αf, αm <= αf <= 1/2, β >= 1/4 + (αf - αm)/2."""
    s = Scheme.generalised_alpha(rho)
    assert s.gamma == pytest.approx(0.5 - s.alpha_m + s.alpha_f) and s.alpha_m <= s.alpha_f <= 0.5
    assert s.beta >= 0.25 + 0.5 * (s.alpha_f - s.alpha_m) - 1e-15


def test_only_generalised_alpha_carries_an_algorithmic_acceleration():
    increment, rate, second, algorithmic = np.random.default_rng(1).normal(size=(4, 5, 3))
    for scheme in (Scheme.newmark(), CONSERVING, Scheme(inertia=False)):
        with_it, without = (scheme.advance(increment, rate, second, a, 0.1) for a in (algorithmic, None))
        assert with_it[2] is None and np.array_equal(with_it[1], without[1])
    assert ALPHA.advance(increment, rate, second, algorithmic, 0.1)[2].shape == (5, 3)
    from_true, from_nothing = (ALPHA.advance(increment, rate, second, a, 0.1) for a in (second, None))
    assert all(np.array_equal(a, b) for a, b in zip(from_true, from_nothing))


@pytest.mark.parametrize("scheme", [Scheme(0.3, 0.6), ALPHA, CONSERVING, Scheme(inertia=False)])
def test_factors_are_the_derivatives_of_the_rule(scheme):
    rate, second, algorithmic = 0.3, -1.0, 0.7
    plus, minus = (scheme.advance(du, rate, second, algorithmic, 0.1) for du in (0.5, -0.5))
    assert plus[0] - minus[0] == pytest.approx(scheme.rate_factor(0.1))
    assert plus[1] - minus[1] == pytest.approx(scheme.mass_factor(0.1))


def test_constant_acceleration_is_exact():
    for scheme in (Scheme(0.3, 0.6), ALPHA, replace(ALPHA, alpha_m=-0.3), CONSERVING):
        gain, second, _ = scheme.advance(0.1 * 2.0 + 0.5 * 0.1**2 * 3.0, 2.0, 3.0, None, 0.1)
        assert (gain, second) == pytest.approx((0.3, 3.0))


def driven(scheme, forces, increments, carry):
    """Velocities that a unit mass has at the start and, after `forces` in increments of any length, when the last impulse
    has been given; carry: f(v̇, a, ratio of increments) for a."""
    rate, second, algorithmic, last = 0.3, forces[0], forces[0], None
    for force, dt in zip([*forces, *100 * [0.0]], [*increments, *100 * [increments[-1]]]):
        algorithmic = algorithmic if last is None else carry(second, algorithmic, dt / last)
        increment = (force - scheme.advance(0.0, rate, second, algorithmic, dt)[1]) / scheme.mass_factor(dt)
        gain, second, algorithmic = scheme.advance(increment, rate, second, algorithmic, dt)
        rate, last = rate + gain, dt
    return rate


@pytest.mark.parametrize("rho", [0.0, 0.3, 0.8])
def test_an_impulse_counts_for_what_it_is_in_increments_of_any_length(rho):
    """The trapezoidal rule for the forces, to round-off. The broken variant: a stays as it is."""
    rng, scheme = np.random.default_rng(4), Scheme.generalised_alpha(rho)
    forces, increments = rng.normal(size=12), rng.choice([0.5, 1.0, 2.0], size=12)
    ends = np.array([forces[0], *forces, 0.0])
    impulse = 0.5 * np.array([*increments, increments[-1]]) @ (ends[:-1] + ends[1:])
    assert driven(scheme, forces, increments, scheme.following) == pytest.approx(0.3 + impulse, abs=1e-9)
    assert abs(driven(scheme, forces, increments, lambda v, a, ratio: a) - 0.3 - impulse) > 0.005


def test_soil_and_bodies_keep_what_is_to_come_in_an_increment_half_as_long():
    rng, scheme = np.random.default_rng(5), Scheme.generalised_alpha(0.0)
    position, velocity, acceleration, algorithmic = rng.normal(size=(4, 6, 3))
    affine, none = rng.normal(size=(6, 3, 3, 3)), np.zeros((6, 3, 3))
    points = Points(position, velocity, acceleration, np.ones((6, 3)), none, none, none, np.zeros(6), algorithmic, affine)
    body = BodyState(np.zeros(3), np.eye(3), *rng.normal(size=(4, 3)), algorithmic=rng.normal(size=6))
    state = State(0.2, 1, points, [body], [], increment=0.2)
    new = for_increment(scheme, state, 0.1)
    second = np.concatenate([body.acceleration, body.spin_rate])
    for found, before, rate in ((new.points.algorithmic, algorithmic, acceleration),
                                (new.points.affine[:, 2], affine[:, 2], affine[:, 1]),
                                (new.bodies[0].algorithmic, body.algorithmic, second)):
        np.testing.assert_allclose(found - rate, 2.0 * (before - rate))
    np.testing.assert_array_equal(new.points.affine[:, :2], affine[:, :2])
    assert for_increment(scheme, state, 0.2) is state and for_increment(Scheme.newmark(), state, 0.1) is state
    first = replace(state, increment=0.0)
    assert for_increment(scheme, first, 0.1) is first
