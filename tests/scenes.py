"""Scenes that several tests start from."""

from pathlib import Path

from hybrid.scene import Axis, Body, Faces, Grid, Material, Output, Scene, Soil, Solver, Stage, Time

GEOMETRY = Path(__file__).parents[1] / "geometry"
SCHEMES = {    # values of the time table
    "newmark": {},
    "dissipative": {"beta": 0.5625, "gamma": 1.0},
    "alpha": {"scheme": "generalised-alpha"},
    "energy-momentum": {"scheme": "energy-momentum"},
}


def scene(name, grid, material, bodies, step, stages, soil=(), time=(), solver=(), gravity=(0.0, 0.0, 0.0)):
    """A Scene that writes nothing; soil, time, solver: more of their values, as dicts."""
    return Scene(
        name=name, grid=grid, soil=Soil(Material(density=1000.0, **material), geostatic=False, **dict(soil)),
        bodies=tuple(bodies), time=Time(step=step, **dict(time)), stages=tuple(stages), solver=Solver(**dict(solver)),
        gravity=gravity, output=Output(every=0, checkpoint=0))


def elastic(young, poisson=0.0):
    return {"law": "hencky", "young": young, "poisson": poisson}


def box(length, width, height, size=10.0, **body):
    """A box of 1000 kg/m³ whose faces are two triangles each unless `size` [m] says otherwise."""
    parameters = {"length": length, "width": width, "height": height, "size": size}
    return Body(**{"geometry": GEOMETRY / "box.geo", "density": 1000.0, "parameters": parameters} | body)


def sphere(radius, size, growth=0.5, **body):
    """A sphere of 1000 kg/m³ with facets of `size` [m], coarser inside."""
    parameters = {"radius": radius, "size": size, "growth": growth}
    return Body(**{"geometry": GEOMETRY / "sphere.geo", "density": 1000.0, "parameters": parameters} | body)


def plane(body, steps, step, cell=0.25, cells=(4, 4), stiffness=1e6, settle=0, **rest):
    """A body on a held plane z = 0 around the origin, of cells of `cell` [m]; stiffness: p_f E [Pa/m] of p_f = 1.

    settle: steps of 0.02 s before, in which nothing but z moves and that is damped.
    """
    x, y = (Axis(start=-n * cell / 2, end=n * cell / 2, size=cell) for n in cells)
    return scene("plane", Grid(x, y, Axis(start=-cell, end=0.0, size=cell), Faces()), elastic(stiffness), [body], step,
                 settling(settle) + [Stage("run", steps)], **{"soil": {"held": True}, **rest})


def settling(steps, step=0.02):
    """The stage in which a body settles, if it has any steps."""
    return [Stage("settle", steps, step, held=("x", "y", "rx", "ry", "rz"), beta=0.5625, gamma=1.0)] * (steps > 0)
