"""What does a grid that goes with a body save, and what does it cost in accuracy?

A smooth plough is pressed 0.08 m into soil while it slides 1.6 m along, once through a uniform
fine grid and then through grids that travel with it: a window of soil, cells that double away from the body, and both.
Prints for each: points, unknowns, wall time and Newton iterations, largest difference of the vertical force and
difference of the drive's work from those of the uniform grid.

    .venv/bin/python demos/travelling.py            cells of 0.1 m, 131 072 points in the uniform grid (half an hour)
    .venv/bin/python demos/travelling.py 0.2        cells of 0.2 m (one minute)
"""

import sys
import time
from pathlib import Path

import numpy as np

from hybrid.scene import Axis, Body, Faces, Grid, Material, Output, Scene, Soil, Stage, Time
from hybrid.setup.build import build

GEOMETRY = Path(__file__).parents[1] / "geometry"
LAWS = {
    "elastic": Material(law="hencky", young=2e6, poisson=0.3, density=1800.0),
    "clay": Material(law="von-mises", young=2e6, poisson=0.3, density=1800.0, strength=2e4),
}
SOILS = {"elastic": {}, "clay": {"fbar": True, "ghost": 0.0033}}     # clay locks as it flows
AROUND = ((2, 3), (2, 2), (3, 2))   # fine cells beyond the body's box, below and above it
WINDOW = (1.6, 1.6)                 # [m] of soil behind and ahead of it
KINDS = {"uniform": (False, False), "window": (False, True), "graded": (True, False), "both": (True, True)}


def scene(kind, law, size, steps=40):
    """Scene of a plough of 0.8 m, half of it about y = 0, that goes 1.6 m along and 0.08 m down."""
    graded, window = KINDS[kind]
    ends = ((0.0, 6.4), (0.0, 1.6), (-1.6, 0.8))
    axes = [Axis(*end, size, growth=1.5, doublings=int(np.log2(0.8 / size) + 0.5),
                 around=tuple(n * size for n in around) if graded else None,
                 window=WINDOW if window and axis == 0 else None)
            for axis, (end, around) in enumerate(zip(ends, AROUND))]
    plough = Body(
        GEOMETRY / "box.geo", 1000.0, "plough", {"length": 0.8, "width": 0.8, "height": 0.6, "size": 10.0},
        position=(1.6, 0.0, 0.301), velocity=(1.0, 0.0, -0.05), driven=("x", "y", "z"), held=("rx", "ry", "rz"))
    return Scene(
        name=f"plough-{kind}", grid=Grid(*axes, Faces(z_min="fixed")), soil=Soil(LAWS[law], top=0.0, **SOILS[law]),
        bodies=(plough,), time=Time(step=0.04, beta=0.5625, gamma=1.0), stages=(Stage("plough", steps),),
        output=Output(every=0, checkpoint=0))


def measure(described):
    """Vertical force (steps,) [N], work of the drive [J], and sizes of a run."""
    simulation = build(described)
    force, iterations, start = [], 0, time.perf_counter()
    for record in simulation.steps():
        force.append(record.bodies[0].contact_force[2])
        iterations += record.iterations
    sheet = simulation.sheet()["modelled"]
    return {"force": np.array(force), "work": record.energies["drive"], "points": len(simulation.state.points),
            "unknowns": sheet["soil unknowns"], "seconds": time.perf_counter() - start, "iterations": iterations}


def compare(law, size):
    """Yield (kind, points, unknowns, seconds, iterations, share of the time, force and work off [%])."""
    whole, settled = None, slice(10, None)
    for kind in KINDS:
        run = measure(scene(kind, law, size))
        whole = whole or run
        force = np.abs(run["force"] - whole["force"])[settled].max() / np.abs(whole["force"][settled]).mean()
        yield (kind, run["points"], run["unknowns"], run["seconds"], run["iterations"],
               run["seconds"] / whole["seconds"], 100 * force, 100 * (run["work"] / whole["work"] - 1))


def main(size=0.1):
    for law in LAWS:
        print(f"\n{law}, cells of {size:g} m")
        print(f"{'grid':10}{'points':>9}{'unknowns':>10}{'s':>8}{'its':>6}{'share':>8}{'force %':>9}{'work %':>8}")
        for kind, points, unknowns, seconds, iterations, share, force, work in compare(law, size):
            print(f"{kind:10}{points:9d}{unknowns:10d}{seconds:8.1f}{iterations:6d}{share:8.3f}{force:9.2f}{work:8.2f}",
                  flush=True)


if __name__ == "__main__":
    main(*map(float, sys.argv[1:]))
