"""The only place for sums, counts, extremes, norms and numbering over points, nodes, corners or unknowns.

In a parallel run each process would hold its own points. No other module may assume that one process holds all of them:
a number over all points is computed by a function of this module, from the values that this process holds
(tests/unit/test_comm.py lists the exceptions). Processes exchange these numbers in `_over_processes` alone. Today there
is one process, and it holds all values.
"""

import numpy as np


def _over_processes(local, combine):
    """Result over all processes from the `local` one of each; combine: function of two results."""
    return local


def total(values, axis=0):
    """Sum of an array along an axis, the first unless given, over all processes."""
    return _over_processes(np.sum(values, axis=axis), np.add)


def count(chosen):
    """Number of entries that are true or not zero, over all processes."""
    return int(_over_processes(np.count_nonzero(chosen), np.add))


def number(items):
    """Number of points, corners or other items that all processes hold."""
    return int(_over_processes(len(items), np.add))


def largest(values):
    """Largest of non-negative values, 0 of none, over all processes."""
    return float(_over_processes(np.max(values, initial=0.0), np.maximum))


def maximum(values, empty=0.0):
    """Largest of values of any sign, over all processes; `empty` if there is no value."""
    found = float(_over_processes(np.max(values, initial=-np.inf), np.maximum))
    return empty if found == -np.inf else found


def minimum(values, empty=0.0):
    """Smallest of values of any sign, over all processes; `empty` if there is no value."""
    found = float(_over_processes(np.min(values, initial=np.inf), np.minimum))
    return empty if found == np.inf else found


def anywhere(chosen):
    """Whether an entry is true or not zero in any process."""
    return bool(_over_processes(np.any(chosen), np.logical_or))


def norm(vector):
    """Euclidean norm of a vector that is distributed over all processes."""
    return float(_over_processes(np.linalg.norm(vector), np.hypot))
