"""Plates thrown at soil in steps much longer than they are thick: no corner may be carried through them.

At 5 m/s a step of 0.03 s goes 150 mm; the plates are 20 and 5 mm thick, and start 10 mm above the soil.
"""

from contextlib import suppress

import numpy as np
import pytest

from hybrid.contact import tunnelling
from hybrid.runtime.errors import StepError
from hybrid.scene import Solver, Time
from hybrid.setup.build import build
from hybrid.step import rejection
from hybrid.study.scenes import soil_scene, steel

PLACES = pytest.mark.parametrize("contact", ["corners", "faces"])
PENALTY = 50.0      # [1/m]
THICKNESS = pytest.mark.parametrize("thickness", [0.02, 0.005])


def thrown(geometry, thickness, contact, solver=Solver(tolerance=1e-4), **time):
    """Simulation of a plate thrown at a block of elastic soil."""
    plate = steel(0.5, 0.5, thickness, size=0.25, rest_on=0.01, position=(0.4, 0.4, 0.0),
                velocity=(0.0, 0.0, -5.0), contact=contact, penalty=PENALTY)
    return build(soil_scene([plate], z=(-0.8, 0.6), young=5e6, poisson=0.2, time=Time(step=0.03, **time),
                            solver=solver))


def lowest_gap_to_soil(simulation):
    """Height [m] of the plate's middle above the highest soil under it."""
    points, plate = simulation.state.points, simulation.state.bodies[0].position
    under = abs(points.position[:, :2] - plate[:2]).max(axis=1) < 0.2
    return plate[2] - (points.position + points.half_width)[under, 2].max()


@PLACES
@THICKNESS
def test_long_steps_are_halved_until_no_corner_is_carried_through(geometry, thickness, contact):
    simulation = thrown(geometry, thickness, contact)
    records = list(simulation.steps())
    assert sum(r.rejections for r in records) > 0
    assert lowest_gap_to_soil(simulation) > 0.0
    assert records[-1].bodies[0].velocity[2] > -1.0


@PLACES
@THICKNESS
def test_without_the_check_it_goes_through(geometry, monkeypatch, thickness, contact):
    """Plain Newton updates land beyond the plate; of two equilibria others may happen to find that on this side. In a
    plate of 40 mm a row of points is still caught, and what side it is pushed to is chance."""
    monkeypatch.setattr(rejection, "tunnelled", lambda step, evaluation: 0)
    plain = Solver(tolerance=1e-4, line_search=False, tangent_tolerance=0.0)
    simulation = thrown(geometry, thickness, contact, plain)
    with suppress(StepError):       # it falls free below the surface of the soil, or sticks there by its edges
        list(simulation.steps())
    assert lowest_gap_to_soil(simulation) < 0.0


def test_looking_at_a_few_places_of_the_way_skips_a_foil(geometry, monkeypatch):
    """Quarters of 150 mm all miss 5 mm; walking by the distance to the surface does not."""
    monkeypatch.setattr(tunnelling, "pierced", lambda start, *rest: np.zeros(len(start), bool))
    simulation = thrown(geometry, 0.005, "faces")
    with suppress(StepError):
        list(simulation.steps())
    assert lowest_gap_to_soil(simulation) < 0.0


def test_a_step_that_may_not_be_halved_is_refused_with_advice(geometry):
    with pytest.raises(StepError, match=r"contact points of the soil passed through a body.*Use a smaller time.step"):
        list(thrown(geometry, 0.005, "faces", smallest=0.03).steps())
