"""Ground that is not level: points cut to it, bodies that lie on it.

A column of points ends at the mean height of the ground over its cross-section, so the volume of soil is that under the
ground; the domain that the ground cuts becomes a lower one with the soil that is left. Under a slope stress at rest is
the weight of the column above, and K0 times that; `hybrid.setup.settle` then finds the equilibrium.
"""

from dataclasses import replace

import numpy as np

from hybrid.contact.search import distances
from hybrid.scene.ground import heights, heights_at, mean_heights
from hybrid.scene.soil import ends

PLACES = 81         # of the ground under a body along each axis
RAISES = 60         # of a body, by its depth in the ground


def mean_levels(given, place, half):
    """Mean height (n,) [m] of the ground over the cross-sections of columns of points at `place` (n, 2) [m] with half-widths
    `half` (n, 2) [m]; given: soil.ground."""
    return mean_heights(heights(given), place - half, place + half)


def shares_below(level, z, half):
    """Share (n,) [-] of domains at heights `z` with half-widths `half` [m] that is below the ground at `level` (n,) [m]."""
    share = np.clip((level - z + half) / (2 * half), 0.0, 1.0)
    share[share > 1.0 - 1e-9] = 1.0
    return share


def cut_to_ground(constants, level):
    """PointConstants of what the ground leaves of points that are partly below it at least; level: (n,) [m] of the ground at
    each."""
    position, half = constants.position.copy(), constants.half_width.copy()
    share = shares_below(level, position[:, 2], half[:, 2])
    position[:, 2] -= (1.0 - share) * half[:, 2]
    half[:, 2] *= share
    return replace(constants, position=position, half_width=half, volume=constants.volume * share,
                   mass=constants.mass * share)


def lower_to_ground(scene, placed):
    """(Scene, [(RigidBody, BodyState)]) with a height for every body with rest_on = "ground": as low as the ground lets
    it."""
    described, moved = list(scene.bodies), list(placed)
    for b, (body, motion) in enumerate(placed):
        if described[b].rest_on == "ground":
            position = _lowest(scene, body, motion)
            moved[b] = body, replace(motion, position=position)
            described[b] = replace(described[b], rest_on=float(position[2] - body.surface.extent(-motion.rotation[2])))
    return replace(scene, bodies=tuple(described)), moved


def depth_in_ground(surface, top, body, motion, collapsed):
    """Depth [m] of a body's lowest vertex below the ground over it, or of the ground in the body, the larger one; negative
    above the ground. surface, top: as of `hybrid.soil.given_ground`; collapsed: (3,) bool."""
    vertices = body.surface.vertices @ motion.rotation.T + motion.position
    below = np.minimum(heights_at(surface, vertices[:, :2]), top) - vertices[:, 2]
    ground = _under(surface, motion.position, vertices, collapsed)
    ground[:, 2] = np.minimum(ground[:, 2], top)
    inside = -distances((ground - motion.position) @ motion.rotation, body.surface)[0]
    return max(below.max(), inside.max())


def _lowest(scene, body, motion):
    """Position (3,) [m] of the centre of a body that lies on the ground."""
    axes = scene.grid.axes
    if scene.soil.ground is not None:
        surface = heights(scene.soil.ground)
    else:
        _, top = ends(scene.soil, scene.grid)
        surface = np.array([axes[0].start, axes[0].end]), None, np.array([top, top])
    vertices = body.surface.vertices @ motion.rotation.T        # from the centre
    ground = _under(surface, motion.position, motion.position + vertices, [axis.collapsed for axis in axes])
    position = motion.position.copy()
    position[2] = np.max(heights_at(surface, motion.position[:2] + vertices[:, :2]) - vertices[:, 2])
    for _ in range(RAISES):
        depth = -distances((ground - position) @ motion.rotation, body.surface)[0].min()
        if depth <= 1e-6 * body.radius:
            break
        position[2] += depth
    return position


def _under(surface, centre, vertices, collapsed):
    """Places (n, 3) [m] of the ground below or above a body with a `centre` (3,) and `vertices` (m, 3) [m]: PLACES along
    each axis that is not collapsed, and where its slope changes."""
    low, high = vertices[:, :2].min(axis=0), vertices[:, :2].max(axis=0)
    x, y = (centre[i:i + 1] if collapsed[i] else np.linspace(low[i], high[i], PLACES) for i in (0, 1))
    nodes = surface[0][(surface[0] > low[0]) & (surface[0] < high[0])]
    place = np.stack([a.ravel() for a in np.meshgrid(np.append(x, nodes), y, indexing="ij")], axis=1)
    return np.column_stack([place, heights_at(surface, place)])
