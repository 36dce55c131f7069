"""Coulomb friction against closed forms on a held plane: incline, creep, an oscillator, a sphere set down spinning.

A stuck contact is a spring k = ε_T/ε_N p_f E A, so a block let go suddenly on a slope first swings, x'' = g_t - k x/m,
and slides from where the spring carries μ N; in the limit k -> ∞ that is a = max(0, g (sin θ - μ cos θ)).
"""

from dataclasses import replace

import numpy as np
import pytest

from hybrid.scene import Pull
from hybrid.setup.build import build
from hybrid.study.scenes import SCHEMES, box, plane, sphere

G, MU, SETTLE = 9.81, 0.3, 30
PLACES = pytest.mark.parametrize("contact", ["faces", "corners"])


class Slide:
    """A block of 4 x 4 m on a plane of 1 x 1 m with p_f E A = 1 MN/m, turned by `slope` = tan θ, from when it is let
    go."""

    def __init__(self, slope, contact="faces", steps=200, step=0.002, tangential=0.5, speed=0.0,
                 time=(), **body):
        angle = np.arctan(slope)
        body = box(4.0, 4.0, 0.25 / 16, rest_on=0.0, penalty=1.0, contact=contact, friction=MU, tangential=tangential,
                   held=("y", "rx", "ry", "rz"), **body)
        simulation = build(plane(body, steps, step, cells=(4, 4), settle=SETTLE,
                                 gravity=(G * np.sin(angle), 0.0, -G * np.cos(angle)), solver={"tolerance": 1e-8},
                                 time=time))
        records = []
        for record in simulation.steps():
            if record.stage == "run":
                records.append(record)
            elif record.stage_step == SETTLE:      # let go with the speed wanted
                simulation.state.bodies[0] = replace(
                    simulation.state.bodies[0], velocity=np.array([speed, 0.0, 0.0]))
        self.mass, self.normal = simulation.masses[0].mass, simulation.masses[0].mass * G * np.cos(angle)
        self.down, self.stiffness = G * np.sin(angle), tangential * 1e6
        start = records[0].time - step
        self.time = np.array([r.time - start for r in records])
        self.x = np.array([r.bodies[0].position[0] for r in records])
        self.v = np.array([r.bodies[0].velocity[0] for r in records])
        self.friction = np.array([r.energies["friction"] for r in records])

    def let_go(self):
        """Time, place and speed at which it begins to slide, and the acceleration from there on."""
        omega, limit = np.sqrt(self.stiffness / self.mass), MU * self.normal / self.stiffness
        static = self.mass * self.down / self.stiffness
        time = np.arccos(1 - limit / static) / omega
        return time, limit, static * omega * np.sin(omega * time), self.down - MU * self.normal / self.mass


@PLACES
def test_block_slides_above_the_threshold(contact):
    """Speed and way after 0.4 s, and friction work = μ N times the way slid."""
    found = Slide(0.5, contact)
    time, place, speed, acceleration = found.let_go()
    left = found.time[-1] - time
    assert found.v[-1] == pytest.approx(speed + acceleration * left, rel=2e-3)
    slid = speed * left + 0.5 * acceleration * left**2
    assert found.x[-1] - place == pytest.approx(slid, rel=3e-3)
    assert found.friction[-1] == pytest.approx(MU * found.normal * slid, rel=3e-3)


@pytest.mark.slow
def test_the_stiffer_the_spring_the_closer_to_the_law():
    """Speed after 0.4 s against g (sin θ - μ cos θ) t: what is missed falls as k^(-1/2)."""
    missed = []
    for tangential in (0.5, 8.0):
        found = Slide(0.5, tangential=tangential, step=0.0005, steps=400)
        missed.append(found.v[-1] / (found.let_go()[3] * found.time[-1]) - 1)
    assert missed[0] / missed[1] == pytest.approx(4.0, rel=0.1)


@PLACES
def test_block_keeps_its_speed_at_the_threshold(contact):
    """tan θ = μ: a block of 1 m/s goes on at 1 m/s, but for the way μ N/k over which the spring is stretched.

    Newmark's scheme; in the default one each acceleration still has a part of the one before (the next test)."""
    found = Slide(MU, contact, speed=1.0, time=SCHEMES["newmark"])
    after = found.v[found.x > 2 * MU * found.normal / found.stiffness]
    assert np.ptp(after) < 1e-4
    assert after[-1] == pytest.approx(1.0, abs=5e-3)


def test_in_the_default_scheme_the_threshold_is_reached_within_steps():
    """From the stretched spring on the speed settles to 1e-4 in ten steps, at 1 m/s to 0.3 %."""
    found = Slide(MU, speed=1.0)
    after = np.flatnonzero(found.x > 2 * MU * found.normal / found.stiffness)[10:]
    assert np.ptp(found.v[after]) < 1e-4
    assert found.v[-1] == pytest.approx(1.0, abs=5e-3)


