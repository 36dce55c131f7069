"""Normal contact against closed forms: a bounce on a penalty plane, a box at rest, a sphere pressed into a block."""

from dataclasses import replace

import numpy as np
import pytest

from hybrid.contact import places
from hybrid.scene import Axis, Faces, Grid, Stage
from hybrid.setup.build import build
from hybrid.study.scenes import SCHEMES, box, elastic, plane, scene, sphere

PLACES = pytest.mark.parametrize("contact", ["faces", "corners"])


def bounce(per_contact, contact="faces", start=0.0, **time):
    """Relative errors of rebound speed and contact time of a box of 1 m/s that falls flat on a plane.

    per_contact: steps in the time of contact π sqrt(m/k), k = p_f E A, A = 1 m² of the plane; start: of a step until
    the first contact.
    """
    side = 1.2
    mass, stiffness = 500.0 * side**2, 1e6
    touching = np.pi * np.sqrt(mass / stiffness)
    step = touching / per_contact
    body = box(side, side, 0.5, rest_on=start * step, velocity=(0.0, 0.0, -1.0), penalty=1.0, contact=contact)
    simulation = build(plane(body, int(1.3 * per_contact) + 4, step, time=time))
    records = list(simulation.steps())
    last = records[-1]
    speed, height = last.bodies[0].velocity[2], last.bodies[0].position[2] - 0.25
    assert last.contacts == 0 and np.abs(last.bodies[0].spin).max() < 1e-12
    return abs(speed - 1), abs((last.time - height / speed - start * step) / touching - 1)


def bounce_errors(per_contact, **case):
    """The larger of two starts within a step."""
    return np.max([bounce(per_contact, start=start, **case) for start in (0.25, 0.75)], axis=0)


@pytest.mark.parametrize("time", [SCHEMES[name] for name in ("newmark", "alpha", "energy-momentum")],
                         ids=["newmark", "generalised-alpha", "energy-momentum"])
@PLACES
def test_elastic_bounce(contact, time):
    """Contact time π sqrt(m/k) at second order, 0.8 % with 10 steps; restitution 1 at third, 0.4 %."""
    coarse, fine = (bounce_errors(n, contact=contact, **time) for n in (10, 20))
    assert coarse[0] < 5e-3 and coarse[1] < 1e-2
    rates = np.log2(coarse / fine)
    assert rates[0] > 2.5 and rates[1] == pytest.approx(2.0, abs=0.03)


def test_the_default_takes_little_from_a_bounce_that_the_step_resolves():
    """Contact time at second order, restitution at third: 1.1 and 0.6 % with 20 steps."""
    coarse, fine = (bounce_errors(n) for n in (20, 40))
    assert coarse[0] < 8e-3 and coarse[1] < 1.2e-2
    rates = np.log2(coarse / fine)
    assert rates[0] > 2.5 and rates[1] == pytest.approx(2.0, abs=0.2)


def test_the_dissipative_pair_takes_speed_from_a_bounce():
    """First order: 22 % with 10 steps. What the check of the restitution above is worth."""
    coarse, fine = (bounce_errors(n, beta=0.5625, gamma=1.0)[0] for n in (10, 20))
    assert coarse > 0.2 and np.log2(coarse / fine) == pytest.approx(1.0, abs=0.2)


@pytest.mark.parametrize("side, cells, contact, facets", [
    (1.2, 4, "corners", 10.0), (1.2, 4, "corners", 0.11), (1.2, 4, "faces", 10.0), (1.2, 4, "faces", 0.11),
    (1.0, 6, "faces", 10.0), (1.0, 6, "faces", 0.11)])
def test_a_flat_overlap_costs_stiffness_times_area(side, cells, contact, facets):
    """k = p_f E A to round-off, whatever the facets; A of the plane or of the box, whichever is smaller."""
    overlap = 5e-4
    body = box(side, side, 0.5, size=facets, rest_on=-overlap, penalty=1.0, contact=contact,
               held=("x", "y", "z", "rx", "ry", "rz"))
    simulation = build(plane(body, 1, 0.01, cells=(cells, cells)))
    record, = simulation.steps()
    force, moment = record.bodies[0].contact_force, record.bodies[0].contact_moment
    assert force[2] == pytest.approx(1e6 * overlap, rel=1e-9)
    assert np.abs(moment).max() < 1e-6 * force[2] and np.abs(force[:2]).max() < 1e-9 * force[2]
    assert simulation.model.body_unknowns == 0


@pytest.mark.parametrize("k", [1, 2, 8])
def test_the_force_on_whole_faces_is_the_same_for_any_number_of_points(k):
    """Box over the middle 0.75 m of a plane of faces of 0.125 m."""
    assert pressed_faces(0.75, k) == pytest.approx(1e6 * 5e-4 * 0.75**2, rel=1e-9)


def test_the_force_on_a_partly_covered_face_tends_to_that_of_the_covered_area():
    """A box that ends 0.3 of a face beyond a face: first order in 1/k in the area.

    At each edge half a spacing at most, and the points that are nearer to the box's side than deep under it."""
    side, k = 0.75 + 0.6 * 0.125, np.array([2, 8, 32])
    missed = np.array([abs(pressed_faces(side, n) / (1e6 * 5e-4 * side**2) - 1) for n in k])
    assert (missed < (1 + (0.125 / k + 2 * 5e-4) / side) ** 2 - 1).all()


