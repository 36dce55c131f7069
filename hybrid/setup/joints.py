"""Joints of a scene, as the model has them."""

import numpy as np

from hybrid.body.joints import Joint
from hybrid.runtime.errors import SceneError
from hybrid.setup.stages import point_of
from hybrid.step.joint_rates import velocity_against

MOVING = 1e-4   # share of a speed that may be along a joint at the start: a meshed wheel's centre is not quite on its axis


def build_joints(scene, placed, meshes):
    """Tuple of Joint. placed: (RigidBody, initial BodyState) of each body; meshes: their TetMesh. Raises SceneError."""
    return tuple(_joint(i, described, scene, placed, meshes) for i, described in enumerate(scene.joints))


def _joint(i, described, scene, placed, meshes):
    names = [body.name for body in scene.bodies]
    numbers = tuple(names.index(name) for name in described.bodies) + (None,) * (len(described.bodies) == 1)
    first = _local(described.point, f"joint.{i}.point", numbers[0], scene, placed, meshes)
    pose, other = [_pose(number, placed) for number in numbers]
    at = pose[0] + pose[1] @ first
    common = {"name": described.name, "bodies": numbers}
    if described.kind in ("rod", "line"):
        end = (np.array(described.end, float) if numbers[1] is None else
               _local(described.end, f"joint.{i}.end", numbers[1], scene, placed, meshes))
        distance = float(np.linalg.norm(at - other[0] - other[1] @ end))
        length = distance if described.length is None else described.length
        _refuse_length(i, described, distance, length)
        return Joint(**common, points=np.array([first, end]), at_point=False, length=length, slack=described.kind == "line")
    points = np.array([first, other[1].T @ (at - other[0])])
    if described.kind == "ball":
        return Joint(**common, points=points, at_point=True)
    if described.kind == "weld":
        x, y, z = np.eye(3)
        return Joint(**common, points=points, at_point=True, pairs=tuple(
            (pose[1].T @ u, other[1].T @ w) for u, w in ((x, y), (y, z), (z, x))))
    axis = np.array(described.axis, float) / np.linalg.norm(described.axis)
    across = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    across /= np.linalg.norm(across)
    p, q = across, np.cross(axis, across)
    return Joint(**common, points=points, at_point=True,
                 pairs=tuple((pose[1].T @ axis, other[1].T @ w) for w in (p, q)),
                 turning=(pose[1].T @ p, other[1].T @ p, other[1].T @ q), friction=described.friction_moment,
                 limits=described.limits and tuple(np.radians(described.limits)))


def _local(point, key, number, scene, placed, meshes):
    """(3,) [m] from the centre of a body, in its frame."""
    return point_of(point, key, scene.bodies[number], meshes[number]) - placed[number][0].mass.centre


def _pose(number, placed):
    return (np.zeros(3), np.eye(3)) if number is None else (placed[number][1].position, placed[number][1].rotation)


def _refuse_length(i, described, distance, length):
    if distance < 1e-9:
        raise SceneError(f"joint.{i}: the ends of {described.kind} {described.name!r} are at one place, so that it has no "
                         "direction; use kind = 'ball', or move one of them")
    missed = distance - length if described.kind == "line" else abs(distance - length)
    if missed > 1e-6 * distance:
        raise SceneError(f"joint.{i}.length = {length:g} m: the ends of {described.kind} {described.name!r} are "
                         f"{distance:.6g} m apart at the start; leave it out, or move a body")


def refuse_velocities(model, state):
    """SceneError where bodies start with velocities that a joint does not allow, which mean nothing without inertia."""
    if not model.scheme.inertia:
        return
    fastest = max((np.linalg.norm(m.velocity) + body.radius * np.linalg.norm(m.spin)
                   for body, m in zip(model.bodies, state.bodies)), default=0.0)
    for joint, speed in velocity_against(model, state.bodies):
        if speed > MOVING * fastest:
            raise SceneError(f"joint {joint.name!r}: its bodies start with velocities that it does not allow, by "
                             f"{speed:.3g} m/s or rad/s; choose body.velocity and body.spin that go together, or start "
                             "at rest")
