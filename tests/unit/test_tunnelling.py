"""Which contact points a step carried through a body, and which ones only flow round an edge of it."""

import numpy as np
import pytest
from contact_bed import box, contact_of, corners_in

from hybrid.contact.tunnelling import count_tunnelled

HALF = 1.0, 0.8, 0.5     # [m] of the box, whose lower face is z = -0.5
DEPTH = 0.005            # [m] that a corner may cut in
CENTRE = np.zeros(3), np.eye(3)


def passed(start, end, half=HALF):
    """Number of corners found to pass that go from `start` to `end` [m], given as seen from the body."""
    surface = box(half=half)
    outside = contact_of(corners_in(surface, start, start), surface).gap
    assert not len(outside), "starts within the body"
    corners = corners_in(surface, start, start, touching=False)
    place = np.atleast_2d(np.array(end, float))
    return count_tunnelled(corners, contact_of(corners, surface, place=place), place, *CENTRE, surface, DEPTH)


def test_soil_that_flows_round_an_edge_does_not_pass():
    """Entry through the side, at x = 1, close to the lower face; motion along the normal of that face. Largest depth:
    1.5 mm."""
    assert passed([1.001, 0.0, -0.490], [0.995, 0.0, -0.4995]) == 0
    assert passed([1.001, 0.0, -0.490], [0.994, 0.0, -0.502]) == 0     # and out again


def test_what_was_deep_on_its_way_round_an_edge_passes():
    assert passed([1.001, 0.0, -0.480], [0.970, 0.0, -0.499]) == 1
    assert passed([1.001, 0.0, -0.480], [0.970, 0.0, -0.503]) == 1


@pytest.mark.parametrize("thickness", [0.1, 0.006, 0.0005])
def test_what_came_in_by_the_opposite_side_passes_however_thin_the_body(thickness):
    """Near the lower face at the end, still within, or out below."""
    half = 1.0, 0.8, thickness / 2
    for end in (-0.4 * thickness, -0.6 * thickness):
        assert passed([0.3, 0.2, thickness / 2 + 0.002], [0.3, 0.2, end], half) == 1


def test_what_is_pushed_back_where_it_came_from_does_not_pass():
    assert passed([0.3, 0.2, -0.51], [0.3, 0.2, -0.47]) == 0


def test_many_are_counted():
    start = np.array([[1.001, 0.0, -0.490], [1.001, 0.0, -0.480], [0.3, 0.2, -0.51]])
    end = np.array([[0.995, 0.0, -0.4995], [0.970, 0.0, -0.499], [0.3, 0.2, 0.49]])
    assert passed(start, end) == 2
