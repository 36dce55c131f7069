"""Ground with given heights: contact points start on its surface as it is given, not on the flat tops of columns.

A column of domains ends at the mean height of the ground over it, so the ground would be a staircase to a body: a ball in
a valley of held soil lost 39 % of its energy from step to step, and a block put on a slope stood in the steps instead of
sliding. Where the ground is no steeper than STEEPEST within a column, the places on its upper face are therefore moved
vertically, from where they were at the start of the run, to

    z = h(x, y)

and represent the area of the ground there, a (∂h/∂x, ∂h/∂y, -1)·N projected along the normal N of a body. Places on other
faces that were above the ground are sides of steps, and left out. Steeper ground, as a wall, keeps its columns. Domains
that have moved keep the way by which their places were moved, and the slopes.

Equations: FORMULATION (54a).
"""

from dataclasses import dataclass

import numpy as np

from hybrid.runtime.comm import minimum
from hybrid.scene.ground import heights_at, mean_heights

STEEPEST = 1.5      # slope [-] up to which places of a column follow the ground
SAMPLES = 9         # of the ground over a column along each axis
APART = 0.05        # of the width of a domain: distance over which the slope at a place is taken
SLIVER = 0.05       # of a domain: less soil than that, cut off by the ground or a body, makes no point


@dataclass(frozen=True)
class GivenGround:
    """Ground under domains.

    surface: (x, y or None, z) of `hybrid.scene.ground.heights`; top: [m] of the soil, where the ground is higher
    position, half: (n, 3) [m] of the domains at the start of the run
    follows: (n,) bool, domains that reach above the lowest ground over them, where it is gentle; highest: (n,) bool, of
        them the uppermost ones, whose upper faces are on the ground
    shift: (n,) [m] largest distance by which a place of a point is moved; apart: [m] over which slopes are taken
    """

    surface: tuple
    top: float
    position: np.ndarray
    half: np.ndarray
    follows: np.ndarray
    highest: np.ndarray
    shift: np.ndarray
    apart: float

    @classmethod
    def of(cls, surface, top, position, half):
        """GivenGround under points at `position` with half-widths `half` (n, 3) [m], cut to it."""
        lower, upper, end = (position - half)[:, :2], (position + half)[:, :2], (position + half)[:, 2]
        level = np.minimum(mean_heights(surface, lower, upper), top)
        lowest = level - 0.5 * STEEPEST * (upper - lower).sum(axis=1)
        near = np.flatnonzero(end > np.minimum(lowest, level - 2 * SLIVER * half[:, 2]))
        z, slope = _sampled(surface, lower[near], upper[near])
        z, gentle = np.minimum(z, top), slope <= STEEPEST
        ends = gentle & (end[near] > (level - 2 * SLIVER * half[:, 2])[near])
        shift, follows, highest = np.zeros(len(position)), np.zeros(len(position), bool), np.zeros(len(position), bool)
        follows[near] = gentle & (end[near] > z.min(axis=1, initial=np.inf)) | ends
        highest[near] = ends
        shift[near[ends]] = np.abs(z[ends] - end[near[ends], None]).max(axis=1)
        return cls(surface, top, position, half, follows, highest, shift, APART * minimum(upper - lower, np.inf))

    def heights(self, place):
        """Height (m,) [m] of the ground at places (m, 2) or (m, 3) [m]."""
        return np.minimum(heights_at(self.surface, place[:, :2]), self.top)

    def lowered(self, point, position):
        """Positions (m, c, 3) [m] of corners of domains at the start, of `point` (m,), where none of those that follow is
        above the ground."""
        z = self.heights(position.reshape(-1, 3)).reshape(position.shape[:2])
        lowered = position.copy()
        lowered[..., 2] = np.where(self.follows[point, None], np.minimum(position[..., 2], z), position[..., 2])
        return lowered

    def moved(self, point, up, offset):
        """(Ways (m,) [m] by which places at an `offset` (m, 3) on domains, in half-widths, are moved upwards, (m,) bool,
        those that are kept); up: (m,) bool, on upper faces."""
        start = self.position[point] + offset * self.half[point]
        on, above = up & self.highest[point], start[:, 2] - self.heights(start)
        return np.where(on, -above, 0.0), on | ~self.follows[point] | (above <= 0.0)

    def projected_share(self, point, up, offset, normal, usual):
        """Area of the ground projected along normals N (m, 3) of a body over that of the upper face that its places are on,
        >= 0; `usual` (m,) of other places."""
        on = up & self.highest[point]
        place, way = (self.position[point] + offset * self.half[point])[on, :2], self.apart * np.eye(2)
        slopes = [(self.heights(place + d) - self.heights(place - d)) / (2 * self.apart) for d in way]
        found = usual.copy()
        found[on] = np.maximum(0.0, slopes[0] * normal[on, 0] + slopes[1] * normal[on, 1] - normal[on, 2])
        return found


def _sampled(surface, lower, upper):
    """(Heights (n, SAMPLES²) [m], largest slope (n,) [-]) of the ground over rectangles from `lower` to `upper` (n, 2)
    [m]."""
    share = np.linspace(0.0, 1.0, SAMPLES)
    x, y = (lower[:, i, None] + (upper - lower)[:, i, None] * share for i in (0, 1))
    place = np.stack(np.broadcast_arrays(x[:, :, None], y[:, None, :]), axis=-1)
    z = heights_at(surface, place.reshape(-1, 2)).reshape(len(lower), SAMPLES, SAMPLES)
    apart = (upper - lower) / (SAMPLES - 1)
    slopes = [np.abs(np.diff(z, axis=1 + i)).max(axis=(1, 2)) / apart[:, i] for i in (0, 1)]
    return z.reshape(len(lower), -1), np.maximum(*slopes) if len(lower) else np.zeros(0)
