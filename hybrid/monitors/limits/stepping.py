"""Limits of time steps, schemes and loads."""

import numpy as np

# [rad] a step: from here on a free body's attitude is off by 0.05 rad after a turn of 10 rad (study failure, turns)
TURNS = {"first order": 0.03, "energy-momentum": 0.2, "second order": 0.4}
WOBBLE = 0.02   # sine between spin and angular momentum, below which a body turns about one axis and nothing is missed


def turning(scene, model):
    """Bodies that tumble: steps of large turns lose the attitude."""
    if scene.time.accuracy or not model.scheme.inertia:
        return
    for described, body in zip(scene.bodies, model.bodies):
        spin = np.array(described.spin)
        momentum = body.mass.inertia @ spin
        wobble = np.linalg.norm(np.cross(spin, momentum)) / max(np.linalg.norm(spin) * np.linalg.norm(momentum), 1e-300)
        if wobble < WOBBLE or not body.free[3:].all():
            continue
        turns = [(np.linalg.norm(spin) * (stage.step or scene.time.step), *_limit(model.scheme, stage))
                 for stage in scene.stages]
        turn, limit, of = max(turns, key=lambda found: found[0] / found[1])
        if turn > limit:
            yield (f"{body.name} turns by {turn:.3g} rad a step by its spin, limit {limit:g} rad for a scheme of {of}: "
                   "its attitude is off by 0.05 rad or more after 10 rad. Use a smaller time.step, or set "
                   "time.accuracy = 1e-3")


def _limit(scheme, stage):
    """(limit [rad], which of TURNS) of the scheme that a stage has."""
    scheme = scheme.with_pair(stage.beta, stage.gamma)
    if scheme.rotation == "cayley":
        of = "energy-momentum"
    else:
        of = "first order" if scheme.damps else "second order"
    return TURNS[of], of


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
            x, half = soil.constants.position[:, axis], soil.constants.half_width[:, axis]
            seen = (nodes >= (x - half).min() - 1e-9) & (nodes <= (x + half).max() + 1e-9)
            inside &= seen.reshape([-1 if a == axis else 1 for a in range(3)])
    return inside.ravel()


LIMITS = (turning, singular)
