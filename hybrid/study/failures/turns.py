"""Steps that turn a body too far: rotation vectors add only while they are small, and repeat beyond half a turn.

A box of 1 x 0.7 x 0.3 m flies and tumbles freely about its intermediate axis, ten radians of its spin W(0) at so many
radians a step.

    J Ẇ + W × J W = 0      R' = R W̃          attitude integrated to round-off (`tumbling.reference`)

A step of |Θ| radians misses a share of |Θ|³ of the attitude, of |Θ|² with the dissipative pair: after 10 rad that is
0.24 |Θ|² with Newmark's (1/4, 1/2), 1.0 |Θ|² with energy-momentum, 1.5 |Θ| with (0.5625, 1), measured. Beyond 2 rad
the program halves the step, for log(R_nᵀ R) takes a turn of |Θ| > π for one of 2π - |Θ| the other way; below nothing
stops it, and only `time.accuracy` looks at the error of a step.
"""

import numpy as np

from hybrid.scene import Axis, Faces, Grid, Stage
from hybrid.study.cases import watched
from hybrid.study.outcome import Seen
from hybrid.study.problems import tumbling
from hybrid.study.scenes import SCHEMES, box, elastic, scene

TITLE = "steps of large turns"
PARAMETERS = ("turn in a step [rad]",)
MEASURE, RIGHT, WRONG = "angle to the exact attitude after a turn of 10 rad [rad]", 0.015, 0.05
METHODS = {"Newmark (0.5625, 1)": SCHEMES["dissipative"], "energy-momentum": SCHEMES["energy-momentum"],
           "Newmark": {}, "time.accuracy": {"accuracy": 1e-3}}
DEFAULT = "Newmark"
SAYS = r"rotates by .* rad a step.*limit.*time\.accuracy"
SPIN, TURNED = np.array([0.3, 1.0, 0.3]), 10.0     # [rad/s], [rad]


def settings(quick=False):
    return [(turn,) for turn in ((1.0,) if quick else (0.03, 0.1, 0.3, 0.5, 1.0, 3.0))]


def solve(turn, **time):
    """Seen of a flight in steps of that turn."""
    side, speed = Axis(start=-0.5, end=0.5, size=0.5), np.linalg.norm(SPIN)
    step, steps = turn / speed, round(TURNED / turn)
    described = scene(
        "turns", Grid(side, side, Axis(start=-3.0, end=-2.0, size=0.5), Faces()), elastic(1e6),
        [box(1.0, 0.7, 0.3, spin=tuple(SPIN))], step, [Stage("fly", steps)], {"held": True}, time, {"tolerance": 1e-10})
    simulation, _, told = watched(described)
    top = tumbling.Top(simulation.masses[0].inertia, SPIN, np.eye(3), np.zeros(3), np.zeros(3))
    exact = tumbling.reference(top, steps * step)
    angle, _ = tumbling.apart(simulation.state.bodies[0], exact)
    return Seen(angle, tuple(text for text in told if "rad a step" in text))
