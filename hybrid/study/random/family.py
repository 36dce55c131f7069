"""A family of random scenes: problems with a known answer whose parameters are drawn from a seed."""

from collections.abc import Callable
from dataclasses import dataclass
from zlib import crc32

import numpy as np


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
