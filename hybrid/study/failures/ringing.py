"""Newmark's scheme rings: what an impact sets off in the finest cells is never damped, and the force is lost in it.

A plate comes to a column of 32 elastic cells at v = 0.1 m/s and goes on at that speed. Until its wave is back,

    F = ρ c v A         c = √(E/ρ), a Courant number is c Δt / h

The penalty spring and the first cell swing against each other and contact is lost at every swing: F jumps between 0
and 2 to 4 times ρ c v A whatever the step, while its mean is right. The error is the root mean square of F / (ρ c v A)
- 1 over the last four fifths of 1.6 L/c, when a front that is spread over some cells has passed.
"""

import numpy as np

from hybrid.scene import Axis, Faces, Grid, Stage
from hybrid.study.cases import watched
from hybrid.study.outcome import Seen
from hybrid.study.scenes import SCHEMES, driven, elastic, scene

TITLE = "forces that ring after an impact"
PARAMETERS = ("Courant number",)
MEASURE, RIGHT, WRONG = "root mean square error of the force", 0.1, 0.25
METHODS = {"Newmark": {}, "generalised-alpha, ρ∞ = 0.8": SCHEMES["alpha"],
           "generalised-alpha, ρ∞ = 0": {**SCHEMES["alpha"], "spectral_radius": 0.0},
           "Newmark (0.5625, 1)": SCHEMES["dissipative"]}
DEFAULT = "Newmark"
SAYS = r"oscillates: .*limit.*(beta|spectral_radius)"
LENGTH, CELLS, YOUNG, DENSITY, SPEED = 8.0, 32, 1e6, 1000.0, 0.1


def settings(quick=False):
    return [(courant,) for courant in ((2.0,) if quick else (0.25, 0.5, 1.0, 2.0, 4.0))]


def solve(courant, **time):
    """Seen of a plate in steps of that Courant number."""
    cell, wave = LENGTH / CELLS, np.sqrt(YOUNG / DENSITY)
    step = courant * cell / wave
    side, up = Axis(0.0, cell, cell, collapsed=True), Axis(0.0, LENGTH + 4 * cell, cell)
    plate = driven(1.0, 1.0, 0.5, velocity=(0.0, 0.0, -SPEED), position=(cell / 2, cell / 2, 0.0), rest_on=LENGTH)
    _, records, told = watched(scene(
        "ringing", Grid(side, side, up, Faces(z_min="fixed")), elastic(YOUNG), [plate], step,
        [Stage("press", int(1.6 * LENGTH / wave / step))], soil={"top": LENGTH}, time=time))
    force = np.array([record.bodies[0].contact_force[2] for record in records]) / (DENSITY * wave * SPEED * cell**2)
    late = force[len(force) // 5:]
    return Seen(float(np.sqrt(np.mean((late - 1) ** 2))), tuple(text for text in told if "oscillates" in text))
