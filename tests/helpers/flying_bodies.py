"""Bodies high above held soil, that meet one another alone."""

from dataclasses import replace

from hybrid.setup.build import build
from hybrid.study.scenes import plane

G = 9.81


def scene(bodies, steps, step, gravity=(0.0, 0.0, -G), contacts=(), **options):
    """Bodies high above held soil."""
    return replace(plane(bodies[0], steps, step, gravity=gravity, **options), bodies=tuple(bodies), contacts=tuple(contacts))


def run(described):
    simulation = build(described)
    return simulation, list(simulation.steps())


def kinetic(simulation, states):
    return sum(0.5 * m.mass * s.velocity @ s.velocity + 0.5 * s.spin @ m.inertia @ s.spin
               for m, s in zip(simulation.masses, states))
