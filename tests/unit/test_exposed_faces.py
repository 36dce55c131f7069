"""Faces at which the soil ends, and which sample of a body is assigned to which of them."""

from types import SimpleNamespace

import numpy as np
import pytest
from contact_bed import ball, bed, body_at, found_in_bed

from hybrid.body.attitude import exp_so3
from hybrid.contact.exposed_faces import LAYOUT, NORMALS, Frame, assign, crossing, exposed_faces

SQUARE = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * 0.05
UP = np.array([0.0, 0.0, 1.0])


def squares(*centres, tilt=0.0):
    """Corners (m, 4, 3) of horizontal faces of 0.1 m; the second one turned by `tilt` [rad] about its edge x = 0.05."""
    corners = SQUARE + np.array(centres)[:, None]
    if tilt:
        hinge = np.array([0.05, 0.0, 0.0])
        corners[1] = hinge + (corners[1] - hinge) @ exp_so3(np.array([0.0, tilt, 0.0])).T
    return corners


def test_frame_of_a_turned_rectangle():
    rotation, centre = exp_so3(np.array([0.3, -0.8, 0.5])), np.array([0.2, 0.1, -0.4])
    frame = Frame.from_corners((centre + SQUARE * (1.0, 3.0, 1.0) @ rotation.T)[None])
    np.testing.assert_allclose(frame.origin, [centre], atol=1e-15)
    np.testing.assert_allclose(frame.edges[0], [0.05 * rotation[:, 0], 0.15 * rotation[:, 1]], atol=1e-15)
    np.testing.assert_allclose(frame.normal, [rotation[:, 2]], atol=1e-14)
    np.testing.assert_allclose(frame.dual[0] @ frame.edges[0].T, np.eye(2), atol=1e-14)
    xi, gap = frame.local_coordinates((centre + rotation @ (0.05, -0.03, 0.007))[None])
    np.testing.assert_allclose(xi, [[1.0, -0.2]], atol=1e-14)
    np.testing.assert_allclose(gap, [0.007], atol=1e-15)


def test_corners_of_each_face_run_counter_clockwise_seen_from_outside():
    corners = np.array([[(c >> 2 & 1) - 0.5, (c >> 1 & 1) - 0.5, (c & 1) - 0.5] for c in range(8)])
    frame = Frame.from_corners(corners[LAYOUT])
    np.testing.assert_allclose(frame.normal, NORMALS, atol=1e-15)
    np.testing.assert_allclose(frame.origin, 0.5 * NORMALS, atol=1e-15)


@pytest.fixture(scope="module")
def in_bed():
    """Points of a flat bed up to z = 0 that fills the grid below, and its corners near a ball."""
    grid, position, half = bed()
    _, corners = found_in_bed(ball(), body_at((0.4, 0.4, 0.2)), reach=0.08, scatter=0.0)
    return grid, position, half, corners


