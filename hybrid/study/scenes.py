"""Small scenes that studies and tests start from."""

from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Axis, Body, Faces, Grid, Material, Output, Scene, Soil, Solver, Stage, Time

ROLLERS = Faces(z_min="fixed")
FREE = Faces(*["free"] * 6)
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


def soil_scene(bodies=(), x=(0.0, 0.8), y=(0.0, 0.8), z=(-0.4, 0.4), size=0.2, faces=ROLLERS, young=1e6, poisson=0.0,
               steps=4, time=Time(step=0.01), gravity=(0.0, 0.0, 0.0), solver=Solver(linear="direct"), **soil):
    """Scene of elastic soil below z = 0 in a grid of cells of `size` [m]; an axis is (start, end) or an Axis."""
    axes = [a if isinstance(a, Axis) else Axis(*a, size) for a in (x, y, z)]
    material = Material(law="hencky", young=young, poisson=poisson, density=1800.0)
    return Scene(name="block", grid=Grid(*axes, faces), soil=Soil(material, **{"top": 0.0, "geostatic": False, **soil}),
                 bodies=tuple(bodies), gravity=gravity, time=time, stages=(Stage("go", steps),), solver=solver)


def elastic(young, poisson=0.0):
    return {"law": "hencky", "young": young, "poisson": poisson}


def box(length, width, height, size=10.0, **body):
    """A box of 1000 kg/m³ whose faces are two triangles each unless `size` [m] says otherwise."""
    parameters = {"length": length, "width": width, "height": height, "size": size}
    return Body(**{"geometry": GEOMETRY / "box.geo", "density": 1000.0, "parameters": parameters} | body)


def steel(*edges, size=10.0, **body):
    """A box of steel."""
    return box(*edges, size, **{"density": 8000.0, **body})


def driven(*edges, velocity, **body):
    """A box of steel that moves as told, with frictionless contact."""
    return steel(*edges, velocity=velocity, driven=("x", "y", "z"), held=("rx", "ry", "rz"), **body)


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
