"""The end of the grid: beyond it there is no soil, and a body that is dragged there is dragged through nothing.

A box 0.8 m wide slides over elastic soil in plane strain, pressed 20 mm into it on its way, at rest at every step. Its
front starts 1.2 m from the end of a grid; the lift is compared with that on a grid of 6.4 m, after the same way.

A grid that goes with the body (`grid.x.window`) has the soil ahead come in at rest and keeps what is left behind.
"""

import functools

from hybrid.scene import Axis, Faces, Grid, Material, Output, Scene, Soil, Stage, Time
from hybrid.study.cases import watched
from hybrid.study.outcome import Seen
from hybrid.study.scenes import driven

TITLE = "the end of the grid"
PARAMETERS = ("way over the distance to the end of the grid",)
MEASURE, RIGHT, WRONG = "error of the lift", 0.05, 0.25
GRIDS = {"short": {"end": 3.2}, "window": {"end": 6.4, "window": (1.0, 1.0)}, "long": {"end": 6.4}}
METHODS = {"fixed grid": {"grid": "short"}, "grid.x.window": {"grid": "window"}}
DEFAULT = "fixed grid"
SAYS = r"grid\.x\.end"
AHEAD, SPEED, STEP, SUNK = 1.2, 1.0, 0.12, 0.02     # [m], [m/s], [s], [m]


def settings(quick=False):
    return [(way,) for way in ((0.5, 1.5) if quick else (0.5, 0.8, 1.0, 1.2, 1.5, 2.0))]


def solve(way, grid):
    """Seen of a box after that way."""
    lift, told = slid(way, grid)
    return Seen(abs(lift / slid(way, "long")[0] - 1), tuple(text for text in told if "grid.x.end" in text))


@functools.cache
def slid(way, grid):
    """Lift [N] and what was told."""
    steps = max(2, round(way * AHEAD / (SPEED * STEP)))
    box = driven(0.8, 0.8, 0.6, velocity=(SPEED, 0.0, -SUNK / (steps * STEP)), position=(1.6, 0.0, 0.3), rest_on=0.0,
                 second_pass=1.0)
    x = Axis(0.0, size=0.2, growth=1.4, **GRIDS[grid])
    z = Axis(-1.6, 0.8, 0.2)
    soil = Soil(Material(law="hencky", young=2e6, poisson=0.3, density=1800.0), top=0.0)
    _, records, told = watched(Scene(
        name="slides", grid=Grid(x, Axis(-0.2, 0.2, collapsed=True), z, Faces(z_min="fixed")), soil=soil, bodies=(box,),
        time=Time(STEP, inertia=False), stages=(Stage("slide", steps),), output=Output(every=0, checkpoint=0)))
    return records[-1].bodies[0].contact_force[2], told
