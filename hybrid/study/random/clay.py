"""Clay that flows: a pipe and a cone pushed into it, and a block that is too soft for its weight.

Pipe: plane strain, in a slice that is shorter or longer than the pipe. A collapsed axis has no ends, so the force a
metre of slice does not depend on the length of the pipe.

Cone: a quarter of a penetrometer, smooth, pushed in from the surface. The force rises smoothly with the depth: jitter is
the deviation (root mean square) from a cubic through the last half of the run, relative to the mean force there.

Collapse: a block of the height H and the half width W, on a smooth base, under gravity that grows in 20 quasi-static steps.
Its weight over its strength is N = γ H / s_u = 4 to 40. In plane strain clay bears σ1 - σ3 = 2 s_u. A slab of the height h
carries itself if its thrust γ h²/2 - 2 s_u h is not above 0, so the block flows until h = 4 s_u / γ, and as it keeps its
volume

    half width in the end = W max(1, N / 4)

The grid reaches farther than that. The width is recorded without an aim, as the shape is a slab for large N only: of 18
blocks that finish those of N >= 14 are within 0 and +3 %, on slabs of 1 to 3 cells; for N < 10 the foot is up to 36 %
farther out. Soil that has to flow to a slab of less than a cell stops (N of 31 and 39).
"""

import numpy as np

from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Axis, Body, Faces, Grid, Material, Scene, Soil, Stage, Time
from hybrid.study.plasticity import graded
from hybrid.study.random.family import Family, spread, uniform
from hybrid.study.random.pressing import PUSHED, quasi_static

SINK, PIPE_STEPS = 0.2, 20      # of the pipe, in diameters
CONE_STEPS, GROWTH = 40, 1.5     # growth: of cells away from the cone


def clay(strength, rigidity, poisson=0.49):
    """Undrained clay; rigidity: E / s_u."""
    return Material(law="von-mises", young=rigidity * strength, poisson=poisson, density=1800.0, strength=strength)


# ------------------------------------------------------------------ pipe


def draw_pipe(generator):
    """Values of a pipe; length: of the pipe in thicknesses of the slice."""
    return {"diameter": spread(generator, 0.2, 2.0), "across": int(generator.integers(3, 7)),
            "strength": spread(generator, 1e3, 5e4), "rigidity": spread(generator, 100.0, 500.0),
            "length": uniform(generator, 0.5, 3.0, 2), "thickness": uniform(generator, 0.2, 2.0, 2),
            "start": uniform(generator, 0.0, 1.0, 2)}


def pipe(diameter, across, strength, rigidity, length, thickness, start):
    """Scene of a pipe; across: cells in its diameter, thickness: of the slice in diameters, start: of its axis in
    cells."""
    size, slice_ = diameter / across, thickness * diameter
    x = Axis(start=-3 * diameter, end=3 * diameter, size=size)
    y = Axis(start=0.0, end=slice_, collapsed=True)
    z = Axis(start=-2 * diameter, end=2 * size, size=size)
    body = Body(GEOMETRY / "cylinder.geo", 1000.0, name="pipe", position=(start * size, 0.5 * slice_, 0.0), rest_on=0.0,
                rotation=(1.0, 0.0, 0.0, 90.0), velocity=(0.0, 0.0, -SINK * diameter / PIPE_STEPS), **PUSHED,
                parameters={"radius": 0.5 * diameter, "height": length * slice_, "size": 0.1 * diameter})
    return quasi_static("pipe", Grid(x, y, z, Faces(z_min="fixed")),
                        Soil(clay(strength, rigidity), top=0.0, geostatic=False), body, PIPE_STEPS)


def measure_pipe(*runs, diameter, thickness, strength, **_):
    """{error: value} of a pipe against one that is as long as the slice is thick."""
    factor, same = (run.records[-1].bodies[0].contact_force[2] / (thickness * diameter**2 * strength) for run in runs)
    return {"force": factor / same - 1 if same else np.inf, "V/(D s_u)": factor}


# ------------------------------------------------------------------ cone


def draw_cone(generator):
    """Values of a cone."""
    return {"radius": spread(generator, 0.02, 0.5), "angle": uniform(generator, 45.0, 90.0, 1),
            "strength": spread(generator, 1e3, 1e5), "rigidity": spread(generator, 100.0, 500.0),
            "across": uniform(generator, 2.0, 3.0, 2)}


