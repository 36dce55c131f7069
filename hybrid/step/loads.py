"""Loads on soil and bodies: gravity, of which a stage may apply a share, and a given body force.

    b(t) = s(t) g   on bodies          b_p(t) = s(t) g + f(t, X_p)   on points          [m/s²]

The share s changes linearly from `low` to `high` between `begin` and `end`; X_p are the points' initial positions.
Potential energy is that of the whole of gravity, so the rest of b appears as work of the load.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from hybrid.runtime.comm import total


@dataclass(frozen=True)
class Loads:
    """gravity (3,) [m/s²]; body_force(time [s], initial positions (n, 3) [m]) -> (n, 3) [m/s²], None without one;
    begin, end [s] and low, high [-] of the share of gravity."""

    gravity: np.ndarray
    body_force: Callable | None = None
    begin: float = 0.0
    end: float = 0.0
    low: float = 1.0
    high: float = 1.0

    def during(self, begin, length, shares):
        """The same loads in a stage of `length` [s] from `begin` [s] with shares (first, last) of gravity."""
        return replace(self, begin=begin, end=begin + length, low=shares[0], high=shares[1])

    @property
    def gravity_alone(self):
        """Whether all of gravity acts and nothing else."""
        return self.body_force is None and self.low == self.high == 1.0

    def on_bodies(self, time):
        """(3,) [m/s²] at `time` [s]."""
        if self.low == self.high:
            return self.high * self.gravity
        return np.interp(time, (self.begin, self.end), (self.low, self.high)) * self.gravity

    def on_points(self, time, initial):
        """(3,) [m/s²], or (n, 3) with a body force, on points from `initial` positions (n, 3) [m] at `time` [s].

        Raises ValueError when the body force is not finite or of another shape.
        """
        common = self.on_bodies(time)
        if self.body_force is None:
            return common
        own = np.asarray(self.body_force(time, initial), float)
        if own.shape != initial.shape or not np.isfinite(own).all():
            raise ValueError(f"body_force at t = {time:.6g} s gave an array of shape {own.shape}"
                             f"{'' if np.isfinite(own).all() else ' with values that are not finite'}; it must return "
                             f"finite accelerations [m/s²] of shape {initial.shape}, one for each point")
        return common + own

    def work(self, begin, end, mass, initial, moved):
        """Work [J] on points that `moved` (n, 3) [m] from time `begin` to `end` [s] of all but the whole of gravity."""
        mean = 0.5 * (self.on_points(begin, initial) + self.on_points(end, initial)) - self.gravity
        return float(total(mass * np.sum(mean * moved, axis=1)))
