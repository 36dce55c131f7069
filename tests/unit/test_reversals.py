"""Contact points that slip to and fro: found between two evaluations, and held in stick for an update."""

from dataclasses import replace

import numpy as np
import pytest
from contact_bed import RATIO, box, contact_of, corners_in

from hybrid.contact.reversals import reversed_slip

Y = np.array([[0.2, 0.1, 0.49], [0.3, 0.2, 0.48], [-0.1, 0.2, 0.48]])
WAY = np.array([[0.05, 0.02, 0.0], [0.03, 0.0, 0.0], [1e-5, 0.0, 0.0]])     # from the anchor: the last point sticks


@pytest.fixture
def corners():
    return corners_in(box(), Y, Y - WAY)


def at(corners, share):
    """PointContact where the points are `share` (3,) of their ways from their anchors."""
    return contact_of(corners, box(), place=Y + (np.array(share) - 1)[:, None] * WAY)


def test_points_that_slip_the_other_way_are_found(corners):
    assert at(corners, [1, 1, 1]).slip.tolist() == [True, True, False]
    assert reversed_slip(at(corners, [1, 1, 1]), at(corners, [-1, 2, -1])).tolist() == [0]
    assert reversed_slip(at(corners, [1, -1, 1]), at(corners, [-1, 1, 1])).tolist() == [0, 1]


def test_points_that_stick_on_either_side_or_have_been_held_are_not(corners):
    for before, after in ((1, 1e-4), (1e-4, -1), (1, 2)):
        assert not len(reversed_slip(at(corners, [before, 1, 1]), at(corners, [after, 1, 1])))
    assert reversed_slip(at(corners, [1, -1, 1]), at(corners, [-1, 1, 1]), np.array([0])).tolist() == [1]


def test_points_that_open_are_not(corners):
    lifted = contact_of(corners, box(), place=Y + [[-0.1, -0.04, 0.1], [-0.06, 0.0, 0.0], [0.0, 0.0, 0.0]])
    assert reversed_slip(at(corners, [1, 1, 1]), lifted).tolist() == [1]


def test_a_point_held_in_stick_has_the_shear_and_the_tangent_of_stick(corners):
    """Its force is linear along the way, through zero at the anchor; the others have those of the law."""
    held = replace(corners, sticking=np.array([True, False, False]))
    free, stuck = at(corners, [1, 1, 1]), at(held, [1, 1, 1])
    assert free.slip.tolist() == [True, True, False] and stuck.slip.tolist() == [False, True, False]
    np.testing.assert_allclose(stuck.shear[0], RATIO * corners.stiffness[0] * WAY[0], rtol=1e-12)
    np.testing.assert_allclose(stuck.tangent[0] @ WAY[0], stuck.shear[0], rtol=1e-12)
    np.testing.assert_array_equal(stuck.force[1:], free.force[1:])
    np.testing.assert_array_equal(stuck.tangent[1:], free.tangent[1:])
