"""The strip footing as a problem of a study."""

import math
from dataclasses import replace

import numpy as np
import problem_checks
import pytest

from hybrid.study.precision.problems import footing

ERROR = "Nc, φ = 20°"


def test_without_fbar_it_comes_down_slowly(recorded):
    """Soil that locks: 25 and 15 %. With the defaults 14 and 9 %."""
    found = recorded(footing, "neither F-bar nor ghost")
    assert (problem_checks.orders(found, ERROR) > 0.5).all() and 0.13 < found[-1].errors[ERROR] < 0.18
    defaults = recorded(footing, "default")
    assert defaults[0].errors[ERROR] < 0.16 and defaults[1].errors[ERROR] < 0.1
    assert set(found[0].errors) == set(footing.ERRORS) and math.isnan(found[0].errors["Nc, φ = 0"])


def test_a_wrong_answer_is_seen(monkeypatch, recorded):
    """A cone matched to compression instead of plane strain is far too strong."""
    right = recorded(footing, "default")[0]
    material = footing.material
    monkeypatch.setattr(footing, "material", lambda angle: replace(material(angle), cone="compression"))
    assert footing.solve(**right.values).errors[ERROR] > 0.35


def test_clay_without_a_cure_locks():
    assert footing.solve(across=2, angle=0, soil=footing.PLAIN).errors["Nc, φ = 0"] == pytest.approx(0.91, abs=0.03)


def test_a_graded_grid_has_fewer_unknowns():
    """Uniform down to a width, then each cell 1.3 times the one before, to the same depth or a little farther."""
    even, graded = footing.nodes(0.25, 4.0), footing.nodes(0.25, 4.0, 1.3)
    assert even[-1] == 4.0 and len(graded) < len(even) and 4.0 <= graded[-1] < 5.5
    gaps = (graded[1:] - graded[:-1])[8:]
    assert gaps == pytest.approx(0.25 * 1.3 ** (1 + np.arange(len(gaps))))


def test_labels_and_values():
    problem_checks.check(footing.PROBLEM)
