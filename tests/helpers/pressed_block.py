"""A small block of soil with a sphere pressed into it: a step of it, and trial values away from rest."""

import numpy as np

from hybrid.scene import Axis, Body, Faces, Grid, Material, Scene, Soil, Stage, Time
from hybrid.setup.build import build
from hybrid.step.equations import begin
from hybrid.step.workspace import Workspace


def scene(geometry, law, friction, depth=0.02, held=(), **body):
    """A small block of soil with a sphere pressed `depth` into its middle; `body`: more of the sphere's options."""
    velocity, spin = np.array((0.4, 0.1, -depth / 0.01)), np.array((0.5, -1.0, 0.3))
    velocity[np.isin(("x", "y", "z"), held)] = 0.0
    spin[np.isin(("rx", "ry", "rz"), held)] = 0.0
    material = {
        "hencky": Material(law="hencky", young=1e6, poisson=0.3, density=1800.0),
        "drucker-prager": Material(law="drucker-prager", young=1e6, poisson=0.3, density=1800.0, friction_angle=30.0,
                                   dilation_angle=5.0, cohesion=2e3),
    }[law]
    axis = Axis(start=0.0, end=0.8, size=0.2)
    return Scene(
        name="block", grid=Grid(axis, axis, Axis(start=-0.6, end=0.2, size=0.2), Faces(z_min="fixed")),
        soil=Soil(material, top=0.0),
        bodies=(Body(geometry=geometry / "sphere.geo", density=3000.0, parameters={"radius": 0.25, "size": 0.12},
                     position=(0.43, 0.37, 0.25 + 0.005), velocity=tuple(velocity), spin=tuple(spin),
                     friction=friction, held=held, **body),),
        time=Time(step=0.01), stages=(Stage("one", 1),))


def prepared(described, seed=1, size=2e-3):
    """A Step of the scene and trial unknowns away from rest."""
    simulation = build(described)
    rng = np.random.default_rng(seed)
    points = simulation.state.points
    points.velocity[:] = 0.1 * rng.standard_normal(points.velocity.shape)
    points.acceleration[:] = rng.standard_normal(points.acceleration.shape)
    step = begin(simulation.model, simulation.state, described.time.step, True, Workspace(simulation.model))

    def of_all(increment):
        """An increment (6,) of every body, its free components."""
        return np.concatenate([np.array(increment)[body.free] for body in simulation.model.bodies])

    soil = size * rng.standard_normal(step.pattern.size)
    body = of_all([2e-3, -1e-3, -3e-3, 0.02, -0.03, 0.04])
    return step, step.moved(step.predictor(), soil, body)
