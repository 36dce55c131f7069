"""Limits of time steps, schemes and loads."""

import numpy as np


def singular(scene, model):
    """Without inertia: cells whose points leave hourglasses free, and soil that nothing holds."""
    soil = model.soil
    if model.scheme.inertia or soil.held:
        return
    per_axis = np.broadcast_to(scene.soil.points_per_axis, 3)
    if np.any((per_axis == 1) & ~soil.grid.collapsed):
        yield (f"soil.points_per_axis = {scene.soil.points_per_axis}: limit 2 along each axis without inertia; a point "
               "in the middle of its cell resists no hourglass, and the stiffness may be singular. Set "
               "soil.points_per_axis = 2, or time.inertia = true")
    held = soil.grid.fixed[_reached(soil)].any(axis=0) | soil.grid.collapsed
    if not (scene.bodies or held.all()):
        loose = ", ".join(axis for axis, ok in zip("xyz", held) if not ok)
        yield (f"time.inertia = false: nothing holds the soil along {loose}: 0 of its nodes are held there, limit 1. "
               "Hold a face of the grid (grid.faces) that it touches, or set time.inertia = true")


def _reached(soil):
    """(N,) bool, nodes that a point of the soil can see at the start."""
    inside = np.ones(soil.grid.shape, bool)
    for axis, nodes in enumerate(soil.grid.axes):
        if len(nodes) > 1:
            x, half = soil.constants.position[:, axis], soil.constants.half[:, axis]
            seen = (nodes >= (x - half).min() - 1e-9) & (nodes <= (x + half).max() + 1e-9)
            inside &= seen.reshape([-1 if a == axis else 1 for a in range(3)])
    return inside.ravel()


LIMITS = (singular,)
