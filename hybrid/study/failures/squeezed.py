"""Hardly any soil left under a body: it overlaps the soil by more than a point's domain, and a second row of corners
touches.

A rigid platen presses a layer of one cell, two points high, against the base (`platen`, quasi-static, ν = 0). With the
height l = l_p + δ of the layer under a platen at l_p,

    F = p_f E A δ = A E ln(L/l) L/l        δ = 0 with multipliers

As soon as the overlap δ exceeds the height l/2 of a domain, the corners between the two points are inside the platen
too. Every row stands for all of the area, so pressure is counted twice, and three times at the base. Multipliers take
the overlap away, but five updates a step do not suffice where the force doubles in a step.
"""

from math import log

from scipy.optimize import brentq

from hybrid.scene import Axis, Faces, Grid, Material, Output, Scene, Soil, Stage, Time
from hybrid.study.cases import watched
from hybrid.study.outcome import Seen
from hybrid.study.scenes import driven

TITLE = "hardly any soil left under a body"
PARAMETERS = ("share of a layer's height pressed away",)
MEASURE, RIGHT, WRONG = "error of the force", 0.02, 0.1
METHODS = {"p_f = 50 /m": {}, "p_f = 5000 /m": {"penalty": 5000.0},
           "p_f = 50 /m, augmented": {"enforcement": "augmented"},
           "p_f = 5000 /m, augmented": {"penalty": 5000.0, "enforcement": "augmented"}}
DEFAULT = "p_f = 50 /m"
SAYS = r"penetrates the soil too far.* limit.*body\.penalty"
LENGTH, SIDE, YOUNG, STEPS = 0.2, 0.8, 1e6, 20


def settings(quick=False):
    return [(share,) for share in ((0.9,) if quick else (0.2, 0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99))]


def solve(share, penalty=50.0, **body):
    """Seen of a layer pressed by that share."""
    axis, up = Axis(start=0.0, end=SIDE, size=LENGTH), Axis(start=0.0, end=2 * LENGTH, size=LENGTH)
    platen = driven(1.2, 1.2, 0.4, velocity=(0.0, 0.0, -share * LENGTH / STEPS), position=(0.4, 0.4, 0.0),
                    rest_on=LENGTH, penalty=penalty, **body)
    material = Material(law="hencky", young=YOUNG, poisson=0.0, density=1000.0)
    _, records, told = watched(Scene(
        name="squeezed", grid=Grid(axis, axis, up, Faces()), soil=Soil(material, top=LENGTH, geostatic=False),
        bodies=(platen,), time=Time(1.0, inertia=False), stages=(Stage("press", STEPS),), gravity=(0.0, 0.0, 0.0),
        output=Output(every=0, checkpoint=0)))
    exact = series((1 - share) * LENGTH, penalty) if "enforcement" not in body else force((1 - share) * LENGTH)
    return Seen(abs(records[-1].bodies[0].contact_force[2] / exact - 1), tuple(t for t in told if "penetrates" in t))


def force(height):
    """Of a layer pressed to a height [m]."""
    return SIDE**2 * YOUNG * log(LENGTH / height) * LENGTH / height


def series(low, penalty):
    """Force [N] under a platen at `low` [m] with springs of contact in series."""
    return force(brentq(lambda h: penalty * YOUNG * SIDE**2 * (h - low) - force(h), low, LENGTH, xtol=1e-14))
