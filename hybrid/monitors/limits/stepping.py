"""Limits of time steps, schemes and loads."""

import numpy as np

from hybrid.body.attitude import rotation_from_axis_angle
from hybrid.contact.search import distances
from hybrid.monitors.limits.stages import displacement_per_step
from hybrid.monitors.limits.start import initial_pose
from hybrid.soil.points import extent

# [rad] a step: from here on the attitude of a free body is wrong by 0.05 rad after a rotation of 10 rad (failure study)
ROTATION = {"schemes of first order": 0.03, "energy-momentum": 0.2, "generalised alpha that damps": 0.2,
            "schemes of second order": 0.4}
ABOUT_AXIS = 0.4    # [rad] a step about one axis, by which contact and friction see the surface of a body move at once
DEGREES = 2.0       # [rad] a step: beyond it steps are halved, and the number is usually one of degrees
ROUND = 0.03        # of the radius of a body, by which facets of a round one differ from what they are after a turn
TUMBLING = 0.02     # sine between spin and angular momentum: below it a body rotates about one axis, without error


def large_rotation_step(scene, model):
    """Bodies that tumble: steps of large rotations lose the attitude."""
    if scene.time.accuracy or not model.scheme.inertia:
        return
    for number, (described, body) in enumerate(zip(scene.bodies, model.bodies)):
        spin = np.array(described.spin)
        if not (tumbles(spin, body) or _precesses(spin, scene, model, number)):
            continue
        rotations = [(np.linalg.norm(spin) * scene.step_of(stage),
                      *rotation_limit(model.scheme.with_pair(stage.beta, stage.gamma))) for stage in scene.stages]
        angle, limit, kind = max(rotations, key=lambda rotation: rotation[0] / rotation[1])
        if angle > limit:
            yield (f"{body.name} rotates by {angle:.3g} rad a step by its spin, limit {limit:g} rad for {kind}: its "
                   "attitude is wrong by 0.05 rad or more after 10 rad. Use a smaller time.step, or set "
                   "time.accuracy = 1e-3")


def tumbles(spin, body):
    """Whether a free body with this spin (3,) [rad/s] does not turn about one axis."""
    momentum = body.mass.inertia @ spin
    aligned = np.linalg.norm(spin) * np.linalg.norm(momentum)
    return np.linalg.norm(np.cross(spin, momentum)) > TUMBLING * max(aligned, 1e-300) and body.free[3:].all()


def _precesses(spin, scene, model, number):
    """Whether the weight of a body on a ball joint turns the axis about which it spins, as that of a top."""
    body, turn = model.bodies[number], initial_pose(scene.bodies[number], model.bodies[number])[1] @ spin
    for joint in model.joints:
        if joint.at_point and not joint.pairs and number in joint.bodies and body.free[3:].all():
            arm = -initial_pose(scene.bodies[number], body)[1] @ joint.points[joint.bodies.index(number)]
            moment = np.cross(arm, scene.gravity)
            if np.linalg.norm(moment) <= TUMBLING * np.linalg.norm(arm) * np.linalg.norm(scene.gravity):
                return False
            return np.linalg.norm(np.cross(turn, moment)) > TUMBLING * np.linalg.norm(turn) * np.linalg.norm(moment)
    return False


def large_turn_about_an_axis(scene, model):
    """Bodies whose spin, or what drives them, turns them about one axis by so much in a step that contact follows their
    surface no more."""
    if scene.time.accuracy:
        return
    for described, body in zip(scene.bodies, model.bodies):
        spin = np.array(described.spin) * model.scheme.inertia
        found = [] if tumbles(spin, body) else [(np.linalg.norm(spin), scene.stages[0], "body.spin")]
        for stage in scene.stages:
            names = [f"r{axis}" for axis in "xyz"]
            found += [(displacement_per_step(scene, stage, described, name) / scene.step_of(stage), stage,
                       f"what drives {name}") for name in names]
        rate, stage, cause = max(found, key=lambda each: each[0] * scene.step_of(each[1]),
                                 default=(0.0, None, ""))
        length = scene.step_of(stage) if stage else 0.0
        axis = spin
        if cause and cause != "body.spin":      # about an axis of space
            axis = initial_pose(described, body)[1].T @ np.eye(3)["xyz".index(cause[-1])]
        if rate * length > ABOUT_AXIS * (1 + 1e-9) and (rate * length > DEGREES or not _round(body, axis)):
            unit = "; is it a number of degrees? rad/s expected" if rate * length > DEGREES else ""
            yield (f"{body.name} turns by {rate * length:.3g} rad a step by {cause}, limit {ABOUT_AXIS:g} rad{unit}: "
                   "contact sees its surface at the ends of increments alone. Use steps of at most "
                   f"{ABOUT_AXIS / rate:.2g} s{', or set time.accuracy = 1e-3' if model.scheme.inertia else ''}")


def _round(body, axis):
    """Whether a body looks the same after a turn about an axis (3,) in its frame, such as a ball: contact sees no
    difference then."""
    turned = body.outline.vertices @ rotation_from_axis_angle(axis, ABOUT_AXIS).T
    return np.abs(distances(turned, body.outline)[0]).max() < ROUND * body.radius


def rotation_limit(scheme):
    """(limit [rad], which of ROTATION) of a Scheme, for bodies in flight."""
    scheme = scheme.in_flight or scheme
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
        low, high = extent(soil.constants, axis)
        within = (nodes >= low - 1e-9) & (nodes <= high + 1e-9)
        yield within if len(nodes) > 1 else np.ones(1, bool)


LIMITS = (large_rotation_step, large_turn_about_an_axis, singular_stiffness)
