"""Limits of time steps, schemes and loads."""

import numpy as np

from hybrid.runtime.comm import maximum, minimum

# [rad] a step: from here on the attitude of a free body is wrong by 0.05 rad after a rotation of 10 rad (failure study)
ROTATION = {"schemes of first order": 0.03, "energy-momentum": 0.2, "generalised alpha that damps": 0.2,
            "schemes of second order": 0.4}
TUMBLING = 0.02     # sine between spin and angular momentum: below it a body rotates about one axis, without error


def large_rotation_step(scene, model):
    """Bodies that tumble: steps of large rotations lose the attitude."""
    if scene.time.accuracy or not model.scheme.inertia:
        return
    for described, body in zip(scene.bodies, model.bodies):
        spin = np.array(described.spin)
        momentum = body.mass.inertia @ spin
        aligned = np.linalg.norm(spin) * np.linalg.norm(momentum)
        tumbling = np.linalg.norm(np.cross(spin, momentum)) / max(aligned, 1e-300)
        if tumbling < TUMBLING or not body.free[3:].all():
            continue
        rotations = [(np.linalg.norm(spin) * (stage.step or scene.time.step), *_limit(model.scheme, stage))
                 for stage in scene.stages]
        angle, limit, kind = max(rotations, key=lambda rotation: rotation[0] / rotation[1])
        if angle > limit:
            yield (f"{body.name} rotates by {angle:.3g} rad a step by its spin, limit {limit:g} rad for {kind}: its "
                   "attitude is wrong by 0.05 rad or more after 10 rad. Use a smaller time.step, or set "
                   "time.accuracy = 1e-3")


def _limit(scheme, stage):
    """(limit [rad], which of ROTATION) of the scheme that a stage has."""
    scheme = scheme.with_pair(stage.beta, stage.gamma)
    if scheme.rotation == "cayley":
        kind = "energy-momentum"
    elif scheme.damps:
        kind = "schemes of first order" if scheme.first_order else "generalised alpha that damps"
    else:
        kind = "schemes of second order"
    return ROTATION[kind], kind


def singular_stiffness(scene, model):
    """Without inertia: cells whose points resist no hourglass mode, and soil that nothing holds."""
    soil = model.soil
    if model.scheme.inertia or soil.held:
        return
    per_axis = np.broadcast_to(scene.soil.points_per_axis, 3)
    if np.any((per_axis == 1) & ~soil.grid.collapsed):
        yield (f"soil.points_per_axis = {scene.soil.points_per_axis}: limit 2 along each axis without inertia; a point "
               "in the middle of its cell resists no hourglass mode, and the stiffness may be singular. Set "
               "soil.points_per_axis = 2, or time.inertia = true")
    fixed = [plane[near].any(axis=0) for plane, near in zip(soil.grid.planes, _reached(soil))]
    held = np.any(fixed, axis=0) | soil.grid.collapsed
    if not (scene.bodies or held.all()):
        loose = ", ".join(axis for axis, ok in zip("xyz", held) if not ok)
        yield (f"time.inertia = false: nothing holds the soil along {loose}: 0 of its nodes are held, limit 1, so "
               "that the stiffness is singular. Hold a face of the grid (grid.faces) that the soil touches, or set "
               "time.inertia = true")


def _reached(soil):
    """(n,) bool of each axis: planes of nodes of the whole grid in the support of a point of the soil at the start."""
    for axis, nodes in enumerate(soil.grid.lines):
        x, half = soil.constants.position[:, axis], soil.constants.half_width[:, axis]
        within = (nodes >= minimum(x - half) - 1e-9) & (nodes <= maximum(x + half) + 1e-9)
        yield within if len(nodes) > 1 else np.ones(1, bool)


LIMITS = (large_rotation_step, singular_stiffness)
