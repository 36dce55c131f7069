"""The demo of a drawing with two densities, cut in half: its mass, and the period in which it rocks."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

import hybrid
from hybrid.runtime.data import DEMOS
from hybrid.setup.build import build

RADIUS, LEVEL, GRAVITY = 0.25, -0.1, 9.81     # [m] of the ball and the ballast's surface; [m/s²]
DENSITIES = ((-RADIUS, LEVEL, 3000.0), (LEVEL, RADIUS, 500.0))


def moments():
    """Mass [kg], depth [m] of its centre below the middle, and moment of inertia [kg m²] there, of the whole ball."""
    def whole(of):
        return sum(quad(lambda z, rho=rho: rho * np.pi * (RADIUS**2 - z**2) * of(z), low, high)[0]
                   for low, high, rho in DENSITIES)

    mass, depth = whole(lambda z: 1.0), -whole(lambda z: z) / whole(lambda z: 1.0)
    return mass, depth, whole(lambda z: (RADIUS**2 - z**2) / 4 + z**2) - mass * depth**2


def upright(angle, mass, depth, inertia):
    """Times [s] at which a ball that rolls without slipping is upright, from a lean of `angle` [rad] at rest."""
    def rates(_, y):
        lean, rate = y
        total = inertia + mass * (RADIUS**2 + depth**2 - 2 * RADIUS * depth * np.cos(lean))
        return rate, -mass * depth * np.sin(lean) * (GRAVITY + RADIUS * rate**2) / total

    return solve_ivp(rates, (0.0, 3.2), (angle, 0.0), rtol=1e-10, atol=1e-12, events=lambda t, y: y[0]).t_events[0]


def test_it_rocks_with_the_period_of_its_two_densities():
    simulation = build(hybrid.load_scene(DEMOS / "wobbler.toml"))
    mass, depth, inertia = moments()
    body = simulation.model.bodies[0]
    assert 2 * body.mass.mass == pytest.approx(mass, rel=1e-4)
    times, leans = [], []
    for record in simulation.steps():
        w, _, y, _ = record.bodies[0].quaternion
        times.append(record.time)
        leans.append(2 * np.arctan2(y, w))
    times, leans = np.array(times), np.array(leans)
    at = np.flatnonzero(np.sign(leans[1:]) != np.sign(leans[:-1]))
    found = times[at] - leans[at] * (times[at + 1] - times[at]) / (leans[at + 1] - leans[at])
    exact = upright(np.radians(10.0), mass, depth, inertia)
    assert found == pytest.approx(exact, rel=2e-3) and len(found) == 4
    assert np.ptp(found[::2]) == pytest.approx(np.ptp(exact[::2]), rel=1e-3)
    assert np.abs(leans).max() == pytest.approx(np.radians(10.0), rel=1e-3)
