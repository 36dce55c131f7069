"""Types of the arguments of kernels: those that numba finds, found once."""

from typing import NamedTuple

import numpy as np
import pytest
from numba import njit, typeof
from numba.core import dispatcher

from hybrid.runtime import kernel_types
from hybrid.soil.basis import Basis


class Mixed(NamedTuple):
    array: np.ndarray
    number: float
    nested: tuple
    nothing: None


@njit
def total(basis):
    return basis.value.sum()


def basis(count=1):
    return Basis(*(np.ones((count, 3), kind) for kind in (np.int32, np.int32, float, float)))


VALUES = [basis(), (np.ones(3), np.ones((2, 2), order="F"), np.ones((4, 4))[::2]),
          Mixed(np.ones(1), 2.0, (np.ones(2), np.float64(1)), None),
          (np.ones(2), 3), (np.ones(2), 2**63), (1, 2), ()]


@pytest.mark.parametrize("value", VALUES, ids=str)
def test_they_are_those_of_numba(value):
    for _ in range(2):
        assert dispatcher.typeof(value) == typeof(value)


def test_what_may_not_be_written_is_of_another_type():
    fixed = np.ones(2)
    fixed.flags.writeable = False
    assert dispatcher.typeof((fixed,)) != dispatcher.typeof((np.ones(2),))


def test_a_kernel_finds_them_once(monkeypatch):
    assert dispatcher.typeof is kernel_types.typeof
    total(basis(2))     # compiled
    asked = []
    monkeypatch.setattr(kernel_types, "_numba_typeof", lambda *value: asked.append(value))
    for count in range(3, 20):
        assert total(basis(count)) == 3 * count
    assert asked == []
