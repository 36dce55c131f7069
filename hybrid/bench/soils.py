"""Scenes that the cases measure, and what they need to step through them."""

from dataclasses import replace
from time import perf_counter

import numpy as np

from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Axis, Body, Faces, Grid, Material, Output, Scene, Soil, Solver, Stage, Time
from hybrid.setup.build import build

ELASTIC = {"law": "hencky", "young": 10e6, "poisson": 0.3, "density": 1800.0}
SAND = {**ELASTIC, "law": "drucker-prager", "friction_angle": 32.0, "dilation_angle": 2.0, "cohesion": 1e3}


def block(cells=(23, 23, 11), size=1 / 23, material=SAND, body=None, steps=5, inertia=True, ghost=0.0, solver=Solver()):
    """Scene of a block of `cells` of `size` [m] on rollers, two empty layers above it, whose weight acts at once.

    body: side [m] of a cube of steel that stands in its middle, and its penalty [1/m], or None.
    """
    x, y, z = (n * size for n in cells)
    axes = Axis(0.0, x, size), Axis(0.0, y, size), Axis(0.0, z + 2 * size, size)
    bodies = () if body is None else (Body(
        GEOMETRY / "box.geo", 8000.0, "cube", dict.fromkeys(("length", "width", "height", "size"), body[0]),
        position=(x / 2, y / 2, 0.0), rest_on=z, penalty=body[1], friction=0.3),)
    return Scene(
        name="block", grid=Grid(*axes, Faces()), soil=Soil(Material(**material), top=z, geostatic=False, ghost=ghost),
        bodies=bodies, time=Time(0.01, inertia=inertia), stages=(Stage("fall", steps),), solver=solver,
        output=Output(every=0, checkpoint=0))


def off_the_lattice(state, share=1e-3):
    """`state` with its points drawn together, so that their domains reach into neighbouring cells as those of moving
    soil do."""
    position = state.points.position
    centre = 0.5 * (position.min(axis=0) + position.max(axis=0))
    return replace(state, points=replace(state.points, position=centre + (1 - share) * (position - centre)))


def warm():
    """Compile, so that no case measures that."""
    for material in (ELASTIC, SAND):
        list(build(block((3, 3, 2), 0.1, material, (0.1, 50.0), steps=1)).steps())


def stepped(simulation, most=None, after=lambda record: None):
    """Records of its steps, `most` at the most, and the wall time [s] of each; `after` is called with every record, off
    the clock. Raises StepError where one fails."""
    records, seconds, begin = [], [], perf_counter()
    for record in simulation.steps():
        seconds.append(perf_counter() - begin)
        records.append(record)
        after(record)
        if len(records) == most:
            break
        begin = perf_counter()
    return records, seconds


def sizes(simulation):
    """Points, unknowns and entries of the soil block as the model sheet has them."""
    modelled = simulation.sheet()["modelled"]
    return {"points": modelled["material points"], "unknowns": modelled["soil unknowns"] + modelled["body unknowns"],
            "entries": modelled["entries of the soil block"]}


def exponent(unknowns, values):
    """Power of the number of unknowns with which `values` go, by least squares."""
    return float(np.polyfit(np.log(unknowns), np.log(values), 1)[0])
