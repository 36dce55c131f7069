"""The rolling sphere of demos/rolling_sphere.toml in 300 steps: with six unknowns, all but contact is overhead."""

import numpy as np

from hybrid.bench.timed_steps import sizes, timed_steps, warm
from hybrid.runtime.data import DEMOS
from hybrid.scene.file import load_scene
from hybrid.setup.build import build


def run(options):
    """One row: median time of a step without the first one, iterations, and distance of the sphere [m]."""
    warm()
    steps = 15 if options.quick else 300
    simulation = build(load_scene(DEMOS / "rolling_sphere.toml", [f"time.step={1 / 300}", f"stage.0.steps={steps}"]))
    start = simulation.state.bodies[0].position[0]
    records, seconds = timed_steps(simulation)
    return [{"steps": steps, "iterations": sum(record.iterations for record in records), "s": sum(seconds),
             "ms a step": 1e3 * float(np.median(seconds[1:])),
             "contact [ms a step]": 1e3 * sum(_contact(record) for record in records) / steps,
             "way [m]": float(simulation.state.bodies[0].position[0] - start), **sizes(simulation)}]


def _contact(record):
    return sum(value for phase, value in record.seconds.items() if phase.startswith("contact"))
