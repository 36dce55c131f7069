"""Softening: failure gathers in one row of cells, so the energy that it takes goes with their size.

    ^ ^ ^ ^    bed of 8 m, cemented, ν = 0, cohesion c that is gone after a plastic strain of c/|H|; it moves upwards
    |     |    by 1 m/s all over when its floor stops, breaks off at the floor and flies on. One layer of cells opens,
    |_____|    by a width that goes with h, and the others unload

Only an energy of fracture G_f a unit of area is a property of the soil. With w(H) = ∫ σ dλ of a point drawn out with
its sides held, G_f = h w(H): the softening H is chosen for cells of h0 = 1 m. For others it has to be H h/h0 (crack
band: Z. P. Bažant and B. H. Oh, Matériaux et Constructions 16 (1983) 155-177). Known: the bed flies on at
√(v² - 2 G_f/ρL), less what its waves keep.
"""

import functools

import numpy as np

from hybrid.laws import plastic_increment
from hybrid.laws.drucker_prager import DruckerPrager
from hybrid.scene import Axis, Faces, Grid, Material, Output, Scene, Soil, Stage, Time
from hybrid.setup.build import build
from hybrid.study.cases import told
from hybrid.study.outcome import Seen

TITLE = "softening"
PARAMETERS = ("cells over the bed's depth; softening is chosen for 8",)
MEASURE, RIGHT, WRONG = "error of the speed after the break", 0.05, 0.25
METHODS = {"softening as given": {}, "scaled with the cells": {"scaled": True}}
DEFAULT = "softening as given"
SAYS = r"hardening = -\S+ Pa.*limit 0.*in proportion"
LENGTH, CHOSEN, DENSITY, SPEED, DURATION, STEPS = 8.0, 1.0, 1000.0, 1.0, 0.15, 60
YOUNG, ANGLE, COHESION, SOFTENING = 1e9, 30.0, 5.4e4, -5.4e4 / 0.035


def settings(quick=False):
    return [(cells,) for cells in ((8, 32) if quick else (8, 16, 32, 64))]


def solve(cells, scaled=False):
    """Seen of a bed of that many cells."""
    size, side = LENGTH / cells, Axis(start=0.0, end=1.0, collapsed=True)
    material = Material(
        law="drucker-prager", young=YOUNG, poisson=0.0, density=DENSITY, friction_angle=ANGLE, dilation_angle=0.0,
        cohesion=COHESION, hardening=SOFTENING * (size / CHOSEN if scaled else 1.0), residual_cohesion=0.0)
    simulation = build(Scene(
        name="bed", soil=Soil(material, geostatic=False, top=LENGTH), gravity=(0.0, 0.0, 0.0),
        grid=Grid(side, side, Axis(start=0.0, end=2 * LENGTH, size=size), Faces(z_min="fixed")),
        time=Time(DURATION / STEPS), stages=(Stage("fly", STEPS),), output=Output(every=0, checkpoint=0)))
    simulation.state.points.velocity[:, 2] = SPEED
    records = list(simulation.steps())
    fast = simulation.state.points.velocity[:, 2].mean()
    exact = np.sqrt(SPEED**2 - 2 * CHOSEN * broken() / (DENSITY * LENGTH))
    return Seen(float(abs(fast / exact - 1)),
                tuple(text for text in told(simulation, records) if "hardening" in text))


@functools.cache
def broken(steps=2000, upto=0.3):
    """w [J/m³] that a point takes until its cohesion is gone, drawn out along one axis."""
    law = DruckerPrager(np.array([YOUNG]), 0.0, ANGLE, 0.0, COHESION, hardening=SOFTENING, residual_cohesion=0.0)
    elastic, history, work, last = np.zeros((1, 3)), np.zeros(1), 0.0, 1.0
    for stretch in np.exp(np.linspace(0.0, upto, steps + 1))[1:]:
        trial = elastic + [[0.0, 0.0, np.log(stretch / last)]]
        response = law.respond(trial, history)
        history, elastic = history + plastic_increment(trial, response.elastic), response.elastic
        work, last = work + response.stress[0, 2] / stretch * (stretch - last), stretch
    return work
