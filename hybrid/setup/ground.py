"""Ground that is not level: points cut to it, bodies that lie on it.

A column of points ends at the mean height of the ground over its cross-section, so the volume of soil is that under the
ground; the domain that the ground cuts becomes a lower one with the soil that is left. Under a slope stress at rest is the weight of the
column above, and K0 times that; `hybrid.setup.settle` then finds the equilibrium.
"""

from dataclasses import replace

import numpy as np

from hybrid.contact.search import distances
from hybrid.runtime.errors import SceneError
from hybrid.scene.ground import heights, heights_at, mean_heights

SLIVER = 0.05       # of a domain: less soil than that makes no point
PLACES = 81         # of the ground under a body along each axis
RAISES = 60         # of a body, by its depth in the ground


def cut_to_ground(constants, given):
    """(PointConstants of the points below the ground, height (n,) [m] of the ground above or below each); given:
    soil.ground. Raises SceneError where no soil is left."""
    position, half = constants.position, constants.half_width
    level = mean_heights(heights(given), (position - half)[:, :2], (position + half)[:, :2])
    share = np.clip((level - position[:, 2] + half[:, 2]) / (2 * half[:, 2]), 0.0, 1.0)
    share[share > 1.0 - 1e-9] = 1.0
    kept = share >= SLIVER
    if not kept.any():
        raise SceneError("soil.ground: no soil lies below it; raise it, or lower grid.z.start")
    share, position, half = share[kept], position[kept].copy(), half[kept].copy()
    position[:, 2] -= (1.0 - share) * half[:, 2]
    half[:, 2] *= share
    return replace(constants, position=position, half_width=half, volume=constants.volume[kept] * share,
                   mass=constants.mass[kept] * share), level[kept]


def lower_to_ground(scene, placed):
    """(Scene, [(RigidBody, BodyState)]) with a height for every body with rest_on = "ground": as low as the ground lets it."""
    described, moved = list(scene.bodies), list(placed)
    for b, (body, motion) in enumerate(placed):
        if described[b].rest_on == "ground":
            position = _lowest(scene, body, motion)
            moved[b] = body, replace(motion, position=position)
            described[b] = replace(described[b], rest_on=float(position[2] - body.surface.extent(-motion.rotation[2])))
    return replace(scene, bodies=tuple(described)), moved


def _lowest(scene, body, motion):
    """Position (3,) [m] of the centre of a body that lies on the ground."""
    axes = scene.grid.x, scene.grid.y, scene.grid.z
    if scene.soil.ground is not None:
        surface = heights(scene.soil.ground)
    else:
        top = scene.grid.z.end if scene.soil.top is None else scene.soil.top
        surface = np.array([axes[0].start, axes[0].end]), None, np.array([top, top])
    vertices = body.surface.vertices @ motion.rotation.T        # from the centre
    low, high = motion.position[:2] + vertices[:, :2].min(axis=0), motion.position[:2] + vertices[:, :2].max(axis=0)
    sides = [np.linspace(a, b, PLACES) for a, b in zip(low, high)]
    for i in (0, 1):
        if axes[i].collapsed:
            sides[i] = motion.position[i:i + 1]
    nodes = surface[0][(surface[0] > low[0]) & (surface[0] < high[0])]
    place = np.stack([a.ravel() for a in np.meshgrid(np.append(sides[0], nodes), sides[1], indexing="ij")], axis=1)
    ground = np.column_stack([place, heights_at(surface, place)])
    below = motion.position[:2] + vertices[:, :2]
    position = motion.position.copy()
    position[2] = np.max(heights_at(surface, below) - vertices[:, 2])
    for _ in range(RAISES):
        depth = -distances((ground - position) @ motion.rotation, body.surface)[0].min()
        if depth <= 1e-6 * body.radius:
            break
        position[2] += depth
    return position
