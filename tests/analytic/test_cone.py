"""A cone of 60° pressed into clay with nothing set but the physics: hybrid/study/cone.py.

Smooth, G = 100 s_u, pushed by a tenth of a cell a step; q / s_u where the shoulder is at the surface and farther down, and
jitter (root mean square, peak to peak) over the last third of a push:

    cells in the radius   at 1.73 m   at 3.5 m   jitter                       Newton iterations a step
    2                     6.2         8.8        1.3 %, 5 % (to 4.5 m)        3.3
    3                     5.3         8.2        0.6 %, 3 % (to 4.5 m)        3.2

In a grid that does not go along with the cone the force follows the place of the shoulder in its cell: 2.9 and 2.6 %. At
4.5 m q is 9.6 on two cells, against 9.7 deep down, and still rises.
"""

import functools

import numpy as np
import pytest
from options import options_set

from hybrid.study import cone


@functools.cache
def push(across, depth):
    return cone.push(across, depth)


def test_nothing_is_set_but_the_physics():
    assert options_set(cone.scene(2, 1.0)) == [] == options_set(cone.scene(3, 4.0, cone.SAND, friction=0.3))


def test_the_tip_carries_load_at_once():
    """Nothing is halved. The force grows as the square of the depth, as there is no length but the depth; the tip alone is
    smaller than a cell, so the mean pressure is not yet that of a cone in a half-space, 5.5."""
    depth, found = push(2, 1.0)
    assert found.halvings == 0 and (found.factor[1:] > 0).all()
    area = (depth * np.tan(np.radians(cone.ANGLE / 2))) ** 2    # over the cross-section of the shaft
    assert found.factor[-5:] / area[-5:] == pytest.approx(np.full(5, 7.5), rel=0.06)


@pytest.mark.slow
def test_the_force_is_smooth_and_near_the_deep_one():
    """With the ghost penalty of soil at rest, 0.3, two cells carry 11.4 at 3.5 m, and the force jumps by 8 %; in a grid that
    stays where it is the jitter is 2.6 %."""
    depth, found = push(3, 3.6)
    last = depth > 2.4
    rms, peaks = cone.jitter(depth[last], found.factor[last])
    assert rms < 0.015 and peaks < 0.05 and found.halvings == 0
    assert 8.0 < found.factor[-5:].mean() < 9.7
