"""The only place for sums, maxima, norms and numbering over points, nodes, corners or unknowns.

In a parallel run each process would hold its own points. No other module may assume that one process holds all of them:
a number over all points is computed by a function of this module, from the values that this process holds. Today there
is one process, and it holds all values.
"""

import numpy as np


def total(values, axis=0):
    """Sum of an array along an axis, the first unless given, over all processes."""
    return np.sum(values, axis=axis)


def largest(values):
    """Largest of non-negative values, 0 of none, over all processes."""
    return float(np.max(values, initial=0.0))


def maximum(values, empty=0.0):
    """Largest of values of any sign, `empty` of none, over all processes."""
    return float(np.max(values)) if np.size(values) else empty


def norm(vector):
    """Euclidean norm of a vector that is distributed over all processes."""
    return float(np.linalg.norm(vector))
