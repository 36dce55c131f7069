"""The demo of a drawing with two densities, cut in half: its mass, and the period in which it rocks."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

import hybrid
from hybrid.runtime.data import DEMOS
from hybrid.runtime.errors import StepError
from hybrid.scene import Load, Time
from hybrid.setup import contact, on_ground, penalty
from hybrid.setup.build import build
from hybrid.study.scenes import box, plane

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


WEIGHT = 2000.0 * 0.4**2 * GRAVITY      # of a box 1 m high


def pushed(x, **time):
    """Scene of a box of 0.4 x 0.4 x 1 m at x [m] on held ground, pushed at its centre by a force that grows to 0.6 of its
    weight in 4 s."""
    block = box(0.4, 0.4, 1.0, density=2000.0, position=(x, 0.01, 0.0), rest_on=0.0, friction=0.8)
    scene = plane(block, 200, 0.02, stiffness=1e7, gravity=(0.0, 0.0, -GRAVITY), cells=(16, 8))
    push = Load(force=((0.0, 0.0, 0.0, 0.0), (4.0, 0.6 * WEIGHT, 0.0, 0.0)))
    return replace(scene, stages=(replace(scene.stages[0], loads=(push,)),), time=Time(0.02, **time))


def tips(x):
    """Share of its weight at which it leans by a quarter of a degree."""
    simulation = build(pushed(x))
    for record in simulation.steps():
        if simulation.state.bodies[0].rotation[2, 2] < np.cos(np.radians(0.25)):
            return 0.15 * record.time


def test_a_box_tips_at_the_same_load_wherever_it_stands(monkeypatch):
    """W b/h = 0.4, and a fifth of a second in which it leans by a quarter of a degree: 0.43. On points of the ground, 13
    across, 0.34 to 0.40."""
    found = [tips(x) for x in (0.03, 0.036)]
    assert np.ptp(found) < 1e-9 and 0.4 < min(found) < 0.44
    monkeypatch.setattr(on_ground, "is_made_for", lambda *given: False)
    monkeypatch.setattr(contact, "ACROSS", 0)
    monkeypatch.setattr(penalty, "standing_stiffness", lambda *given: 0.0)
    assert np.ptp([tips(x) for x in (0.03, 0.036)]) > 0.03


def test_a_box_that_topples_without_inertia_names_its_load():
    simulation = build(pushed(0.03, inertia=False))
    with pytest.raises(StepError, match="The load exceeds what holds the body, which slides or topples: that on body had"):
        list(simulation.steps())
    assert 0.33 < 0.15 * simulation.state.time < 0.41
