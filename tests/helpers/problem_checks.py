"""Checks and measures that hold for every problem of the study of precision (hybrid.study.precision.problem)."""

import json
from inspect import signature

import numpy as np


def check(problem, takes=None):
    """Curves have settings with distinct labels; the quick settings are among them, with the same values; values can be
    stored as JSON and are valid arguments of `solve`, or of `takes`, the function that solve passes them to."""
    full, quick = problem.curves(False), problem.curves(True)   # quick may be empty
    assert isinstance(problem.title, str) and problem.errors and "default" in full
    assert (problem.transferable is None) == (problem.length == "")
    for curve, settings in quick.items():
        assert set(map(str, settings)) <= set(map(str, full[curve]))
    for settings in full.values():
        labels = [label for label, _ in settings]
        assert labels and len(set(labels)) == len(labels)
        for _, values in settings:
            assert json.loads(json.dumps(values)) == values
            signature(takes or problem.solve).bind(**values)


def solved(problem, curve, last=None):
    """RunResults of the quick settings of a curve, or of its `last` ones."""
    return [problem.solve(**values) for _, values in problem.curves(True)[curve][-(last or 0):]]


def orders(found, error):
    """Observed orders over successive halvings of the cells."""
    errors = np.array([f.errors[error] for f in found])
    return np.log2(errors[:-1] / errors[1:])
