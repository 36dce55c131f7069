"""Predicted first-contact points of open corners: anchors of friction, and the side of the body where it is touched."""

import numba
import numpy as np
import pytest
from contact_bed import RIGHT_HAND, ball, body_at, box

from hybrid.body.attitude import exp_so3
from hybrid.body.closest import closest
from hybrid.contact import body_to_body, samples
from hybrid.contact.closest_points import gaps_within_bounds
from hybrid.contact.first_contact import predicted_contact_points
from hybrid.contact.law import Coulomb
from hybrid.contact.search import distances


def test_anchor_is_where_the_predicted_path_reaches_the_surface():
    surface, body = box(), body_at((0.0, 0.0, 0.51))        # 10 mm above the bed z = 0
    start = np.array([[0.1, 0.2, 0.0], [0.3, -0.1, -0.012]])
    pose = np.array([0.04, 0.0, 0.49]), np.eye(3)           # 20 mm down, 40 mm along x
    anchor, side = predicted_contact_points(start, start, body, pose, surface, np.array([0.01, 0.022]))
    np.testing.assert_array_equal(side, [[0.0, 0.0, -1.0], [0.0, 0.0, 0.0]])
    np.testing.assert_allclose(anchor[0], [0.08, 0.2, -0.5], atol=2e-5)     # half way
    np.testing.assert_allclose(anchor[1], [0.28, -0.1, -0.512], atol=1e-12)  # not met: halfway, in case it is braked


def test_a_point_that_slides_past_the_surface_may_touch_on_the_way():
    """10 um off a face along which it slides 4 mm: if it touches after all, it has slid nearly all the way in contact."""
    surface, body, start = box(), body_at(), np.array([[0.1, 0.2, 0.5]])
    for off, share in ((-1e-6, 0.0), (0.0, 0.0), (1e-5, 0.05), (1e-4, 0.5), (1e-3, 0.5)):
        place = start + (0.0, 0.0, off)
        anchor, side = predicted_contact_points(
            place, place + (0.004, 0.0, 0.0), body, (body.position, body.rotation), surface, np.array([off]))
        np.testing.assert_allclose(anchor, place + (share * 0.004, 0.0, 0.0), atol=1e-12)
        assert not side.any()


def test_a_point_that_leaves_the_body_is_not_moved_before_its_start():
    """One that is 1 mm inside, by whatever history, and is predicted outside at the end."""
    surface, body, start = box(), body_at(), np.array([[0.1, 0.2, 0.499]])
    anchor, _ = predicted_contact_points(
        start, start + (0.004, 0.0, 0.01), body, (body.position, body.rotation), surface, np.array([-0.001]))
    np.testing.assert_allclose(anchor, start, atol=1e-12)


def test_rolling_without_sliding_has_no_friction():
    """From where it touches, a corner under a rolling ball hardly moves along the surface; from where it
    stood at the start of the step it moves a³/(3r²)."""
    surface, r, way, depth = ball(rings=90), 0.25, 0.04, 0.0002
    lowest = -surface.vertices[:, 2].min()
    body = body_at((0.0, 0.0, lowest - depth))
    pose = np.array([way, 0.0, lowest - depth]), exp_so3(np.array([0.0, way / r, 0.0]))
    corner = np.array([[way + 0.002, 0.0, 0.0]])
    start = (corner - body.position) @ body.rotation
    anchor, _ = predicted_contact_points(corner, corner, body, pose, surface, np.zeros(1))
    end = (corner - pose[0]) @ pose[1]
    normal = end / np.linalg.norm(end)

    def along(anchor):
        z = (end - anchor)[0]
        return np.linalg.norm(z - normal[0] * (z @ normal[0]))

    a = way + 0.002
    assert along(start) == pytest.approx(a**3 / (3 * r**2), rel=0.15)
    assert along(anchor) < 0.05 * along(start)
    assert abs(closest(anchor[0], np.inf, surface.tree)[4]) < 2e-5


def test_corners_that_move_beyond_their_clearance_touch():
    """Two corners over a box, with their distance as clearance: one stops just short of the box, one goes into it."""
    surface = box()     # its top is at z = 0.5
    start = np.array([[0.1, 0.2, 0.6], [0.1, 0.2, 0.6]])
    end = start - [[0.0, 0.0, 0.099], [0.0, 0.0, 0.25]]
    body = body_at(np.zeros(3), np.eye(3))
    place, side = predicted_contact_points(
        start, end, body, (body.position, body.rotation), surface, np.array([0.1, 0.1]))
    np.testing.assert_allclose(place[:, 2], [0.5505, 0.5], atol=1e-4)
    np.testing.assert_allclose(side, [[0, 0, 0], [0, 0, 1]], atol=1e-12)


def test_a_corner_inside_at_the_start_is_left_where_it_is():
    """It did not come in by any side in this step."""
    body, start = body_at(rotation=RIGHT_HAND), np.array([[0.1, 0.2, 0.3]])
    pose = body.position, body.rotation
    point, side = predicted_contact_points(start, start + 0.01, body, pose, box(), np.zeros(1))
    np.testing.assert_allclose(point, start @ RIGHT_HAND, atol=1e-15)
    assert not side.any()


def test_a_corner_on_the_surface_to_round_off_touches_where_it_stands():
    body, start = body_at(), np.array([[0.1, 0.2, 0.5 - 1e-12]])
    end = start - (0.05, 0.0, 0.02)
    point, side = predicted_contact_points(start, end, body, (body.position, body.rotation), box(), np.zeros(1))
    np.testing.assert_allclose(point, start, atol=2e-5)
    np.testing.assert_array_equal(side, [[0.0, 0.0, 1.0]])


def on_one_and_two_threads(searched):
    """The arrays that a function returns, of which no bit may depend on the number of threads."""
    threads, found = numba.get_num_threads(), []
    try:
        for count in (1, 2):
            numba.set_num_threads(count)
            found.append(searched())
    finally:
        numba.set_num_threads(threads)
    for one, two in zip(*found):
        np.testing.assert_array_equal(one, two)
        assert len(np.unique(one)) > 20


def test_searches_do_not_depend_on_the_number_of_threads():
    surface, body = ball(rings=30), body_at((0.0, 0.0, 0.0))
    start = 0.6 * np.random.default_rng(1).standard_normal((1000, 3)) * surface.radius
    pose = np.array([0.01, 0.0, 0.02]), exp_so3(np.array([0.0, 0.1, 0.0]))
    on_one_and_two_threads(lambda: [*predicted_contact_points(start, start, body, pose, surface, np.zeros(len(start))),
                                    *distances(start, surface, 0.5), gaps_within_bounds(start, surface)])


def test_contact_of_two_bodies_does_not_depend_on_the_number_of_threads():
    """Two balls of 0.25 m, their centres 0.36 m apart."""
    surface = ball(rings=30)
    side = body_to_body.Side(0, 1, samples.sample(surface, 0.02, 0.01, 1e-4), surface)
    poses = [(np.array([0.3, 0.0, 0.2]), RIGHT_HAND), (np.zeros(3), np.eye(3))]
    apart = [(2.0 * position, rotation) for position, rotation in poses]
    none = np.zeros(0, int), np.zeros((0, 3)), np.zeros(0)

    def searched():
        begun = body_to_body.begin(side, apart, poses, 1.0, none, 1e6, Coulomb(0.3, 0.5), np.zeros(3, bool))
        found = begun.evaluate(poses)
        return found.active, found.gap, found.force

    on_one_and_two_threads(searched)
