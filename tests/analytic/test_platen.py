"""A frictionless rigid platen squeezes an elastic cube of 0.8 m by 0.2 m in 20 quasi-static steps, ν = 0.

Soil and contact are springs in series. With the height l = 0.6 m + δ of the cube under a platen at 0.6 m,

    F = p_f E A δ = A E ln(L/l) L/l        A = 0.64 m², L = 0.8 m, E = 1 MPa

the ideal force of δ = 0 being 245.49 kN, 383.58 kPa. Published at p_f = 50: F = 234.663 kN, l = 0.6046 m, mean stress
-370.6 kPa, 3-4 Newton iterations a step. That height belongs to 25 sites of corners with the full stiffness of a point
each, on a face whose area is worth 16 (p_f = 78.1 here); force and stress as published differ by 1 % from one another.
"""

import functools
from dataclasses import replace

import numpy as np
import pytest

from hybrid.bench.timed_steps import newton_iterations
from hybrid.contact.contact_points import find_contact_points
from hybrid.step import iteration
from hybrid.study.precision.problems import platen
from hybrid.study.precision.problems.platen import AREA, IDEAL, YOUNG, in_series


class Press:
    """The platen after its last step, on corners unless `body` says otherwise. pressed: area [m²] that the springs in
    touch stand for."""

    def __init__(self, penalty, contact="corners", **body):
        found = platen.press(penalty=penalty, solver={"tolerance": 1e-8, "linear": "direct"}, contact=contact, **body)
        self.force, self.height, simulation = found.force, found.height, found.simulation
        self.stress = simulation.state.points.stress[:, 2, 2].mean()
        self.iterations = [r.iterations for r in found.records]
        contact = simulation.evaluation.contacts[0]
        self.gaps = contact.gap
        self.pressed = np.sum(contact.force[:, 2] / -contact.gap) / (penalty * YOUNG)
        self.error = found.records[-1].energies["error"] / found.records[-1].energies["drive"]


@functools.cache
def press(penalty, **body):
    return Press(penalty, **body)


@pytest.mark.parametrize("penalty", [50.0, 100.0, 1000.0, 10000.0])
def test_springs_in_series(penalty):
    """Force and height to 0.05 %, the error of 20 steps in which domains take their mean stretch."""
    found, (force, height) = press(penalty), in_series(penalty)
    assert found.force == pytest.approx(force, rel=5e-4)
    assert found.height == pytest.approx(height, rel=5e-4)
    assert set(found.iterations) <= {3, 4, 5}


def test_published():
    """At the published height: force +1.0 %, stress -0.1 %. At p_f = 50 itself -1.0 %, +0.4 % in height, -2.0 %."""
    found = press(78.125)
    assert found.height == pytest.approx(0.6046, rel=5e-4)
    assert found.force == pytest.approx(234_663, rel=0.011)
    assert found.stress == pytest.approx(-370.6e3, rel=2e-3)


def test_the_penalty_converges_to_the_ideal_force():
    """First order in 1/p_f: -2.76, -0.29, -0.03 %."""
    missed = np.array([1 - press(p).force / IDEAL for p in (100.0, 1000.0, 10000.0)])
    assert (missed > 0).all()
    assert np.log10(missed[:-1] / missed[1:]) == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("facets", [0.4, 0.05])
def test_faces_carry_the_same_pressure_as_corners(facets):
    """The pressure p_f E g on the area of the cube, to round-off, whatever the facets of the platen."""
    found = Press(50.0, contact="faces", size=facets)
    assert found.pressed == pytest.approx(AREA, rel=1e-9)
    assert found.force == pytest.approx(press(50.0).force, rel=1e-9)


@pytest.mark.parametrize("cell, missed", [(0.4, 7e-4), (0.2, 4e-4)])
def test_the_derived_penalty_is_out_of_sight(cell, missed):
    """p_f = 2000/h for a driven plane: the contact takes h/(2000 L) of the displacement."""
    assert abs(platen.press(cell=cell).force / IDEAL - 1) < missed


def test_a_quarter_of_a_point_per_corner_presses_evenly(monkeypatch):
    """Four corners meet inside, two at an edge, one at the cube's vertices, as the face's area does.

    Sites of equal stiffness overlap unevenly instead: 2.5 to 9.1 mm.
    """
    assert np.ptp(press(50.0).gaps) < 1e-12

    def by_site(*found):
        corners = find_contact_points(*found)
        _, site, count = np.unique(np.round(corners.position, 6), axis=0, return_inverse=True, return_counts=True)
        return replace(corners, stiffness=4 * corners.stiffness / count[site.reshape(-1)])

    monkeypatch.setattr("hybrid.contact.contact_pair.find_contact_points", by_site)
    gaps = -Press(50.0).gaps
    assert gaps.max() > 3 * gaps.min()


def test_energy_of_the_drive():
    """Work of the drive is stored in soil and springs; what is missed falls with the square of the step."""
    assert abs(press(50.0).error) < 5e-3


def test_stiff_springs_cost_no_iterations(monkeypatch):
    """Linear systems are solved the more tightly the stiffer contact is; else iterations are more than twice as many."""
    def iterations(penalty):
        return newton_iterations(platen.press(penalty=penalty, steps=4).records)

    soft, stiff = iterations(50.0), iterations(1e7)
    assert stiff < 2 * soft
    monkeypatch.setattr(iteration, "STIFF", float("inf"))
    assert iterations(1e7) > 2 * max(soft, stiff)
