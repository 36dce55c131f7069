"""Builders of small scenes, for the studies and for tests."""

from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Axis, Body, Faces, Grid, Material, Output, Scene, Soil, Solver, Stage, Time

ROLLERS = Faces(z_min="fixed")
FREE = Faces(*["free"] * 6)
NO_OUTPUT = Output(every=0, checkpoint=0)
SCHEMES = {    # values of the table [time]
    "newmark": {"scheme": "newmark"},
    "dissipative": {"beta": 0.5625, "gamma": 1.0},
    "alpha": {"scheme": "generalised-alpha", "spectral_radius": 0.8},
    "default": {},
    "energy-momentum": {"scheme": "energy-momentum"},
}


def scene(name, grid, material, bodies, step, stages, soil=(), time=(), solver=(), gravity=(0.0, 0.0, 0.0)):
    """Scene without output; material: values of the soil's material as a dict; soil, time, solver: further values of
    these tables, as dicts."""
    return Scene(
        name=name, grid=grid, soil=Soil(Material(density=1000.0, **material), geostatic=False, **dict(soil)),
        bodies=tuple(bodies), time=Time(step=step, **dict(time)), stages=tuple(stages), solver=Solver(**dict(solver)),
        gravity=gravity, output=NO_OUTPUT)


def soil_scene(bodies=(), x=(0.0, 0.8), y=(0.0, 0.8), z=(-0.4, 0.4), size=0.2, faces=ROLLERS, young=1e6, poisson=0.0,
               steps=4, time=Time(step=0.01), gravity=(0.0, 0.0, 0.0), solver=Solver(linear="direct"), **soil):
    """Scene of elastic soil below z = 0 on a grid with cells of `size` [m]; x, y, z: (start, end) or an Axis; soil:
    further values of that table."""
    axes = [a if isinstance(a, Axis) else Axis(*a, size) for a in (x, y, z)]
    material = Material(law="hencky", young=young, poisson=poisson, density=1800.0)
    return Scene(name="block", grid=Grid(*axes, faces), soil=Soil(material, **{"top": 0.0, "geostatic": False, **soil}),
                 bodies=tuple(bodies), gravity=gravity, time=time, stages=(Stage("go", steps),), solver=solver)


def loaded_by_weight(name, grid, soil, steps, gravity, time=Time(1.0, inertia=False), **tables):
    """Scene of soil whose gravity (a tuple or its z component) grows linearly from 0 in quasi-static steps."""
    return Scene(name=name, grid=grid, soil=soil, time=time, stages=(Stage("load", steps, gravity=(0.0, 1.0)),),
                 gravity=gravity if isinstance(gravity, tuple) else (0.0, 0.0, gravity), output=NO_OUTPUT, **tables)


def collapsed(width=1.0):
    """Axis without motion, of one cell."""
    return Axis(start=0.0, end=width, collapsed=True)


def elastic(young, poisson=0.0):
    """Values of an elastic material."""
    return {"law": "hencky", "young": young, "poisson": poisson}


def box(length, width, height, size=10.0, **body):
    """Box of 1000 kg/m³; each face has two triangles unless their `size` [m] is smaller. body: values of the table."""
    parameters = {"length": length, "width": width, "height": height, "size": size}
    return Body(**{"geometry": GEOMETRY / "box.geo", "density": 1000.0, "parameters": parameters} | body)


def steel(*edges, size=10.0, **body):
    """Box of steel with these `edges`, (length, width, height) [m]."""
    return box(*edges, size, **{"density": 8000.0, **body})


def driven(*edges, velocity, **body):
    """Box of steel with a prescribed velocity, no rotation and frictionless contact."""
    return steel(*edges, velocity=velocity, driven=("x", "y", "z"), held=("rx", "ry", "rz"), **body)


def sphere(radius, size, growth=0.5, **body):
    """Sphere of 1000 kg/m³ with facets of `size` [m] and larger elements inside."""
    parameters = {"radius": radius, "size": size, "growth": growth}
    return Body(**{"geometry": GEOMETRY / "sphere.geo", "density": 1000.0, "parameters": parameters} | body)


def plane(body, steps, step, cell=0.25, cells=(4, 4), stiffness=1e6, settle=0, **rest):
    """Scene of a body on held soil with the surface z = 0 around the origin.

    cell [m]: size of the cells; cells: their number along x and y; stiffness [Pa/m]: p_f E for p_f = 1; settle: number
    of damped steps of 0.02 s before the run, in which the body moves along z only; rest: tables of `scene`.
    """
    x, y = (Axis(start=-n * cell / 2, end=n * cell / 2, size=cell) for n in cells)
    return scene("plane", Grid(x, y, Axis(start=-cell, end=0.0, size=cell), Faces()), elastic(stiffness), [body], step,
                 settling(settle) + [Stage("run", steps)], **{"soil": {"held": True}, **rest})


def settling(steps, step=0.02):
    """[The damped stage in which a body settles], empty without steps."""
    return [Stage("settle", steps, step, held=("x", "y", "rx", "ry", "rz"), beta=0.5625, gamma=1.0)] * (steps > 0)