@pytest.mark.parametrize("contact", ["faces", pytest.param("corners", marks=pytest.mark.slow)])
def test_stuck_block_does_not_creep(contact):
    """tan θ < μ/2: it swings between 0 and 2 m g sin θ/k <= μ N/k for 25 periods of 14 steps; nothing slips.

    Newmark's scheme keeps the swing, the default one lets it die out at the middle, to 2.5 % of it."""
    found = Slide(0.4 * MU, contact, steps=350, step=0.01)
    middle = found.mass * found.down / found.stiffness
    assert found.x[-20:] == pytest.approx(middle, rel=0.03) and found.friction[-1] == 0.0
    found = Slide(0.4 * MU, contact, steps=350, step=0.01, time=SCHEMES["newmark"])
    swing = 2 * found.mass * found.down / found.stiffness
    assert found.x.max() == pytest.approx(swing, rel=0.03)
    assert -1e-3 * swing < found.x.min() and found.x.max() < MU * found.normal / found.stiffness
    assert found.x[-100:].max() == pytest.approx(found.x[:100].max(), rel=1e-2)
    assert found.friction[-1] == 0.0


@PLACES
def test_block_comes_to_rest_below_the_threshold(contact):
    """μ/2 < tan θ < μ: let go suddenly it slides v²/(2 |a|) past the place where sliding begins, then sticks."""
    found = Slide(0.6 * MU, contact, steps=100)
    _, place, speed, acceleration = found.let_go()
    slid = speed**2 / (-2 * acceleration)
    assert found.x.max() == pytest.approx(place + slid, rel=5e-3)
    assert found.friction[-1] == pytest.approx(MU * found.normal * slid, rel=1e-2)
    assert found.friction[-1] == found.friction[60]


@PLACES
def test_every_reversal_costs_the_same_amplitude(contact):
    """A block on a spring of 20 kN/m swings from x_n to -(x_n - 2 μ N/k) and stops within μ N/k of the middle."""
    spring, speed = 20e3, 2.0
    found = Slide(0.0, contact, steps=340, step=0.005, tangential=10.0, speed=speed, pull=Pull(
        point=(0.0, 0.0, 0.0), velocity=(0.0, 0.0, 0.0), stiffness=spring, length=50.0, direction=(1.0, 0.0, 0.0),
        tension_only=False))
    band = MU * found.normal / spring
    peaks = [-band + np.sqrt(band**2 + found.mass / spring * speed**2)]
    while abs(peaks[-1]) > band:
        peaks.append(-np.sign(peaks[-1]) * (abs(peaks[-1]) - 2 * band))
    turns = found.x[1:-1][np.diff(np.sign(np.diff(found.x))) != 0]
    assert len(peaks) >= 3
    np.testing.assert_allclose(turns[:len(peaks)], peaks, atol=0.02 * peaks[0])
    assert np.ptp(found.x[-40:]) < 2 * MU * found.normal / found.stiffness


# ------------------------------------------------------------------ a sphere set down spinning

RADIUS, SPIN = 0.25, 20.0


class SpinningSphere:
    """A sphere of RADIUS and SPIN about y, set down where its weight is carried: slips to x until it rolls."""

    def __init__(self, step, steps, facets):
        weight, stiffness = 1000 * 4 / 3 * np.pi * RADIUS**3 * G, 4e8
        sunk = np.sqrt(weight / (stiffness * np.pi * RADIUS))      # volume of a cap, π R δ², under p_f E
        body = sphere(RADIUS, facets, rest_on=-sunk, spin=(0.0, SPIN, 0.0), friction=MU, penalty=1.0,
                      tangential=2.0)
        simulation = build(plane(body, steps, step, cells=(12, 4), stiffness=stiffness, gravity=(0.0, 0.0, -G),
                                 solver={"tolerance": 1e-7}, time={"beta": 0.5625, "gamma": 1.0}))
        records, self.sliding = [], []
        for record in simulation.steps():
            records.append(record)
            self.sliding.append(np.mean(simulation.evaluation.contacts[0].slip))
        self.mass, inertia = simulation.masses[0].mass, simulation.model.bodies[0].mass.inertia[1, 1]
        self.ratio = inertia / (self.mass * RADIUS**2)     # 2/5 of the sphere
        self.time = np.array([r.time for r in records])
        self.v = np.array([r.bodies[0].velocity[0] for r in records])
        self.friction = records[-1].energies["friction"]
        spin = simulation.state.bodies[0]
        self.spin = (spin.rotation @ spin.spin)[1]

    def law(self):
        """Time and speed at which slip turns into rolling, t* = 2rω/(7μg) and v* = 2rω/7 of a true sphere, and the
        energy lost until then. From then on nothing changes."""
        time = RADIUS * SPIN / (MU * G * (1 + 1 / self.ratio))
        speed = MU * G * time
        return time, speed, 0.5 * self.mass * (self.ratio * (RADIUS * SPIN)**2 - (1 + self.ratio) * speed**2)


def test_a_sphere_set_down_spinning_slips_until_it_rolls():
    """Facets of r/10: sticks 10 ms (two steps) after t*, speed +0.4 %, spin +0.6 % (the overlap takes 0.6 % of the
    radius), friction work -0.2 %."""
    found = SpinningSphere(0.005, 160, 0.025)
    time, speed, lost = found.law()
    sliding, rolling = found.time < time - 0.02, found.time > time + 0.03
    assert np.min(np.array(found.sliding)[sliding]) == 1.0 and np.mean(np.array(found.sliding)[rolling]) < 0.1
    assert np.interp(time / 2, found.time, found.v) == pytest.approx(speed / 2, rel=5e-3)
    assert found.v[rolling] == pytest.approx(speed, rel=1e-2)
    assert found.spin * RADIUS == pytest.approx(speed, rel=1e-2)
    assert found.friction == pytest.approx(lost, rel=1e-2)
