"""Turning: domains that follow the wrong part of the deformation are right until the soil turns.

The column of `hybrid.study.failures.crossing`, as soft as its weight, ρ g L / E = 1, of soil that has turned by an
angle before and carries no strain: F = R at the start, then F = U R as the column is squeezed by U along z.

    diagonal of F    F_zz = U_zz cos θ: domains shrink to nothing at 90 degrees, which is standard MPM
    right stretch    √(Fᵀ F) = Rᵀ U R: at 90 degrees they are squeezed along x instead of z, and overlap
    moments          those of the deformed domain along the axes of the grid: as without a turn

Exact: σ_zz = -ρ g (L - Z), whatever the turn.
"""

import numpy as np

from hybrid.scene import Axis, Faces, Grid, Material, Output, Scene, Soil, Solver, Stage, Time
from hybrid.setup.build import build
from hybrid.study.cases import told
from hybrid.study.outcome import Seen

TITLE = "soil that has turned"
PARAMETERS = ("turn before the load [degrees]",)
MEASURE, RIGHT, WRONG = "error of the stress over the weight", 0.01, 0.05
METHODS = {"diagonal of F": {"domain": "diagonal"}, "right stretch": {"domain": "stretch"}, "second moments": {}}
DEFAULT = "second moments"
SAYS = r'soil\.domain = .*rotate.*Set soil\.domain = "moments"'
LENGTH, CELLS, DENSITY, GRAVITY, STEPS = 8.0, 32, 1000.0, 10.0, 20


def settings(quick=False):
    return [(angle,) for angle in ((0, 90) if quick else (0, 15, 30, 45, 60, 75, 90))]


def solve(angle, **soil):
    """Seen of a column of soil that has turned by `angle`."""
    weight = DENSITY * GRAVITY * LENGTH
    material = Material(law="hencky", young=weight, poisson=0.0, density=DENSITY)
    side = Axis(start=0.0, end=LENGTH / CELLS, collapsed=True)
    simulation = build(Scene(
        name="column", grid=Grid(side, side, Axis(start=0.0, end=LENGTH, size=LENGTH / CELLS), Faces()),
        soil=Soil(material, geostatic=False, **soil), gravity=(0.0, 0.0, -GRAVITY), time=Time(1.0, inertia=False),
        stages=(Stage("load", STEPS, gravity=(0.0, 1.0)),), output=Output(every=0, checkpoint=0),
        solver=Solver(linear="direct")))
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    simulation.state.points.deformation[:] = [[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]
    records = list(simulation.steps())
    Z, stress = simulation.initial_position[:, 2], simulation.state.points.stress[:, 2, 2]
    wrong = np.abs(stress + DENSITY * GRAVITY * (LENGTH - Z)) / weight
    return Seen(float(wrong.mean()), tuple(text for text in told(simulation, records) if "soil.domain" in text))
