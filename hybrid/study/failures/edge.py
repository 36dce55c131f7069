"""Sharp edges between corners: an edge goes into the soil until its flanks meet corners to either side.

A cube is driven on its edge into held soil, in the middle between two rows of corners s = 0.1 m apart.

    F = p_f E L d² (1 + share) / 2          of an edge of 90° and length L, d deep; share: body.second_pass

as samples measure their overlap to the soil's face, p_f E times the volume below it, and corners to the nearer flank,
half of that. Corners are silent up to d = s/2, where the flanks come to them.
"""

from hybrid.scene import Time
from hybrid.study.cases import watched
from hybrid.study.outcome import Seen
from hybrid.study.scenes import driven, soil_scene

TITLE = "sharp edges between corners"
PARAMETERS = ("depth of an edge over the spacing of corners, d / s",)
MEASURE, RIGHT, WRONG = "error of the force on the edge", 0.1, 0.25
METHODS = {"first pass": {}, "second pass": {"second_pass": 1.0}}
DEFAULT = "first pass"
SAYS = r"inside the soil without contact.*limit.*body\.second_pass"
SPACING, STEP, YOUNG, PENALTY, LENGTH = 0.1, 0.01, 1e6, 50.0, 0.3


def settings(quick=False):
    return [(d,) for d in ((1.0, 0.4) if quick else (1.0, 0.8, 0.6, 0.5, 0.4, 0.3))]


def solve(ratio, second_pass=0.0):
    """Seen of an edge pressed that deep."""
    depth, steps = ratio * SPACING, max(2, round(ratio * SPACING / 0.01))
    cube = driven(LENGTH, LENGTH, LENGTH, velocity=(0.0, 0.0, -depth / (steps * STEP)), position=(0.45, 0.4, 0.0),
                  rotation=(0.0, 1.0, 0.0, 45.0), rest_on=0.0, size=0.02, penalty=PENALTY,
                  second_pass=second_pass)
    simulation, records, told = watched(soil_scene([cube], held=True, steps=steps, young=YOUNG, time=Time(step=STEP)))
    exact = PENALTY * YOUNG * LENGTH * depth**2 * (1 + second_pass) / 2
    return Seen(abs(records[-1].bodies[0].contact_force[2] / exact - 1), tuple(t for t in told if "without contact" in t))
