"""Slabs of points that two threads may add to nodes at once."""

import numpy as np
import pytest

from hybrid.grid.colouring import make_slabs


@pytest.mark.parametrize("shape", [(9, 4, 5), (3, 4, 12), (1, 8, 3)])
def test_slabs_of_one_parity_share_no_node(shape):
    """Every point is in one slab, and reaches at most two nodes ahead of its first one along the longest axis."""
    rng = np.random.default_rng(4)
    first = rng.integers(0, np.maximum(np.array(shape) - 2, 1), (200, 3))
    slabs, axis = make_slabs(first, shape), int(np.argmax(shape))
    assert np.array_equal(np.sort(slabs.order), np.arange(200)) and slabs.start[-1] == 200
    for parity in (0, 1):
        ends = []
        for slab in range(parity, len(slabs.start) - 1, 2):
            own = first[slabs.order[slabs.start[slab]:slabs.start[slab + 1]], axis]
            if len(own):
                ends.append((own.min(), own.max() + 2))
        assert all(before[1] < after[0] for before, after in zip(ends, ends[1:]))
    assert len(slabs.start) - 1 >= 2


def test_points_of_one_cell_follow_each_other():
    first = np.array([[0, 0, 0], [2, 1, 1], [0, 0, 0], [2, 1, 1], [1, 0, 0]])
    assert make_slabs(first, (6, 3, 3)).order.tolist() == [0, 2, 4, 1, 3]
