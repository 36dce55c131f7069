"""Scenes without inertia of a body that its weight or a stage moves on soil with weight."""

from hybrid.scene import Axis, Grid, Material, Scene, Soil, Stage, Time
from hybrid.study.scenes import NO_OUTPUT, ROLLERS, collapsed

CLAY = Material(law="von-mises", young=5e6, poisson=0.49, density=1700.0, strength=10e3)


def put_on_soil(body, size, x, z, y=None, material=CLAY, faces=ROLLERS, steps=1, **soil):
    """Scene of one stage of `steps` of 1 s.

    size [m]: of the cells; x, y, z: (start, end) [m] of the grid, plane strain in a slice of 1 m without y; soil: further
    values of that table, whose surface is at z = 0 unless it gives another.
    """
    across = Axis(*y, size) if y else collapsed()
    return Scene(
        name="put on soil", grid=Grid(Axis(*x, size), across, Axis(*z, size), faces),
        soil=Soil(material, **{"top": 0.0, **soil}), bodies=(body,), time=Time(1.0, inertia=False),
        stages=(Stage("put", steps),), output=NO_OUTPUT)
