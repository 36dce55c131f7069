"""A sphere or a cylinder rolls or slides down a rough slope for a second; the soil of the slope is held.

    slides, tan θ > (1 + 1/k) μ:   d = ½ g t² (sin θ - μ cos θ)        ω = μ g cos θ t / (k r)
    rolls:                         d = ½ g t² sin θ / (1 + k)          ω = 2 d / (r t)

k m r² is the moment of inertia, k = 2/5 for the sphere and 1/2 for the cylinder.

Cells of 0.25 m, 8 points each, and steps of 0.01 s as in Fig. 2a of Bird et al. (UKACM 2024), r = 0.25 m. The slope is
level and gravity is turned: by the slope θ, and about z by the heading. A body starts anywhere in a cell, turned at
random. Errors of the spin are relative to the exact one, or to that of rolling if the exact one is 0. The real body
never leaves the slope.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Axis, Body, Faces, Grid, Material, Scene, Soil, Stage, Time
from hybrid.study.random.family import Family, spread, uniform

GRAVITY, RADIUS, CELL, STEP, DURATION = 9.81, 0.25, 0.25, 0.01, 1.0
INERTIA = {"sphere": 0.4, "cylinder": 0.5}      # moment of inertia over m r²
AIMS = {"distance": 0.005, "spin": 0.01, "airborne": 0.01}
MARGIN = 0.75                                   # [m] of slope around the track
SHAPES = {"sphere": ("sphere.geo", {"radius": RADIUS, "size": 0.05}),
          "cylinder": ("cylinder.geo", {"radius": RADIUS, "height": 0.5, "size": 0.05})}


def law(shape, slope, mu, time=DURATION):
    """Distance [m] and spin [rad/s] from rest on a slope [deg]."""
    down, across = GRAVITY * np.sin(np.radians(slope)), GRAVITY * np.cos(np.radians(slope))
    k = INERTIA[shape]
    if mu < np.inf and down > (1 + 1 / k) * mu * across:
        return 0.5 * (down - mu * across) * time**2, mu * across * time / (k * RADIUS)
    return 0.5 * down / (1 + k) * time**2, down / (1 + k) * time / RADIUS


def draw(generator):
    """Values of a ride."""
    return {"slope": uniform(generator, 10.0, 70.0, 2), "mu": uniform(generator, 0.0, 1.0),
            "heading": uniform(generator, 0.0, 360.0, 2), "young": spread(generator, 1e6, 1e9),
            "start": [uniform(generator, 0.0, CELL) for _ in range(2)],
            "turn": [uniform(generator, -180.0, 180.0, 2) for _ in range(3)]}


def scene(shape, slope, mu, heading, young, start, turn):
    """Scene of a ride; turn: Euler angles [deg] of the sphere's mesh, the first of them about a cylinder's axis."""
    along = direction(heading)
    down = GRAVITY * np.sin(np.radians(slope))
    gravity = (down * along[0], down * along[1], -GRAVITY * np.cos(np.radians(slope)))
    ends = np.array([start, np.array(start) + law(shape, slope, mu)[0] * along[:2]])
    low, high = (np.floor((ends.min(0) - MARGIN) / CELL), np.ceil((ends.max(0) + MARGIN) / CELL))
    x, y = (Axis(start=a * CELL, end=b * CELL, size=CELL) for a, b in zip(low.tolist(), high.tolist()))
    file, parameters = SHAPES[shape]
    body = Body(GEOMETRY / file, 1000.0, name=shape, parameters=parameters, position=(*start, 0.0), rest_on=0.0,
                rotation=rotation(shape, heading, turn), friction=mu)
    ground = Material(law="hencky", young=young, poisson=0.0, density=1000.0)
    return Scene(
        name="ride", grid=Grid(x, y, Axis(start=-CELL, end=0.0, size=CELL), Faces()),
        soil=Soil(ground, held=True, geostatic=False), bodies=(body,), gravity=gravity, time=Time(step=STEP),
        stages=(Stage("ride", round(DURATION / STEP)),))


def direction(heading):
    """Unit vector of a heading [deg] in the plane."""
    return np.array([np.cos(np.radians(heading)), np.sin(np.radians(heading)), 0.0])


def rotation(shape, heading, turn):
    """(ax, ay, az, angle) that turns the mesh at random; a cylinder lies across the heading."""
    if shape == "sphere":
        turned = Rotation.from_euler("zyx", turn, degrees=True)
    else:
        turned = Rotation.from_euler("zxz", [turn[0], -90.0, heading], degrees=True)
    vector = turned.as_rotvec()
    angle = np.linalg.norm(vector)
    return (*(vector / angle).tolist(), float(np.degrees(angle)))


def measure(run, shape, slope, mu, heading, time=DURATION, **_):
    """{error: value} of a ride of `time` [s]."""
    begin, end = run.simulation.initial_bodies[0], run.simulation.state.bodies[0]
    along = direction(heading)
    distance = (end.position - begin.position) @ along
    spin = (end.rotation @ end.spin) @ np.cross((0.0, 0.0, 1.0), along)
    exact, rolling = law(shape, slope, mu, time), law(shape, slope, np.inf, time)
    return {"distance": distance / exact[0] - 1, "spin": (spin - exact[1]) / (exact[1] or rolling[1]),
            "airborne": airborne(run)}


def airborne(run):
    """Share of the steps that end without contact."""
    return np.mean([not np.any(record.bodies[0].contact_force) for record in run.records])


def family(shape):
    """Family of the rides of a "sphere" or a "cylinder"."""
    return Family(f"{shape} on a slope that is held", AIMS, lambda generator: {"shape": shape, **draw(generator)},
                  lambda **values: [scene(**values)], measure, seeds=100)


FAMILIES = {shape: family(shape) for shape in INERTIA}
