"""Domains of soil cut by a body: what is left of each are boxes along the axes.

The share of soil in a domain that a body cuts is summed over samples, by its gap d to the body,

    f = ½ + d / Σ |N_i| w_i,  0 <= f <= 1          w (3,) widths of a sample; exact for a plane across it

What is left are one or two boxes along the axis i with the largest |N_i| l_i: one at each end, as long as the volume of the
soil on that side of the body. So boxes meet the body like the columns of a histogram, plates thinner than a domain have
soil on both sides, and volume and mass are those that are left. Less than SLIVER of a domain is removed too.

Equations: FORMULATION (54).
"""

from dataclasses import dataclass

import numpy as np

from hybrid.soil.given_ground import SLIVER
from hybrid.contact.search import distances, gaps_and_normals

SAMPLES = {True: 16, False: 6}      # along each axis of a domain, in a slice and in space
UNCUT = 1e-3        # of a domain: less than that is not cut out
ONE_SIDE = 0.15     # of the soil on one side of a body: less on the other side belongs to a slope or a corner
TINY = 1e-300       # in place of zero in a denominator
CHUNK = 1 << 16     # samples or contact points at a time


@dataclass(frozen=True)
class Boxes:
    """Domains along the axes: parent (n,) numbers of the points that they come from, increasing; position, half (n, 3)
    [m]."""

    parent: np.ndarray
    position: np.ndarray
    half: np.ndarray

    @property
    def volume(self):
        """(n,) [m³]."""
        return np.prod(2 * self.half, axis=1)

    def radii(self, collapsed):
        """Half of the diagonal (n,) [m], without what is along collapsed axes, (3,) bool."""
        return np.linalg.norm(np.where(collapsed, 0.0, self.half), axis=1)

    def __getitem__(self, ids):
        return Boxes(self.parent[ids], self.position[ids], self.half[ids])


def cut_out(boxes, surface, motion, collapsed):
    """(Boxes left of `boxes` once the body is there, volume [m³] of the body in them, number of points cut).

    surface: ContactSurface of the body, in plane strain without its ends; motion: BodyState; collapsed: (3,) bool.
    """
    near = near_boxes(boxes, surface, motion, collapsed)
    share, axes, ends = soil_shares(boxes[near], surface, motion, collapsed)
    away = np.ones(len(boxes.parent), bool)
    changed = share < 1.0 - UNCUT
    away[near[changed]] = False
    cut, axes, ends = boxes[near[changed]], axes[changed], ends[changed]
    pieces, rest = [boxes[away]], np.arange(len(cut.parent))
    for turn in range(axes.shape[1]):       # the next axis where a box would have its centre in the body
        parts = [_ends(cut[rest], axes[rest, turn], ends[rest, turn], side) for side in (0, 1)]
        wrong = [_inside(part, surface, motion, collapsed) for part, _ in parts]
        again = np.unique(np.concatenate([ids[inside] for (_, ids), inside in zip(parts, wrong)]))
        last = turn == axes.shape[1] - 1
        pieces += [part[~inside if last else ~np.isin(ids, again)] for (part, ids), inside in zip(parts, wrong)]
        rest = rest[again]
    left = Boxes(*(np.concatenate([getattr(piece, name) for piece in pieces]) for name in ("parent", "position", "half")))
    left = left[np.argsort(left.parent, kind="stable")]
    return left, float(boxes[near].volume @ (1.0 - share)), len(np.intersect1d(cut.parent, left.parent))


def _ends(boxes, axis, ends, side):
    """(Boxes at the lower (side 0) or upper ends of `boxes` along `axis` (n,), of the shares `ends` (n, 2); their ids)."""
    merged = ends.min(axis=1) < ONE_SIDE * ends.max(axis=1)
    one = np.where(np.argmax(ends, axis=1) == side, ends.sum(axis=1), 0.0)
    part = np.where(merged, one, ends[:, side])
    ids = np.flatnonzero(part >= SLIVER)
    position, half, rows, i = boxes.position[ids].copy(), boxes.half[ids].copy(), np.arange(len(ids)), axis[ids]
    position[rows, i] += (2 * side - 1) * half[rows, i] * (1.0 - part[ids])
    half[rows, i] *= part[ids]
    return Boxes(boxes.parent[ids], position, half), ids


