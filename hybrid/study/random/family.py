"""A family of random scenes: problems with a known answer whose parameters are drawn from a seed."""

from collections.abc import Callable
from dataclasses import dataclass
from zlib import crc32

import numpy as np

from hybrid.scene import Body, Scene, Soil, Solver, Stage, Time

# The fields of a scene's tables that state physics, cells and steps. All others are options and keep their defaults.
PHYSICS = {
    Soil: {"material", "top", "lower", "upper", "held", "geostatic", "k0", "layers"},
    Body: {"geometry", "density", "name", "parameters", "position", "rotation", "rest_on", "velocity", "spin", "held",
           "driven", "friction"},
    Time: {"step", "inertia"},
    Stage: {"name", "steps", "step", "gravity", "held"},
    Solver: set(),
    Scene: {"name", "grid", "soil", "bodies", "time", "stages", "gravity", "solver"},
}


@dataclass(frozen=True)
class Run:
    """A Simulation after all its steps, and their Records."""

    simulation: object
    records: list


@dataclass(frozen=True)
class Family:
    """One kind of problem. The docstring of its module gives the closed form.

    title: the problem in a few words; aims: {error: largest value [-] that counts as right}.
    draw(generator): values of a problem, a dict of numbers and texts, from a numpy generator.
    scenes(**values): the Scenes of a problem: one, or more that are compared.
    measure(*runs, **values): {error: value [-]}, given the Run of each scene; may have more errors than aims.
    seeds, quick: number of problems in a full and in a quick study.
    """

    title: str
    aims: dict[str, float]
    draw: Callable
    scenes: Callable
    measure: Callable
    seeds: int
    quick: int = 2

    def values(self, name, seed):
        """Values of problem number `seed` of the family of this name."""
        return self.draw(np.random.default_rng((crc32(name.encode()), seed)))

    def missed(self, errors):
        """Names of the errors that exceed their aim; a value that is not finite does."""
        return [name for name, aim in self.aims.items() if not abs(errors[name]) <= aim]


def uniform(generator, low, high, digits=4):
    """A random number of a few digits, so that the record can be read and typed."""
    return round(float(generator.uniform(low, high)), digits)


def spread(generator, low, high):
    """A random number whose logarithm is uniform, of three digits."""
    return float(f"{np.exp(generator.uniform(np.log(low), np.log(high))):.3g}")


def options_set(scene):
    """Names of the options that a Scene sets: fields other than PHYSICS that differ from their defaults."""
    tables = [scene, scene.soil, scene.time, scene.solver, *scene.bodies, *scene.stages]
    return [f"{type(table).__name__}.{name}" for table in tables
            for name, field in type(table).__dataclass_fields__.items()
            if name not in PHYSICS[type(table)] and getattr(table, name) != field.default]
