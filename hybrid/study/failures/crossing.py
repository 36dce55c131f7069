"""Cell crossing: with standard shape functions all of a point's force jumps to other nodes when it crosses a face.

A column of 32 cells, ν = 0, is loaded by its own weight and softer from setting to setting, so that its top sinks
through about 16 ρgL/E cells. GIMP's domains hand the force over gradually. Exact: σ_zz = -ρ g (L - Z).
"""

import numpy as np

from hybrid.scene import Axis, Faces, Grid, Material, Output, Scene, Soil, Stage, Time
from hybrid.study.cases import watched
from hybrid.study.outcome import Seen

TITLE = "cell crossing"
PARAMETERS = ("weight of a column over its modulus, ρ g L / E",)
MEASURE, RIGHT, WRONG = "error of the stress over the weight", 0.01, 0.05
METHODS = {"standard MPM": {"basis": "mpm", "domain": "none"}, "GIMP": {}}
DEFAULT = "GIMP"
SAYS = r"once points cross cells.*Set soil\.basis"
LENGTH, CELLS, DENSITY, GRAVITY = 8.0, 32, 1000.0, 10.0


def settings(quick=False):
    return [(ratio,) for ratio in ((0.03, 1.0) if quick else (0.01, 0.03, 0.1, 0.3, 1.0, 3.0))]


def solve(ratio, **soil):
    """Seen of a column of that ratio."""
    weight = DENSITY * GRAVITY * LENGTH
    material = Material(law="hencky", young=weight / ratio, poisson=0.0, density=DENSITY)
    side = Axis(start=0.0, end=1.0, size=1.0, collapsed=True)
    simulation, _, told = watched(Scene(
        name="column", grid=Grid(side, side, Axis(start=0.0, end=LENGTH, size=LENGTH / CELLS), Faces()),
        soil=Soil(material, geostatic=False, **soil), gravity=(0.0, 0.0, -GRAVITY), time=Time(1.0, inertia=False),
        stages=(Stage("load", 20, gravity=(0.0, 1.0)),), output=Output(every=0, checkpoint=0)))
    Z, stress = simulation.initial_position[:, 2], simulation.state.points.stress[:, 2, 2]
    wrong = np.abs(stress + DENSITY * GRAVITY * (LENGTH - Z)) / weight
    return Seen(float(wrong.mean()), tuple(text for text in told if "soil.basis" in text))
