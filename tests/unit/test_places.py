"""Places of contact on domains: areas of faces, which of them look at a body, and their offsets."""

from itertools import product

import numpy as np
import pytest

from hybrid.contact import places

HALF = np.array([0.1, 0.2, 0.05])


def every(found, count=1):
    """Numbers of all places of `count` domains."""
    return np.tile(np.arange(len(found)), count)


def areas(found, half=HALF):
    number = every(found)
    return found.area(number, np.tile(half, (len(number), 1)), np.full(len(number), 8 * half.prod()))


@pytest.mark.parametrize("k", [1, 2, 4, 8, 12])
def test_areas_of_all_places_are_the_surface_of_the_domain(k):
    x, y, z = 2 * HALF
    assert areas(places.faces(k)).sum() == pytest.approx(2 * (x * y + y * z + z * x), rel=1e-14)


@pytest.mark.parametrize("axis", range(3))
def test_a_collapsed_axis_has_one_place_along_it_and_no_face(axis):
    """Faces across the slice only, whose areas are those on its whole thickness."""
    found = places.faces(4, np.arange(3) == axis)
    assert len(found) == 4 * 4 and not (found.axis == axis).any() and not found.flat[:, axis].any()
    u, v = 2 * np.delete(HALF, axis)
    assert areas(found).sum() == pytest.approx(2 * (u + v) * 2 * HALF[axis], rel=1e-14)


@pytest.mark.parametrize("axis", range(3))
def test_in_a_column_each_end_has_one_place_with_its_whole_area(axis):
    found = places.faces(4, np.arange(3) != axis)
    assert len(found) == 2 and (found.axis == axis).all() and found.per_edge == 1
    assert areas(found) == pytest.approx(np.full(2, np.delete(2 * HALF, axis).prod()), rel=1e-14)


@pytest.mark.parametrize("k", [1, 3, 4, 8])
def test_places_are_the_midpoints_of_equal_rectangles_of_each_face(k):
    """They integrate linear functions exactly, and lie on their face."""
    found = places.faces(k)
    assert found.offset.shape[1] == min(k, places.BLOCK) ** 2       # places of a block
    for axis, side in product(range(3), (-1.0, 1.0)):
        normal = side * np.eye(3)[axis]
        offset = found.offset[(found.normal == normal).all(axis=1)].reshape(-1, 3)
        assert (offset[:, axis] == side).all() and (found.axis[(found.normal == normal).all(axis=1)] == axis).all()
        across = np.delete(offset, axis, axis=1)
        np.testing.assert_allclose(across.mean(axis=0), 0.0, atol=1e-15)
        assert len(np.unique(across, axis=0)) == k**2 and np.abs(across).max() == pytest.approx(1 - 1 / k)


@pytest.mark.parametrize("slope", [0.0, 0.5, 1.0, 3.0])
def test_a_staircase_has_the_area_of_the_plane_that_it_approximates(slope):
    """Domains in steps under a plane of this slope: top and right faces look at it, the others do not."""
    found, width = places.faces(2), 2 * HALF[0]
    normal = np.array([-slope, 0.0, -1.0]) / np.hypot(slope, 1.0)       # of a body above: it points into the soil
    number, total = every(found), 0.0
    weight = found.projected_share(number, np.tile(normal, (len(number), 1)))
    for face, area in ((np.array([0, 0, 1]), width * 2 * HALF[1]), (np.array([1, 0, 0]), slope * width * 2 * HALF[1])):
        own = (found.normal == face).all(axis=1)[number // 4]
        assert np.ptp(weight[own]) == 0.0
        total += area * weight[own][0]      # of a step: one width of tops, slope times that of risers
    assert total == pytest.approx(width * np.hypot(1.0, slope) * 2 * HALF[1], rel=1e-14)


def test_of_two_faces_that_coincide_one_looks_at_the_body():
    found, rng = places.faces(3), np.random.default_rng(1)
    normal = rng.standard_normal((50, 3))
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    for axis in range(3):
        lower, upper = (np.flatnonzero((found.normal == side * np.eye(3)[axis]).all(axis=1))[0] * 9 for side in (-1, 1))
        pair = [found.projected_share(np.full(50, number), normal) for number in (lower, upper)]
        assert ((pair[0] > 0) != (pair[1] > 0)).all()
        np.testing.assert_allclose(pair[0] + pair[1], np.abs(normal[:, axis]))


def test_blocks_that_cannot_look_at_the_body_are_left_out_and_no_other():
    """The normal of the body may turn by the sine TURN from the middle of a block to its places."""
    found = places.faces(4)
    group = np.arange(6)
    up = np.tile([0.0, 0.0, 1.0], (6, 1))
    assert found.group_may_face(group, up).tolist() == [True, True, True, True, True, False]


def test_corners_carry_a_quarter_of_a_point_wherever_the_body_is():
    found = places.corners()
    assert found.at_corners and len(found) == 8 and not places.faces(4).at_corners
    np.testing.assert_allclose(areas(found), 0.25 * (8 * HALF.prod()) ** (2 / 3))
    assert found.projected_share(every(found), np.tile([0.0, 0.0, 1.0], (8, 1))).tolist() == [1.0] * 8
    assert found.flat[5].tolist() == [1.0, -1.0, 1.0]      # bits 4, 2, 1: upper end along x, y, z
