"""The scene that most benchmarks measure: a block of soil under gravity."""

from dataclasses import replace

from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Axis, Body, Faces, Grid, Material, Output, Scene, Soil, Solver, Stage, Time

ELASTIC = {"law": "hencky", "young": 10e6, "poisson": 0.3, "density": 1800.0}
SAND = {**ELASTIC, "law": "drucker-prager", "friction_angle": 32.0, "dilation_angle": 2.0, "cohesion": 1e3}


def block(cells=(23, 23, 11), size=1 / 23, material=SAND, body=None, steps=5, inertia=True, ghost=0.0, solver=Solver()):
    """Scene of a block of `cells` cells of `size` [m] on rollers, below two empty layers; gravity acts from the start.

    body: (side [m], penalty [1/m]) of a cube of steel that stands on the middle of the block, or None.
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


def contracted(state, share=1e-3):
    """`state` with its points moved towards their centre by a `share` of their distance: their domains then reach into
    neighbouring cells, as they do in soil that has moved."""
    position = state.points.position
    centre = 0.5 * (position.min(axis=0) + position.max(axis=0))
    return replace(state, points=replace(state.points, position=centre + (1 - share) * (position - centre)))
