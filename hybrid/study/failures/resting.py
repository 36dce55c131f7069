"""Resting: soil should stay where it is for as long as one looks, and come back when it is nudged.

    | . . . |   column of 2 m, 4 cells, E = 10 MPa, ν = 0.3, own weight, steps of 0.02 s of undamped Newmark; all of it
    | . . . |   has an upward speed at the start, at the top 1 µm/s
    |_______|

Soil that starts without stress swings by its own sag for ever: nothing damps it. With the stress of its weight it is at
rest to round-off; without the nudge no bit of it changes in 10 000 steps. Nudged, the surface leaves the face of cells
that it lay on, and a new node above it carries next to nothing: that takes the stress off the uppermost point, ρ g h/4,
once. The top moves by 1 % of the sag on 4 cells, by 0.1 % on 16, and after 10 000 steps by no more. Known: half the
largest way of the top after the start, over the sag ρ g L²/2M, M = E (1 - ν)/(1 + ν)(1 - 2ν), is 0 but for the nudge.
"""

import numpy as np

from hybrid.scene import Axis, Faces, Grid, Material, Output, Scene, Soil, Stage, Time
from hybrid.setup.build import build
from hybrid.study.cases import told
from hybrid.study.outcome import Seen

TITLE = "soil at rest"
PARAMETERS = ("steps of 0.02 s",)
MEASURE, RIGHT, WRONG = "half the way of the top over the sag", 0.05, 0.25
METHODS = {"no stress at the start": {"geostatic": False},
           "no stress, damped before": {"geostatic": False, "settle": 100},
           "stress of its weight": {}, "stress, increments of velocity": {"transfer": "increments"}}
DEFAULT = "stress of its weight"
SAYS = r"initial imbalance: .*(damps|settle|soil\.geostatic)"
LENGTH, CELLS, DENSITY, GRAVITY, YOUNG, POISSON, NUDGE = 2.0, 4, 1800.0, 9.81, 1e7, 0.3, 1e-6


def settings(quick=False):
    return [(steps,) for steps in ((10, 100) if quick else (10, 100, 1000, 10000))]


def solve(steps, settle=0, **soil):
    """Seen of the column over so many steps, after `settle` damped ones."""
    side, size = Axis(start=0.0, end=1.0, collapsed=True), LENGTH / CELLS
    material = Material(law="hencky", young=YOUNG, poisson=POISSON, density=DENSITY)
    stages = [Stage("settle", settle, beta=0.5625, gamma=1.0)] * (settle > 0) + [Stage("rest", steps)]
    simulation = build(Scene(
        name="column", soil=Soil(material, top=LENGTH, **soil), time=Time(0.02), stages=tuple(stages),
        grid=Grid(side, side, Axis(start=0.0, end=LENGTH + size, size=size), Faces()),
        gravity=(0.0, 0.0, -GRAVITY), output=Output(every=0, checkpoint=0)))
    height = simulation.initial_position[:, 2]
    simulation.state.points.velocity[:, 2] += NUDGE * height / LENGTH
    records, tops = [], []
    for record in simulation.steps():
        records.append(record)
        if record.step >= settle:
            tops.append(simulation.state.points.position[height.argmax(), 2])
    stiffness = YOUNG * (1 - POISSON) / (1 + POISSON) / (1 - 2 * POISSON)
    sag = DENSITY * GRAVITY * LENGTH**2 / (2 * stiffness)
    return Seen(float(0.5 * np.ptp(tops) / sag), tuple(text for text in told(simulation, records) if "initial" in text))
