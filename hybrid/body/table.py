"""Values that change in time: linear between the times of a table, constant before its first and after its last time."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Table:
    """times (k,) [s], increasing; values (k, c)."""

    times: np.ndarray
    values: np.ndarray

    @classmethod
    def of(cls, rows, start, factor=1.0):
        """Table of rows (time after `start` [s], values...), the values times a `factor`."""
        rows = np.array(rows, float)
        return cls(start + rows[:, 0], factor * rows[:, 1:])

    def at(self, time):
        """(c,) at a time, or (t, c) at times (t,) [s]."""
        return np.stack([np.interp(time, self.times, column) for column in self.values.T], axis=-1)

    def integral(self, begin, end):
        """(c,) integral from time `begin` to `end` [s]."""
        inside = self.times[(self.times > begin) & (self.times < end)]
        times = np.concatenate([[begin], inside, [end]])
        values = self.at(times)
        return 0.5 * np.diff(times) @ (values[1:] + values[:-1])
