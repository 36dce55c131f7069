"""Scenes that several test modules share: a block of elastic soil whose top is z = 0, and box-shaped bodies."""

from hybrid.scene import Axis, Body, Faces, Grid, Material, Scene, Soil, Solver, Stage, Time

ROLLERS = Faces(z_min="fixed")
FREE = Faces(*["free"] * 6)


def soil_scene(bodies=(), x=(0.0, 0.8), y=(0.0, 0.8), z=(-0.4, 0.4), size=0.2, faces=ROLLERS, young=1e6, poisson=0.0,
               steps=4, time=Time(step=0.01), gravity=(0.0, 0.0, 0.0), solver=Solver(linear="direct"), **soil):
    """Scene of elastic soil below z = 0 in a grid of cells of `size` [m]; an axis is (start, end) or an Axis."""
    axes = [a if isinstance(a, Axis) else Axis(*a, size) for a in (x, y, z)]
    material = Material(law="hencky", young=young, poisson=poisson, density=1800.0)
    return Scene(name="block", grid=Grid(*axes, faces), soil=Soil(material, **{"top": 0.0, "geostatic": False, **soil}),
                 bodies=tuple(bodies), gravity=gravity, time=time, stages=(Stage("go", steps),), solver=solver)


def box(geometry, length, width, height, size=10.0, **body):
    """Body of box.geo with edges in m; `size` [m] of its triangles, by default as large as its sides."""
    return Body(**{"geometry": geometry / "box.geo", "density": 8000.0, **body},
                parameters={"length": length, "width": width, "height": height, "size": size})


def driven(geometry, *edges, velocity, **body):
    """A box of these edges that moves as told, with frictionless contact."""
    return box(geometry, *edges, velocity=velocity, driven=("x", "y", "z"), held=("rx", "ry", "rz"), **body)
