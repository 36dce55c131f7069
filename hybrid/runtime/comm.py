"""Sums and maxima over all points, nodes, corners or unknowns.

Each process of a parallel run would hold its own points; these are the only places where their numbers meet. Today
there is one process, and what it holds is all.
"""

import numpy as np


def total(values, axis=0):
    """Sum of an array along its first axis, over all processes."""
    return np.sum(values, axis=axis)


def largest(values):
    """Largest of non-negative values, 0 of none, over all processes."""
    return float(np.max(values, initial=0.0))


def maximum(values, empty=0.0):
    """Largest of values of any sign, `empty` of none, over all processes."""
    return float(np.max(values)) if np.size(values) else empty


def norm(vector):
    """Euclidean norm of a vector spread over all processes."""
    return float(np.linalg.norm(vector))
