"""A line that cuts through soil: closed form against the differential equation, its small angles, its tangent."""

import numpy as np
import pytest
from differences import central
from scipy.integrate import solve_ivp

from hybrid.body.attitude import exp_so3
from hybrid.body.embedded_line import STEEPEST, LineSoil, embedded_line_force, shackle
from hybrid.body.line import line_force

CLAY = LineSoil(0.0, 11 * 5e3 * 0.15, 11 * 1.5e3 * 0.15, 0.15, 0.4)
SAND = LineSoil(0.0, 0.0, 15.0 * 9.3e3 * 0.15, 0.15, 0.35)


def by_integration(tension, angle, depth, soil):
    """The same from T dθ/ds = -Q, dT/ds = μ Q, dz/ds = -sin θ, from the mudline down."""
    def down(z, state):
        q = soil.load(z)[1]
        return [-soil.friction * q / np.sin(state[1]), q / (state[0] * np.sin(state[1]))]

    found = solve_ivp(down, (0.0, depth), [tension, max(angle, 1e-5)], rtol=1e-10, atol=1e-12, method="Radau")
    return found.y[:, -1]


@pytest.mark.parametrize("soil", [CLAY, SAND])
@pytest.mark.parametrize("angle", [0.15, 0.5])
@pytest.mark.parametrize("depth", [0.1, 1.0, 3.0])
def test_closed_form_against_the_differential_equation(soil, angle, depth):
    tension = 3e5
    expected = by_integration(tension, angle, depth, soil)
    np.testing.assert_allclose(shackle(tension, angle, soil.load(depth)[0], soil.friction), expected, rtol=1e-6)


def test_a_line_that_lies_on_the_mudline():
    np.testing.assert_allclose(shackle(3e5, 0.0, CLAY.load(2.0)[0], 0.4), by_integration(3e5, 0.0, 2.0, CLAY), rtol=1e-4)


def test_small_angles_are_those_of_neubecker_and_randolph():
    """T_a (θ_a² - θ_m²) = 2 z Q; the difference falls with the square of the angle, with friction in proportion."""
    errors = []
    for tension in (1e8, 4e8):
        load = CLAY.load(3.0)[0]
        at_shackle, steep = shackle(tension, 0.0, load, 0.0)
        errors.append(abs(at_shackle * steep**2 / (2 * load) - 1))
    assert errors[0] < 1e-3 and errors[1] == pytest.approx(errors[0] / 4, rel=0.05)


def test_a_line_with_little_tension_is_upright_at_the_shackle():
    tension, angle = shackle(1e3, 0.0, CLAY.load(3.0)[0], 0.4)
    assert angle == STEEPEST and tension == pytest.approx(1e3 * np.exp(-0.4 * STEEPEST))


POSITION, ROTATION, ATTACHMENT = np.array([0.3, -0.2, -1.5]), exp_so3([0.5, -0.9, 0.3]), np.array([0.8, 0.1, -0.4])


def line(step=np.zeros(6), height=0.4, stretch=0.9, soil=CLAY, lift=0.0):
    position, rotation = POSITION + step[:3] + [0.0, 0.0, lift], exp_so3(step[3:]) @ ROTATION
    return embedded_line_force(position, rotation, ATTACHMENT, np.array([9.0, 1.0, height]), stretch * 8.7, 2e5, soil)


@pytest.mark.parametrize("soil", [CLAY, SAND])
@pytest.mark.parametrize("height", [0.0, 2.4])
@pytest.mark.parametrize("stretch", [0.5, 0.8, 0.9])
def test_tangent_by_differences(soil, height, stretch):
    fd = central(lambda q: line(q, height, stretch, soil)[1], 6, h=1e-6)
    tangent = line(np.zeros(6), height, stretch, soil)[2]
    assert np.abs(tangent - fd).max() < 1e-6 * np.abs(tangent).max()


def test_above_the_mudline_it_is_straight():
    args = POSITION + [0.0, 0.0, 3.0], ROTATION, ATTACHMENT, np.array([9.0, 1.0, 0.4]), 7.8, 2e5
    for one, other in zip(embedded_line_force(*args, CLAY)[:3], line_force(*args)[:3]):
        np.testing.assert_array_equal(one, other)


def test_force_is_smaller_and_steeper_and_continuous_at_the_mudline():
    straight = line_force(POSITION, ROTATION, ATTACHMENT, np.array([9.0, 1.0, 0.4]), 0.9 * 8.7, 2e5)
    tension, residual, _, _ = line()
    assert tension < straight[0] and -residual[2] > -straight[1][2] > 0.0
    surface = -(POSITION + ROTATION @ ATTACHMENT)[2]
    below, above = (line(lift=surface + e)[1] for e in (-1e-7, 1e-7))
    np.testing.assert_allclose(below, above, rtol=1e-5, atol=1.0)
