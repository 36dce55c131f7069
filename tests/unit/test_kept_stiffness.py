"""Which points are assembled again: those whose stress, tangent or deformation has changed by more than the tolerance."""

import numpy as np
import pytest

from hybrid.soil.stiffness import mark_changed, Origin

LIMIT = 0.1     # [Pa], of a modulus of 10 Pa: a hundredth of it in ΔF^-1


def origin(n=3):
    return Origin(np.full((n, 3, 3), 10.0), np.zeros((n, 3)), np.zeros((n, 3, 3)), np.zeros((n, 3, 3)))


def marked(now, before, limit=LIMIT):
    changed = np.empty(len(now.stress), bool)
    mark_changed(now, before, np.full(len(now.stress), limit), changed)
    return changed


@pytest.mark.parametrize("name, step", [("tangent", LIMIT), ("stress", LIMIT), ("inverse", 0.01), ("mean_inverse", 0.01)])
def test_a_point_is_marked_by_any_of_what_its_tangent_follows_from(name, step):
    """The second point changes by more than allowed and the third by less; the origin follows the second alone."""
    before, now = origin(), origin()
    values = getattr(now, name)
    values[1, ..., 2], values[2, ..., 2] = values[1, ..., 2] - 1.01 * step, values[2, ..., 2] + 0.99 * step
    np.testing.assert_array_equal(marked(now, before), [False, True, False])
    np.testing.assert_array_equal(getattr(before, name)[1], values[1])
    np.testing.assert_array_equal(getattr(before, name)[[0, 2]], getattr(origin(), name)[[0, 2]])


def test_small_changes_add_up_to_one_that_counts():
    before, now = origin(), origin()
    now.stress[0, 1] = 0.6 * LIMIT
    assert not marked(now, before).any()
    now.stress[0, 1] = 1.2 * LIMIT
    np.testing.assert_array_equal(marked(now, before), [True, False, False])
    assert not marked(now, before).any()


def test_a_negative_limit_marks_all():
    assert marked(origin(), origin(), limit=-LIMIT).all()