def cone(radius, angle, strength, rigidity, across, depth=3.0):
    """Scene of a cone; across: cells in its radius; depth: of its shoulder in the end, in radii."""
    size, height = radius / across, radius / np.tan(np.radians(0.5 * angle))
    way = depth * radius + height
    side = Axis(nodes=tuple(graded(size, 1.5 * radius, 8 * radius, GROWTH)))
    deep = graded(size, way + radius, way + 6 * radius, GROWTH)
    down = Axis(nodes=(*(-z for z in deep[::-1]), size, 2 * size))
    body = Body(GEOMETRY / "cone.geo", 1000.0, name="cone", rest_on=0.0,
                parameters={"radius": radius, "angle": angle, "shaft": (depth + 2) * radius, "size": 0.3 * radius},
                velocity=(0.0, 0.0, -way / CONE_STEPS), **PUSHED)
    return quasi_static("cone", Grid(side, side, down, Faces(z_min="fixed")),
                        Soil(clay(strength, rigidity), top=0.0, geostatic=False), body, CONE_STEPS)


def measure_cone(run, radius, strength, **_):
    """{error: value} of a cone."""
    force = 4 * np.array([record.bodies[0].contact_force[2] for record in run.records])
    half = len(force) // 2
    steps = np.linspace(-1.0, 1.0, len(force) - half)
    off = force[half:] - np.polyval(np.polyfit(steps, force[half:], 3), steps)
    jitter = np.sqrt(np.mean(off**2)) / force[half:].mean() if force[half:].mean() > 0 else np.inf
    return {"jitter": jitter, "q/s_u": force[-1] / (np.pi * radius**2 * strength)}


# ------------------------------------------------------------------ collapse


def draw_collapse(generator):
    """Values of a block; load: weight at its foot over the strength, slender: height over width."""
    return {"height": spread(generator, 0.5, 20.0), "slender": uniform(generator, 0.5, 2.0, 2),
            "cells": int(generator.integers(5, 11)), "load": spread(generator, 4.0, 40.0),
            "rigidity": spread(generator, 50.0, 500.0), "poisson": uniform(generator, 0.2, 0.49, 2)}


def collapse(height, slender, cells, load, rigidity, poisson):
    """Scene of a block that is half a model; cells: in its height."""
    size, width = height / cells, initial_width(height, slender, cells)
    reach = np.ceil((1.5 * final_width(height, slender, cells, load) + 4 * size) / size) * size
    strength = 1800.0 * 10.0 * height / load
    grid = Grid(Axis(start=0.0, end=float(reach), size=size), Axis(start=0.0, end=size, collapsed=True),
                Axis(start=0.0, end=height + 2 * size, size=size), Faces(x_max="free"))
    soil = Soil(clay(strength, rigidity, poisson), upper=(width, size, height), geostatic=False)
    return Scene(name="collapse", grid=grid, soil=soil, bodies=(), time=Time(1.0, inertia=False),
                 stages=(Stage("load", 20, gravity=(0.0, 1.0)),), gravity=(0.0, 0.0, -10.0))


def initial_width(height, slender, cells):
    """Half width [m] of a block: a whole number of cells."""
    return max(1, round(cells / slender)) * height / cells


def final_width(height, slender, cells, load):
    """Half width [m] to which it flows on a smooth base."""
    return initial_width(height, slender, cells) * max(1.0, load / 4)


def measure_collapse(run, height, slender, cells, load, **_):
    """{error: value} of a block."""
    points = run.simulation.state.points
    front = (points.position + points.half_width)[:, 0].max()
    return {"thrown": max(0.0, points.position[:, 2].max() / height - 1),
            "width": front / final_width(height, slender, cells, load) - 1}


FAMILIES = {
    "pipe": Family("pipe in plane strain, any length", {"force": 0.01}, draw_pipe, lambda length, **values: [
        pipe(length=n, **values) for n in (length, 1.0)], measure_pipe, seeds=12, quick=1),
    "cone": Family("cone into clay", {"jitter": 0.03}, draw_cone, lambda **values: [cone(**values)], measure_cone,
                   seeds=8, quick=1),
    "collapse": Family("block of clay that collapses", {"thrown": 0.01}, draw_collapse,
                       lambda **values: [collapse(**values)], measure_collapse, seeds=20)}
