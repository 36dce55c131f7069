"""Sphere on a held slope, Fig. 2a of Bird et al. (UKACM 2024): sliding and rolling against the law.

On the faces of domains, with nothing set but the physics, the law comes out at the paper's resolution. On the corners
of domains, as published, half a radius apart, the errors are those of a bumpy ride: the limits are 1.5 times what was
measured, for several facet sizes; at a quarter of the spacing, facets refined too, the law has to come out.
"""

import functools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from demo_scripts import demo

from hybrid.scene.file import load_scene
from hybrid.setup.build import build
from hybrid.simulation import Simulation

DEMOS = Path(__file__).parents[2] / "demos"
RADIUS, NORMAL_GRAVITY = 0.25, 9.81 * np.sqrt(0.5)
DEMO = demo("rolling_sphere")
FRICTION = DEMO.FRICTION


class Ride:
    """One second from a start shifted along the slope [m]: what the tests ask about."""

    def __init__(self, built, mu, shift):
        model = replace(built.model, bodies=(replace(built.model.bodies[0], friction=mu),))
        start = built.state.bodies[0].position + (shift, 0.0, 0.0)
        state = replace(built.state, bodies=[replace(built.state.bodies[0], position=start)])
        simulation = Simulation(built.scene, model, state, built.meshes)
        self.mass, self.sliding, self.force, self.air = model.bodies[0].mass.mass, [], np.zeros(3), 0
        for self.record in simulation.steps():
            touch = simulation.evaluation.contacts[0]
            self.air += len(touch) == 0
            self.sliding += list(touch.slip)
            self.force += self.record.bodies[0].contact_force
        motion = simulation.state.bodies[0]
        self.distance, self.speed = motion.position[0] - start[0], motion.velocity[0]
        self.spin = (motion.rotation @ motion.spin)[1]
        self.errors = np.abs(DEMO.errors(mu, *np.array([[1.0], [self.distance], [self.spin]])))
        self.energies = self.record.energies


@functools.cache
def built(refinement, faces=False):
    changes = DEMO.overrides(0.4, refinement) + ([] if faces else [*DEMO.corners(refinement), "body.0.tangential=2.0"])
    return build(load_scene(DEMOS / "rolling_sphere.toml", changes))


@functools.cache
def ride(refinement, mu, shift=0.0, faces=False):
    """Ride on corners or on faces from a start shifted by a fraction of the spacing of the corners, run once."""
    return Ride(built(refinement, faces), mu, shift * 0.125 / refinement)


def scatter(refinement, shifts=(0.0, 1 / 3, 2 / 3)):
    """Root mean square errors [%] of distance and spin over starts within one spacing and two μ."""
    errors = [ride(refinement, mu, shift).errors for mu in (0.2, 0.4) for shift in shifts]
    return np.sqrt(np.mean(np.square(errors), axis=0))


@pytest.mark.parametrize("mu, distance, spin", [
    (0.0, 2.1, 3.2), (0.1, 2.1, 3.2), (0.2, 2.3, 6.5), (0.4, 0.5, 2.9), (1.0, 1.5, 3.3)])
def test_paper_resolution(mu, distance, spin):
    """Measured: distance +0.6, +0.9, +1.5, -0.0, -1.0 %, spin +1.5 (of rolling), +0.5, -4.3, -1.9, +2.2 %; 5 to 9 steps
    in the air.
    With facets of 0.047 to 0.053 m at most 1.4, 1.4, 0.2 % and 2.1, 4.3, 1.9 %."""
    found = ride(1, mu)
    assert found.errors[0] < distance and found.errors[1] < spin
    assert found.air < 15


@pytest.mark.parametrize("mu", FRICTION)
def test_faces_at_the_paper_s_resolution(mu):
    """Measured: distance 0.0 to +0.8 %, spin -1.7 to +0.7 %."""
    found = ride(1, mu, faces=True)
    assert found.errors[0] < DEMO.FACES[0] and found.errors[1] < DEMO.FACES[1]


@pytest.mark.slow   # of the published method; that of faces is the random study's
def test_where_the_ride_starts_within_the_lattice_matters_on_corners():
    """It changes the outcome by percents; on faces hardly."""
    def spread(faces):
        rides = [ride(1, 0.2, shift, faces) for shift in (0.0, 1 / 3, 2 / 3)]
        return np.ptp([[r.distance, r.spin] for r in rides], axis=0)

    assert (spread(True) < 0.3 * spread(False)).all()


@pytest.mark.parametrize("mu", [pytest.param(mu, marks=pytest.mark.slow) if mu < 0.4 else mu for mu in FRICTION])
def test_quarter_of_the_spacing(mu):
    distance, spin = ride(4, mu).errors
    assert distance < 0.5 and spin < 1.5


@pytest.mark.slow   # tests/study/precision/test_sphere.py has it over the first halving
def test_errors_fall_with_spacing_and_facets():
    assert (scatter(4, shifts=(0.0,)) < scatter(1) / 3).all()


@pytest.mark.slow
def test_errors_fall_with_each_refinement():
    coarse, middle, fine = scatter(1), scatter(2), scatter(4)
    assert (middle < coarse / 1.5).all() and (fine < middle / 1.5).all()


def test_anchor_at_the_start_of_the_step_makes_the_sphere_creep(monkeypatch):
    """The broken variant of contact/first_contact.py."""
    whole = ride(4, 0.4)
    monkeypatch.setattr("hybrid.contact.contact_points.predicted_contact_points",
                        lambda start, end, body, pose, surface, clearance: (
                            (start - body.position) @ body.rotation, np.zeros_like(start)))
    assert Ride(built(4), 0.4, 0.0).errors[1] > 2 * whole.errors[1]


def test_sliding_and_rolling_states():
    slide, roll = ride(4, 0.2), ride(4, 0.4)
    assert np.mean(slide.sliding) > 0.99
    assert np.mean(roll.sliding) < 0.7
    assert slide.speed - slide.spin * RADIUS == pytest.approx(NORMAL_GRAVITY * (1 - 3.5 * 0.2), rel=0.02)
    assert roll.speed - roll.spin * RADIUS == pytest.approx(0.0, abs=0.015 * roll.speed)
    # mean ratio of friction to pressure: μ when sliding, 2/7 tan θ when rolling
    assert slide.force[0] / -slide.force[2] == pytest.approx(0.2, rel=0.03)
    assert roll.force[0] / -roll.force[2] == pytest.approx(2 / 7, rel=0.03)


def test_energy_lost_is_friction_work():
    """Sliding over the way ½ g t² (sin θ - 3.5 μ cos θ) under μ m g cos θ; the rest is conserved."""
    found = ride(4, 0.2)
    work = 0.2 * found.mass * NORMAL_GRAVITY * 0.5 * NORMAL_GRAVITY * (1 - 3.5 * 0.2)
    assert found.energies["friction"] == pytest.approx(work, rel=0.03)
    assert abs(found.energies["error"]) < 0.06 * work
    assert found.energies["kinetic"] > 10 * work
    assert ride(4, 0.0).energies["friction"] == 0.0


@pytest.mark.parametrize("mu", (0.0, 0.2, 0.4))
def test_bumps_cost_little_energy(mu):
    """What the dissipative scheme takes from the bouncing, of the energy gained by falling."""
    found = ride(1, mu)
    assert abs(found.energies["error"]) < 0.015 * found.mass * NORMAL_GRAVITY * found.distance
