"""Bodies much lighter than the soil they hit: they are thrown back by the nodes instead of being stopped by a wave.

A box of mass M falls at v = 0.1 m/s on a column of 32 elastic cells of height h. Until its wave is back,

    M v' = -ρ c A v         v(t) = v exp(-t/τ)         τ = M / (ρ c A)

The soil's nodes carry half a row of cells at once, ρ h A / 2. A heavier body is stopped by many of them in turn; a
lighter one meets a mass that stands still, and a contact spring, and is thrown back: as fast as it came by rights of
that model, up to three times as fast where the step is longer than the contact (`bounce_step`).
"""

import numpy as np

from hybrid.scene import Axis, Faces, Grid, Stage
from hybrid.study.cases import watched
from hybrid.study.outcome import Seen
from hybrid.study.scenes import SCHEMES, box, elastic, scene

TITLE = "bodies lighter than the soil"
PARAMETERS = ("mass of a body over a row of cells under it, M / ρ h A",)
MEASURE, RIGHT, WRONG = "error of the speed after 1.5 L / c over v", 0.05, 0.25
METHODS = {"Newmark": {}, "generalised-alpha, ρ∞ = 0": {**SCHEMES["alpha"], "spectral_radius": 0.0},
           "Newmark (0.5625, 1)": SCHEMES["dissipative"]}
DEFAULT = "Newmark"
SAYS = r"rows? of cells under it, limit 1\.5.*size"
LENGTH, CELLS, YOUNG, DENSITY, SPEED, COURANT = 8.0, 32, 1e6, 1000.0, 0.1, 1.0


def settings(quick=False):
    return [(ratio,) for ratio in ((0.03,) if quick else (1e5, 1e3, 100.0, 10.0, 3.0, 1.0, 0.3, 0.1, 0.03, 0.01))]


def solve(ratio, **time):
    """Seen of a box of that mass."""
    cell, wave = LENGTH / CELLS, np.sqrt(YOUNG / DENSITY)
    step = COURANT * cell / wave
    side, up = Axis(0.0, cell, cell, collapsed=True), Axis(0.0, LENGTH + 4 * cell, cell)
    body = box(1.0, 1.0, 0.5, density=ratio * DENSITY * cell**3 / 0.5, velocity=(0.0, 0.0, -SPEED),
               position=(cell / 2, cell / 2, 0.0), rest_on=LENGTH, held=("x", "y", "rx", "ry", "rz"))
    simulation, records, told = watched(scene(
        "light", Grid(side, side, up, Faces(z_min="fixed")), elastic(YOUNG), [body], step,
        [Stage("hit", int(1.5 * LENGTH / wave / step))], soil={"top": LENGTH}, time=time))
    exact = -SPEED * np.exp(-records[-1].time * wave / (ratio * cell))
    speed = simulation.state.bodies[0].velocity[2]
    return Seen(abs(speed - exact) / SPEED, tuple(text for text in told if "cells under" in text))