def pressed_faces(side, k):
    """Force [N] on a box `side` wide that overlaps a plane by 0.5 mm, by k x k points on every face."""
    body = box(side, side, 0.5, rest_on=-5e-4, penalty=1.0, held=("x", "y", "z", "rx", "ry", "rz"))
    simulation = build(plane(body, 1, 0.01, cells=(6, 6)))
    bodies = (replace(simulation.model.bodies[0], places=places.faces(k)),)
    simulation.model = replace(simulation.model, bodies=bodies)
    record, = simulation.steps()
    return record.bodies[0].contact_force[2]


def test_points_without_domains_press_with_their_own_stiffness():
    """Standard MPM: its points are half a domain below the surface, k = p_f E A there."""
    body = box(1.2, 1.2, 0.5, rest_on=-0.0625 - 5e-4, penalty=1.0, held=("x", "y", "z", "rx", "ry", "rz"))
    record, = build(plane(body, 1, 0.01, soil={"held": True, "basis": "mpm"})).steps()
    assert record.bodies[0].contact_force[2] == pytest.approx(1e6 * 5e-4, rel=1e-9)


@PLACES
def test_a_box_at_rest_presses_evenly(contact):
    """σ_zz = -W/A at every point of a weightless cube under it, and the overlap W/(p_f E A) at every contact point.

    The box ends a cell beyond the cube: within half a cell of its edges there is no contact."""
    axis = Axis(start=0.0, end=1.0, size=0.25)
    body = box(1.5, 1.5, 0.5, size=0.125, position=(0.5, 0.5, 0.0), rest_on=1.0 - 1e-3, contact=contact, penalty=50.0,
               held=("x", "y", "rx", "ry", "rz"))
    described = scene(
        "rest", Grid(axis, axis, Axis(start=0.0, end=1.25, size=0.25), Faces()), elastic(1e6), [body], 1.0,
        [Stage("rest", 1)], time={"inertia": False}, gravity=(0.0, 0.0, -9.81), soil={"top": 1.0},
        solver={"tolerance": 1e-10, "linear": "direct"})
    simulation = build(described)
    simulation.model.soil.constants.mass[:] *= 1e-12
    record, = simulation.steps()
    weight = 9.81 * simulation.masses[0].mass
    assert record.bodies[0].contact_force[2] == pytest.approx(weight, rel=1e-9)
    stress, found = simulation.state.points.stress[:, 2, 2], simulation.evaluation.contacts[0]
    assert stress == pytest.approx(-weight, rel=1e-8)
    assert np.ptp(stress) < 1e-8 * weight
    assert found.gap == pytest.approx(-weight / 50e6, rel=1e-8)


class Indentation:
    """A rigid sphere of R = 1 m pressed into a quarter of an elastic block 16 m wide and deep, ν = 0.3, in two steps.

    Hertz: F = 4/3 E/(1-ν²) sqrt(R δ³), radius of contact a = sqrt(R δ); cells: in a.
    """

    def __init__(self, radius_of_contact, facets, cells=4, **body):
        depth, cell = radius_of_contact**2, radius_of_contact / cells
        axis = Axis(start=0.0, end=16.0, size=cell, fine=(0.0, 1.5 * radius_of_contact), growth=1.8)
        down = Axis(start=-16.0, end=0.0, size=cell, fine=(-1.5 * radius_of_contact, 0.0), growth=1.8)
        body = sphere(1.0, facets, 0.8, rest_on=0.0, velocity=(0.0, 0.0, -depth / 2), driven=("z",),
                      held=("x", "y", "rx", "ry", "rz"), **body)
        simulation = build(scene(
            "hertz", Grid(axis, axis, down, Faces(z_min="fixed", x_max="free", y_max="free")), elastic(1e6, 0.3),
            [body], 1.0, [Stage("press", 2)], time={"inertia": False}))
        self.force = np.array([4 * r.bodies[0].contact_force[2] for r in simulation.steps()])
        depths = depth * np.array([0.5, 1.0])
        self.ratio = self.force / (4 / 3 * 1e6 / (1 - 0.3**2) * depths**1.5)
        place = simulation.evaluation.contacts[0].arm + simulation.state.bodies[0].position
        self.radius = np.linalg.norm(place[:, :2], axis=1).max() / radius_of_contact


def test_hertz():
    """At a/R = 0.2: force +6.0 %. Two thirds of this are finite strains, which decrease with a/R. Radius of contact: 0.99
    of Hertz."""
    found = Indentation(0.2, 0.05, penalty=1000.0)
    assert found.ratio[-1] == pytest.approx(1.06, abs=0.015)
    assert np.log2(found.force[1] / found.force[0]) == pytest.approx(1.5, abs=0.03)
    assert found.radius == pytest.approx(1.0, abs=0.05)


@pytest.mark.slow
def test_hertz_with_finer_facets():
    """As with facets of a/4, because contact is with the sphere that they approximate."""
    found, finer = (Indentation(0.2, size, penalty=1000.0) for size in (0.05, 0.025))
    assert found.ratio[-1] == pytest.approx(finer.ratio[-1], rel=1e-4)


@pytest.mark.slow
def test_hertz_is_the_limit_of_small_strains():
    """Cells of a/8: +5.4 % at a/R = 0.2 and +3.2 % at 0.1 (of a/4: 6.0 and 4.1 %); about 1 % is left for a/R -> 0."""
    large, small = (Indentation(a, a / 4, cells=8, penalty=200.0 / a).ratio[-1] - 1 for a in (0.2, 0.1))
    assert 0 < small < 0.7 * large
    assert abs(2 * small - large) < 0.02

