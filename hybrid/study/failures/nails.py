"""Bodies smaller than the spacing of corners ride on a bed of nails, or fall between them.

A sphere is let down on a held plane, onto a corner or in the middle of four. Under its weight it sinks by d = r/10,

    p_f E π d² (r - d/3) = 4/3 π r³ ρ g

if the plane is smooth; between four corners s apart its lowest point is up to r - √(r² - s²/2) deeper, and a sphere of
r < s/√2 falls between them. The larger error of the two places is taken.
"""

import numpy as np

from hybrid.study.cases import watched
from hybrid.study.outcome import Seen
from hybrid.study.scenes import plane, sphere

TITLE = "smaller than the spacing of corners"
PARAMETERS = ("radius of a sphere over the spacing of corners, r / s",)
MEASURE, RIGHT, WRONG = "error of the height it rests at over its radius", 0.05, 0.25
METHODS = {"first pass": {}, "second pass": {"second_pass": 1.0}}
DEFAULT = "first pass"
SAYS = r"spacings of corners, limit 2:.*body\.second_pass = 1|inside the soil without contact.*body\.second_pass"
RADIUS, GRAVITY, STEPS = 0.25, 9.81, 25
STIFFNESS = 4 / 3 * 1000.0 * GRAVITY / (0.1**2 * (1 - 0.1 / 3))     # p_f E [Pa/m] that makes d = r/10


def settings(quick=False):
    return [(r,) for r in ((2.0, 0.5) if quick else (8.0, 4.0, 2.0, 1.5, 1.0, 0.8, 0.5, 0.25))]


def solve(ratio, **body):
    """Seen of the worse of two places."""
    return max((rested(ratio, place, **body) for place in (0.0, 0.5)), key=lambda found: found.error)


def rested(ratio, place, **body):
    """Seen of a sphere over a corner, moved by `place` spacings along both axes."""
    spacing = RADIUS / ratio
    count = 2 * int(np.ceil(0.8 * ratio) + 1)
    ball = sphere(RADIUS, 0.06, position=(place * spacing, place * spacing, 0.0), rest_on=0.0, penalty=1.0,
                  held=("x", "y", "rx", "ry", "rz"), **body)
    simulation, _, told = watched(plane(
        ball, STEPS, 0.3 * np.sqrt(0.1 * RADIUS / GRAVITY), cell=2 * spacing, cells=(count, count), stiffness=STIFFNESS,
        gravity=(0.0, 0.0, -GRAVITY), time={"beta": 0.5625, "gamma": 1.0}))
    height = simulation.state.bodies[0].position[2] / RADIUS
    return Seen(abs(height - 0.9), tuple(text for text in told if "second_pass" in text))
