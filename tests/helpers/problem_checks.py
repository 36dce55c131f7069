"""What every problem of a study has to keep (hybrid.study.sweep), whatever it computes."""

import json
from inspect import signature

import numpy as np


def check(problem, takes=None):
    """Curves have settings, quick ones are among them with the same values, which survive JSON and which solve, or
    what it hands them to, takes."""
    full, quick = problem.curves(False), problem.curves(True)   # quick may be empty
    assert isinstance(problem.TITLE, str) and problem.ERRORS and "default" in full
    for curve, settings in quick.items():
        assert set(map(str, settings)) <= set(map(str, full[curve]))
    for settings in full.values():
        labels = [label for label, _ in settings]
        assert labels and len(set(labels)) == len(labels)
        for _, values in settings:
            assert json.loads(json.dumps(values)) == values
            signature(takes or problem.solve).bind(**values)


def solved(problem, curve, last=None):
    """Found of the quick settings of a curve, or of the `last` so many of them."""
    return [problem.solve(**values) for _, values in problem.curves(True)[curve][-(last or 0):]]


def orders(found, error):
    """Observed, over successive halvings of the cells."""
    errors = np.array([f.errors[error] for f in found])
    return np.log2(errors[:-1] / errors[1:])