def test_only_the_top_of_a_bed_is_exposed(in_bed):
    grid, position, half, corners = in_bed
    closed = SimpleNamespace(extent=grid.extent, closed=np.ones((3, 2), bool))
    face, point = exposed_faces(position, half, closed, corners)
    assert len(face) > 10
    np.testing.assert_allclose(corners.position[face][:, :, 2], 0.0, atol=1e-12)
    np.testing.assert_allclose(position[point, 2] + half[point, 2], 0.0, atol=1e-12)
    np.testing.assert_array_equal(corners.id[face] // 8, np.repeat(point[:, None], 4, axis=1))


def test_faces_of_a_hole_are_exposed(in_bed):
    """Without one point of the top layer its neighbours show one face each, and the point below its top."""
    grid, position, half, corners = in_bed
    closed = SimpleNamespace(extent=grid.extent, closed=np.ones((3, 2), bool))
    removed = np.argmin(np.linalg.norm(position - (0.425, 0.425, -0.025), axis=1))
    before = exposed_faces(position, half, closed, corners)[1]
    away = position.copy()
    away[removed] += (0.0, 0.0, 5.0)
    after = exposed_faces(away, half, closed, corners)[1]
    gained = np.setdiff1d(np.flatnonzero(np.bincount(after, minlength=len(position))
                                         > np.bincount(before, minlength=len(position))), [removed])
    np.testing.assert_allclose(np.linalg.norm(position[gained] - position[removed], axis=1), 0.05, atol=1e-12)
    assert len(gained) >= 4


def assigned(x, end, area=-0.01 * UP, depth=0.05, reach=0.1, touching=False):
    x = np.atleast_2d(np.array(x, float))
    return assign(x, np.tile(area, (len(x), 1)), end, np.full(len(end), depth), reach, np.full(len(x), touching))


def test_a_sample_gets_the_face_under_it_and_its_projected_area():
    face, area = assigned([[0.01, 0.02, -0.01], [0.12, 0.0, 0.02]], squares((0, 0, 0), (0.1, 0, 0)),
                          area=np.array([0.006, 0.0, -0.008]))
    np.testing.assert_array_equal(face, [0, 1])
    np.testing.assert_allclose(area, 0.008)


@pytest.mark.parametrize("x, options", [
    ([0.0, 0.0, 0.11], {}),                                  # above the reach
    ([0.0, 0.0, -0.06], {}),                                 # deeper than the domain
    ([0.0, 0.07, -0.01], {}),                                # beside the soil
    ([0.0, 0.0, -0.01], {"area": 0.01 * UP}),                # of the upper side of the body
    ([0.0, 0.0, -0.01], {"area": np.array([0.01, 0.0, 0.0])}),    # of a wall
])
def test_a_sample_without_a_face_has_no_area(x, options):
    assert assigned(x, squares((0, 0, 0)), **options)[1] == 0.0


def test_a_sample_in_contact_keeps_its_face_however_deep():
    assert assigned([0.0, 0.0, -0.06], squares((0, 0, 0)), touching=True)[1] > 0.0


@pytest.mark.parametrize("z", [0.01, -0.01])
def test_a_sample_in_the_wedge_between_tilted_faces_is_assigned(z):
    """Between faces that fall or rise from their common edge a wedge above or below it belongs to neither."""
    both = squares((0, 0, 0), (0.1, 0, 0), tilt=np.copysign(0.2, z))
    x = [0.05 + 0.1 * abs(z), 0.0, z]
    assert assigned(x, both)[1] > 0.0
    assert assigned(x, both[:1])[1] == 0.0      # past the rim of the soil


def test_crossing_of_a_falling_turning_body():
    """A sample on an arm along x falls 20 mm onto a face that rises 10 mm, from 10 mm above: a third of the way."""
    body = body_at((0.0, 0.0, 0.01))
    pose = np.array([0.03, 0.0, -0.01]), np.eye(3)
    start, end = squares((0, 0, 0)), squares((0, 0, 0.01))
    at, origin = crossing(np.array([[0.01, 0.0, 0.0]]), body, pose, start, end)
    np.testing.assert_allclose(origin, [[0.2, 0.0]], atol=1e-12)
    np.testing.assert_allclose(at, [[(0.01 + 0.03 / 3) / 0.05, 0.0]], atol=2e-4)
    inside = crossing(np.array([[0.01, 0.0, -0.02]]), body, pose, start, end)
    np.testing.assert_allclose(inside[0], inside[1], atol=1e-12)
    outside = crossing(np.array([[0.01, 0.0, 0.05]]), body, pose, start, end)[0]
    np.testing.assert_allclose(outside, [[0.8, 0.0]], atol=1e-12)
    half_turn = body.position, exp_so3(np.array([0.0, 0.0, np.pi / 2]))
    turned = crossing(np.array([[0.03, 0.0, 0.05]]), body, half_turn, start, start)[0]
    np.testing.assert_allclose(turned, [[0.0, 0.6]], atol=1e-12)
