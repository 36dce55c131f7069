"""Deformation gradients that have grown beyond any meaning are begun anew, before their volume is round-off."""

from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.soil import kinematics
from hybrid.soil.kinematics import F_LIMIT, STRETCH_LIMIT, update_strains

ALL = np.ones(3, bool)
STEP = np.eye(3) + np.array([[0.05, 0.3, 0.1], [0.0, 0.02, -0.2], [0.1, 0.0, 0.05]])   # shears and loosens


def carried(F, step=STEP, deforms=ALL):
    """F, b_e and Cauchy stress after a step ΔF from `F` (3, 3), under a Kirchhoff pressure of 6 Pa."""
    trial = SimpleNamespace(increment=step[None], directions=np.eye(3)[None])
    old = SimpleNamespace(deformation=np.asarray(F, float)[None])
    return [a[0] for a in update_strains(trial, np.zeros((1, 3)), -6.0 * np.eye(3)[None], old, deforms)]


def test_what_is_not_worn_is_multiplied():
    F = np.array([[3.0, 90.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 1.0]])
    small = carried(F, np.eye(3) * 1.01)[0]
    np.testing.assert_allclose(small, 1.01 * F, rtol=1e-15)


def test_what_is_worn_keeps_its_volume_and_the_force_of_its_stress():
    F = np.array([[2.0, 2 * F_LIMIT, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 3.0]])
    new, _, cauchy = carried(F)
    volume = np.linalg.det(STEP @ F)
    np.testing.assert_allclose(new, volume ** (1 / 3) * np.eye(3), rtol=1e-12)
    np.testing.assert_allclose(cauchy * volume, -6.0 * np.eye(3), rtol=1e-12)


def test_what_has_come_apart_keeps_a_volume_within_reason():
    np.testing.assert_allclose(carried(2 * F_LIMIT * np.eye(3), np.eye(3))[0], STRETCH_LIMIT * np.eye(3))


def test_a_collapsed_axis_stays_as_it_is():
    F = np.array([[2.0, 2 * F_LIMIT, 0.0], [0.0, 1.5, 0.0], [0.0, 0.0, 1.0]])
    new = carried(F, np.eye(3), np.array([True, True, False]))[0]
    np.testing.assert_allclose(new, np.diag([3**0.5, 3**0.5, 1.0]), rtol=1e-12)


@pytest.mark.parametrize("limit", [F_LIMIT, np.inf])
def test_soil_that_is_carried_apart_for_long(monkeypatch, limit):
    """2000 steps: volumes of 1.1 to 5 200 times the first, or none that is a number where F may grow."""
    plain = kinematics._update.py_func
    monkeypatch.setitem(plain.__globals__, "F_LIMIT", limit)
    monkeypatch.setattr(kinematics, "_update", plain)
    F, volumes = np.eye(3), []
    with np.errstate(all="ignore"):
        for _ in range(2000):
            F = carried(F)[0]
            volumes.append(np.linalg.det(F))
    assert (1.0 < min(volumes) and max(volumes) < 1e4) == (limit == F_LIMIT)
