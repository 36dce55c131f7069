"""What every problem of a study has to fulfil."""

import json

import numpy as np


def labels_and_values(problem):
    """Labels of quick settings are those of the full ones; values are what JSON gives back."""
    full = problem.curves(False)
    assert "default" in full and problem.TITLE and problem.ERRORS
    for curve, settings in problem.curves(True).items():
        assert dict(settings).items() <= dict(full[curve]).items()
    for settings in full.values():
        assert len(dict(settings)) == len(settings)
        for _, values in settings:
            assert json.loads(json.dumps(values)) == values


def solved(problem, curve):
    """Found of the quick settings of a curve."""
    return [problem.solve(**values) for _, values in problem.curves(True)[curve]]


def orders(found, error):
    """Observed, over successive halvings of the cells."""
    errors = np.array([f.errors[error] for f in found])
    return np.log2(errors[:-1] / errors[1:])
