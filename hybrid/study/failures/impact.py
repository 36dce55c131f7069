"""Impacts that go farther in a step than a body is thick: Newton's method finds the plate on the soil's other side.

A plate of 40 mm is thrown at elastic soil at 5 m/s, over corners s = 0.1 m apart, from 10 mm above it. Of the two
equilibria at the end of a long step, the plate stopped by the soil and the plate beyond it, the second is nearer to the
first guess v Δt. What is known is that all of the soil under the plate stays under it.

The program walks the path of every corner and halves a step that carries one through a body (`contact.tunnelling`).
How fast the plate is thrown back is another matter (`bounce_step`).
"""

from contextlib import nullcontext
from unittest import mock

import numpy as np

from hybrid.scene import Solver, Time
from hybrid.step.equations import Step
from hybrid.study.cases import watched
from hybrid.study.outcome import Seen
from hybrid.study.scenes import soil_scene, steel

TITLE = "fast impacts"
PARAMETERS = ("way in a step over the spacing of corners, v Δt / s",)
MEASURE, RIGHT, WRONG = "share of the soil under a plate that went through it", 0.01, 0.05
PLAIN = {"line_search": False, "tangent_tolerance": 0.0, "loosest_tolerance": 0.0}
METHODS = {"no check of passage": {"checked": False}, "first pass": {}, "second pass": {"second_pass": 1.0}}
DEFAULT = "first pass"
SAYS = r"passed through a body.*time\.step"
SPEED, SPACING, THICKNESS, DURATION = 5.0, 0.1, 0.04, 0.12


def settings(quick=False):
    return [(way,) for way in ((5.0,) if quick else (0.1, 0.25, 0.5, 1.0, 1.5, 2.5, 5.0, 10.0, 20.0))]


def solve(way, checked=True, **body):
    """Seen of a throw in steps of that way."""
    step = way * SPACING / SPEED
    plate = steel(0.5, 0.5, THICKNESS, size=0.25, rest_on=0.01, position=(0.4, 0.4, 0.0), velocity=(0.0, 0.0, -SPEED),
                  **body)
    solver = Solver(tolerance=1e-4, **({} if checked else PLAIN))
    described = soil_scene([plate], z=(-0.8, 0.6), young=5e6, poisson=0.2, time=Time(step=step), solver=solver,
                           steps=max(2, round(DURATION / step)))
    with nullcontext() if checked else mock.patch.object(Step, "tunnelled", lambda self, evaluation: 0):
        simulation, _, told = watched(described)
    points, middle = simulation.state.points, simulation.state.bodies[0].position
    under = np.abs(simulation.initial_position[:, :2] - middle[:2]).max(axis=1) < 0.2
    return Seen(float(np.mean(points.position[under, 2] > middle[2])), tuple(t for t in told if "through" in t))
