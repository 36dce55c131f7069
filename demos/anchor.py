"""How deep does a coarse anchor dig in a metre of drag? The scene of anchor.toml, written in Python.

        crown _____________________ shackle  - - - line - - - >  0.5 m/s
            \\ 35°
    ~~~~~~~~~\\~~~~~~~~~~~~~~~~~~~~~~~~~~~~  z = 0, sand of 38 % relative density

Half an AC-14-like anchor is meshed from its .geo, lowered in its attitude until it stands, and pulled through a line
of 1 MN/m. Cells of 0.4 m around the path, 8 points each, steps of 0.04 s: 3 200 points and 1 300 unknowns.

    .venv/bin/python demos/anchor.py         after ./run has set things up; results in out/coarse_anchor/
"""

from pathlib import Path

import numpy as np

import hybrid
from hybrid import Axis, Body, Faces, Grid, Material, Output, Pull, Scene, Soil, Stage, Time
from hybrid.output.history import read_history

GEOMETRY = Path(__file__).parents[1] / "geometry" / "stockless_anchor.geo"


def coarse_anchor(drag_steps=50, **anchor_parameters):
    """Scene of the half anchor on a coarse grid; parameters of the .geo can be given by name."""
    return Scene(
        name="coarse_anchor",
        grid=Grid(
            x=Axis(start=-2.4, end=5.6, size=0.4, fine=(-0.8, 3.6), growth=1.6),
            y=Axis(start=0.0, end=2.6, size=0.4, fine=(0.0, 1.2), growth=1.6),
            z=Axis(start=-2.6, end=1.6, size=0.4, fine=(-1.2, 1.6), growth=1.6),
            faces=Faces(z_min="fixed")),
        soil=Soil(Material(relative_density=38.0), top=0.0),
        bodies=(Body(
            name="anchor", geometry=GEOMETRY, density=7850.0, parameters={"size": 0.15, **anchor_parameters},
            rest_on=0.0, held=("y", "rx", "rz"), friction=0.45,
            pull=Pull(point="shackle", velocity=(0.5, 0.0, 0.0), stiffness=1e6, length=9.5)),),
        time=Time(step=0.04),
        stages=(Stage("settle", 25, step=0.04, pull=False, held=("ry",), beta=0.5625, gamma=1.0),
                Stage("drag", drag_steps)),
        output=Output(every=10, pictures=(drag_steps,)))


if __name__ == "__main__":
    hybrid.run(coarse_anchor(), out="out/coarse_anchor")
    history = read_history("out/coarse_anchor")
    drag = history["stage"] == "drag"
    depth = -history["anchor_z_m"][drag]
    tension = history["anchor_tension_N"][drag] / 1e3
    print(f"centre sinks by {depth[-1] - depth[0]:.2f} m in {np.ptp(history['anchor_x_m'][drag]):.2f} m of drag")
    print(f"line tension {tension[len(tension) // 2:].mean():.0f} kN on average over the second half")
    assert depth[-1] > depth[0] and (tension >= 0).all()
