"""A sphere or a box rolls or slides down a slope of stiff elastic soil that deforms, for 0.3 s.

The sphere moves as on soil that is held (`rides`). A box slides by ½ g t² (sin θ - μ cos θ), or stays where it is if
tan θ < μ; its error is then relative to the distance without friction. The soil sinks by less than 1e-4 m.
"""

from dataclasses import replace

import numpy as np

from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Axis, Body, Faces, Grid, Soil
from hybrid.study.random import rides
from hybrid.study.random.family import Family, spread

DURATION, DEPTH, MARGIN = 0.3, 0.5, 0.5     # [s], [m]
BOX = {"length": 0.4, "width": 0.3, "height": 0.15, "size": 0.1}


def draw(generator):
    """Values of a ride."""
    return {"shape": str(generator.choice(["sphere", "box"])), **rides.draw(generator),
            "young": spread(generator, 1e8, 3e9)}


def scene(shape, slope, mu, heading, young, start, turn):
    """Scene of a ride; the first angle of `turn` [deg] turns a box about z."""
    held = rides.scene("sphere", slope, mu, heading, young, start, turn)
    ends = np.array([start, np.array(start) + farthest(slope) * rides.direction(heading)[:2]])
    low, high = np.floor((ends.min(0) - MARGIN) / rides.CELL), np.ceil((ends.max(0) + MARGIN) / rides.CELL)
    x, y = (Axis(start=a * rides.CELL, end=b * rides.CELL, size=rides.CELL) for a, b in zip(low.tolist(), high.tolist()))
    grid = Grid(x, y, Axis(start=-DEPTH, end=rides.CELL, size=rides.CELL), Faces(z_min="fixed"))
    body = held.bodies[0] if shape == "sphere" else Body(
        GEOMETRY / "box.geo", 1000.0, name=shape, parameters=BOX, position=(*start, 0.0), rest_on=0.0,
        rotation=(0.0, 0.0, 1.0, turn[0]), friction=mu)
    return replace(held, name="slab", grid=grid, soil=Soil(held.soil.material, top=0.0, geostatic=False), bodies=(body,),
                   stages=(replace(held.stages[0], steps=round(DURATION / rides.STEP)),))


def farthest(slope):
    """Distance [m] without friction."""
    return 0.5 * rides.GRAVITY * np.sin(np.radians(slope)) * DURATION**2


def measure(run, shape, slope, mu, heading, **_):
    """{error: value} of a ride."""
    if shape == "sphere":
        return rides.measure(run, shape, slope, mu, heading, DURATION)
    simulation = run.simulation
    moved = simulation.state.bodies[0].position - simulation.initial_bodies[0].position
    exact = max(0.0, 1 - mu / np.tan(np.radians(slope)))
    distance = moved @ rides.direction(heading) / farthest(slope) - exact
    turned = np.linalg.norm(simulation.state.bodies[0].spin) * DURATION
    return {"distance": distance / (exact or 1.0), "spin": turned, "airborne": rides.airborne(run)}


FAMILIES = {"slab": Family("sphere or box on a slope that deforms", rides.AIMS, draw,
                           lambda **values: [scene(**values)], measure, seeds=40)}