def _inside(boxes, surface, motion, collapsed):
    """(n,) bool, whether the centres of boxes are in the body."""
    return distances(in_frame(boxes.position, motion, collapsed), surface)[0] < 0.0


def in_frame(position, motion, collapsed):
    """Positions (n, 3) [m] in the frame of a body, along collapsed axes at its centre."""
    return (np.where(collapsed, motion.position, position) - motion.position) @ motion.rotation


def near_boxes(boxes, surface, motion, collapsed):
    """Numbers of the boxes that the body may cut or contain."""
    size = boxes.radii(collapsed)
    ids, distance = near_surface(boxes, size, surface, motion, collapsed)
    return ids[distance < size[ids]]


def near_surface(boxes, size, surface, motion, collapsed):
    """Numbers (k,) of the boxes with their centres within `size` (n,) [m] of the bounds of a surface, and their signed
    distances (k,) [m] from it."""
    y = in_frame(boxes.position, motion, collapsed)
    ids = np.flatnonzero(((y > surface.lower - size[:, None]) & (y < surface.upper + size[:, None])).all(axis=1))
    return ids, distances(y[ids], surface)[0]


def soil_shares(boxes, surface, motion, collapsed):
    """Of each box: share (n,) of soil, axes (n, k) that are not collapsed, the one most normal to the body first, and
    shares (n, k, 2) of soil below and above the body along each of them."""
    deep, normal = distances(in_frame(boxes.position, motion, collapsed), surface)
    across = np.where(collapsed, 0.0, boxes.half)
    facing = np.abs(normal @ motion.rotation.T) * across / np.maximum(across.max(axis=1, keepdims=True), TINY)
    # at a corner of a box two axes face the body alike: the first one is taken, not that of round-off
    axes = np.argsort(-np.round(facing, 9) - (across > 0) * 1e-300, axis=1, kind="stable")
    axes = axes[:, :3 - np.count_nonzero(collapsed)]
    inside = deep < -np.linalg.norm(across, axis=1)
    share, ends = np.where(inside, 0.0, 1.0), np.zeros((*axes.shape, 2))
    count = SAMPLES[bool(np.any(collapsed))]
    t = (2 * np.arange(count) + 1) / count - 1
    offset = np.stack([a.ravel() for a in np.meshgrid(*([0.0] if c else t for c in collapsed), indexing="ij")], axis=1)
    for ids in chunks(np.flatnonzero(~inside), len(offset)):
        place = boxes.position[ids, None] + offset * boxes.half[ids, None]
        # near a tip bounds of it are far smaller
        d, normal = gaps_and_normals(in_frame(place.reshape(-1, 3), motion, collapsed), surface)
        width = np.repeat(2 * across[ids] / count, len(offset), axis=0)
        width = np.einsum("si,si->s", np.abs(normal @ motion.rotation.T), width)
        soil = np.clip(0.5 + d / np.maximum(width, TINY), 0.0, 1.0).reshape(len(ids), len(offset))
        share[ids] = soil.mean(axis=1)
        for turn, axis in enumerate(axes[ids].T):
            height = offset.T[axis]                         # (k, s) of each sample along the axis of its box
            middle = ((1.0 - soil) * height).sum(axis=1) / np.maximum((1.0 - soil).sum(axis=1), TINY)
            below = 0.5 * (1.0 + np.sign(np.round(middle[:, None] - height, 9)))
            ends[ids, turn] = np.stack([(soil * below).mean(axis=1), (soil * (1.0 - below)).mean(axis=1)], axis=1)
    return share, axes, ends


def chunks(ids, each):
    """Parts of `ids` with about CHUNK items in all, `each` of them for an id."""
    return np.array_split(ids, max(1, -(-len(ids) * each // CHUNK)))
