"""Bodies thinner than the spacing of corners: what fits between the soil's corners meets none of them.

A wall 0.3 m long is driven edge-down, 20 mm deep, into held soil whose corners lie s = 0.1 m apart.

    F = p_f E t L d         of a wall of thickness t and length L, pressed down by d

Corners under the edge carry s L p_f E d a row, and there are t/s rows of them, rounded up or down as the wall happens
to stand: the larger error of two places is taken. Samples of the body stand for the area that they show to the soil.
"""

from hybrid.scene import Time
from hybrid.study.cases import watched
from hybrid.study.outcome import Seen
from hybrid.study.scenes import driven, soil_scene

TITLE = "thinner than the spacing of corners"
PARAMETERS = ("thickness over the spacing of corners, t / s",)
MEASURE, RIGHT, WRONG = "error of the force on the edge", 0.05, 0.25
METHODS = {"first pass": {}, "both passes": {"second_pass": 0.5}, "second pass": {"second_pass": 1.0}}
DEFAULT = "first pass"
SAYS = r"spacings of corners, limit 2:.*body\.second_pass = 1"
SPACING, STEP, YOUNG, PENALTY = 0.1, 0.01, 1e6, 50.0
PLACES = (0.1, 0.4)     # [-] of the wall's middle off a row of corners, in spacings


def settings(quick=False):
    return [(t,) for t in ((4.6, 0.3) if quick else (4.6, 3.4, 2.6, 1.5, 0.7, 0.3, 0.1, 0.05))]


def solve(ratio, **body):
    """Seen of the worse of two places of the wall."""
    seen = [pressed(ratio * SPACING, place * SPACING, **body) for place in PLACES]
    return max(seen, key=lambda found: found.error)


def pressed(thickness, place, **body):
    """Seen of a wall of `thickness` [m] whose middle is `place` [m] off a row."""
    wall = driven(thickness, 0.3, 0.3, velocity=(0.0, 0.0, -1.0), position=(0.4 + place, 0.4, 0.0), rest_on=0.0,
                  size=0.05, penalty=PENALTY, **body)
    simulation, records, told = watched(soil_scene([wall], held=True, steps=2, young=YOUNG, time=Time(step=STEP)))
    exact = PENALTY * YOUNG * thickness * 0.3 * 2 * STEP
    return Seen(abs(records[-1].bodies[0].contact_force[2] / exact - 1), tuple(t for t in told if "spacings" in t))
