"""Derivatives by central differences, which tangents are compared with."""

import numpy as np


def central(function, size, h=1e-5):
    """Derivatives of a function of `size` unknowns at zero, along the last axis; an error of O(h²)."""
    return np.moveaxis(np.array([(function(h * e) - function(-h * e)) / (2 * h) for e in np.eye(size)]), 0, -1)
