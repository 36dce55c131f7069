"""Sizes of the blocks of a block of soil on rollers, and of what their processes exchange, without making the plans.

Blocks are cut by `hybrid.grid.blocks`; copies and overlaps are differences of boxes of nodes, with the nodes above the
soil left out of the unknowns. Contact points in other blocks, which need more layers of copies, are not considered.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from hybrid.grid.blocks import cut_into_blocks


@dataclass(frozen=True)
class Sizes:
    """Of the block of each process, (N,): unknowns that it owns, copies from others, has copied, and has in the overlap
    of its factor; nodes that it owns, copies and has copied; neighbours; points as a share of all."""

    own: np.ndarray
    copies: np.ndarray
    given: np.ndarray
    overlap: np.ndarray
    nodes: np.ndarray
    copied_nodes: np.ndarray
    given_nodes: np.ndarray
    neighbours: np.ndarray
    share: np.ndarray


@cache
def sizes(cells, ranks, empty=2):
    """Sizes of blocks of (a, b, c) `cells` of soil on rollers at base and sides, below `empty` layers, on so many
    `ranks`."""
    points = np.zeros((cells[0], cells[1], cells[2] + empty), np.int64)
    points[:, :, :cells[2]] = 8
    boxes = cut_into_blocks(points, ranks)
    most = np.array(points.shape)
    own = np.stack([boxes[:, 0], boxes[:, 1] + (boxes[:, 1] == most)], axis=1)
    local = np.stack([np.maximum(boxes[:, 0] - 1, 0), np.minimum(boxes[:, 1] + 1, most) + 1], axis=1)
    wide = np.stack([np.maximum(own[:, 0] - 1, 0), np.minimum(own[:, 1] + 1, most + 1)], axis=1)
    top = most + 1 - (0, 0, empty)

    def unknowns(low, high):
        high = np.minimum(high, top)
        free = np.maximum(high - low, 0)
        held = ((low == 0) & (free > 0)).astype(int)
        held[..., :2] += ((high == top) & (free > 0))[..., :2]
        return sum(np.prod(free - held * (np.arange(3) == axis), axis=-1) for axis in range(3))

    def shared(boxes, others, size):
        """Size of what each of `boxes` has in common with all of the `others` but its own, and with how many."""
        found, met = np.zeros(ranks, int), np.zeros(ranks, int)
        for r, (low, high) in enumerate(boxes):
            low, high = np.maximum(low, others[:, 0]), np.minimum(high, others[:, 1])
            common = np.where((high > low).all(axis=1), size(low, np.maximum(low, high)), 0)
            common[r] = 0
            found[r], met[r] = common.sum(), np.count_nonzero((high > low).all(axis=1)) - 1
        return found, met

    def nodes(low, high):
        return np.prod(high - low, axis=-1)

    filled = np.array([points[tuple(slice(a, b) for a, b in zip(*box))].sum() for box in boxes])
    mine = unknowns(own[:, 0], own[:, 1])
    copied, met = shared(local, own, nodes)
    return Sizes(mine, shared(local, own, unknowns)[0], shared(own, local, unknowns)[0],
                 unknowns(wide[:, 0], wide[:, 1]) - mine,
                 nodes(own[:, 0], own[:, 1]), copied, shared(own, local, nodes)[0], met, filled / points.sum())
