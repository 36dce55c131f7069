"""Where bodies go: those that are driven, and those that joints, lines and other bodies move as they go."""

import numpy as np

from hybrid.body.paths import path_along
from hybrid.monitors.limits.shape import PLANE
from hybrid.monitors.limits.start import FLUSH, initial_pose, initial_vertices

AT_POINT = "hinge", "ball", "weld"


def travels(scene, model, number):
    """[(start, travel)] (3,) [m] of a body that is driven, or moves as one that it is fixed to, or is drawn or pressed by a
    pull line, a rope, a rod, or a body that touches it or comes down on it."""
    body, collapsed = model.bodies[number], model.soil.grid.collapsed
    kinds = AT_POINT if not turns(body) else ("weld",)
    for i in (number, *sorted(bodies_joined_to(scene, number, kinds) - {None})):
        if ways := travels_of(scene, scene.bodies[i], collapsed):
            line = model.bodies[i].line
            return [way for way in ways if _guided(model.bodies[i], way[1])
                    or line and _upright(way[1]) and (not line.tension_only or way[1] @ line.direction > 0.0)]
    others = {i: [way for way in travels_of(scene, described, collapsed) if _guided(model.bodies[i], way[1])]
              for i, described in enumerate(scene.bodies) if i != number}
    drawn = [way for joint in model.joints if joint.length is not None and number in joint.bodies
             for i in {*joint.bodies} - {None, number} for way in _over(scene, model, joint, number, others[i])]
    moved = drawn or [way for i, ways in others.items() for way in _pressing(scene, model, i, number, ways)]
    return [way for way in moved if _can_follow(body, way[1])]


def turns(body):
    """Whether a RigidBody can turn in any stage."""
    return bool(_ever_free(body)[3:].any())


def _ever_free(body):
    """(6,) bool, components that are free in any stage of a RigidBody."""
    stages = [(body.free | stage.released) & ~(stage.held | stage.driven) for stage in body.stages]
    return np.any(stages or [body.free], axis=0)


def _can_follow(body, travel):
    """Whether nothing holds a body along the largest component of a travel."""
    return bool(_ever_free(body)[np.argmax(np.abs(travel))])


def moved_at_points(body):
    """(3,) bool, axes along which a stage drives a point of a RigidBody that it does not let turn: so the whole of it."""
    moved = np.zeros(3, bool)
    for stage in body.stages:
        if not ((body.free | stage.released)[3:] & ~(stage.held | stage.driven)[3:]).any():
            moved[[point.guide.component for point in stage.points]] = True
    return moved


def _guided(body, travel):
    """Whether guides of a body, or of points of one that does not turn, move it along all of a travel."""
    return bool((body.guided[:3] | moved_at_points(body))[travel != 0.0].all())


def _over(scene, model, joint, number, ways):
    """What a rod hands on to the body of this `number` of `ways` of the other one, up, down and along itself; a line only
    what draws, once it is taut."""
    poses = [initial_pose(scene.bodies[i], model.bodies[i]) for i in joint.bodies]
    ends = [centre + rotation @ point for (centre, rotation), point in zip(poses, joint.points)]
    span = ends[1] - ends[0] if joint.bodies[0] == number else ends[0] - ends[1]
    length = np.linalg.norm(span)
    found = []
    for start, travel in ways:
        along = travel @ span / length if length else 0.0
        draws = travel[2] if _upright(travel) else along
        if not _upright(travel) and abs(along) < PLANE * np.linalg.norm(travel):
            continue
        if not joint.slack:
            found.append((start, travel))
        elif draws > joint.length - length:
            found.append((start, travel * (1.0 - (joint.length - length) / draws)))
    return found


def _pressing(scene, model, other, number, ways):
    """What a body hands on of its `ways` to the one of this `number` that it comes down on, from any height, or pushes along
    another axis, where they are less than a cell apart."""
    (start, end), (low, high) = (
        (place.min(axis=0), place.max(axis=0)) for place in (
            initial_vertices(scene.bodies[i], model.bodies[i]) for i in (other, number)))
    found = []
    for begins, travel in ways:
        size, axis = np.linalg.norm(travel), int(np.argmax(np.abs(travel)))
        gap = low[axis] - end[axis] if travel[axis] > 0.0 else start[axis] - high[axis]
        across = np.arange(3) != axis
        meets = (start < high)[across].all() and (end > low)[across].all() and gap > -FLUSH * (end - start)[axis]
        near = _upright(travel) and travel[2] < 0.0 or gap < model.soil.grid.smallest_cell
        if abs(travel[axis]) > PLANE * size and meets and near and max(gap, 0.0) < size:
            found.append((begins, travel * (1.0 - max(gap, 0.0) / size)))
    return found


def _upright(travel):
    return abs(travel[2]) > PLANE * np.linalg.norm(travel)


def travels_of(scene, described, collapsed):
    """[(start, travel)] (3,) [m] of a driven body: in each stage from its place at the start to the farthest one. Stages in
    a row, or later, that go the same way are one, the longest."""
    paths = [path_along(scene, described, name) for name in "xyz"]
    found, start = [], np.zeros(3)
    for stage in zip(*paths):
        farthest = np.array([max(path, key=lambda place, now=now: abs(place - now)) for path, now in zip(stage, start)])
        end = np.array([path[-1] for path in stage])
        travel = np.where(collapsed, 0.0, farthest - start)
        if travel.any():
            found = _with(found, start, travel)
        start = end
    return found


def _with(found, start, travel):
    """`found` with another way: of those in one direction the longest, whole where they follow each other in a line."""
    length = np.linalg.norm(travel)
    for i, (first, other) in enumerate(found):
        if travel @ other > PLANE * length * np.linalg.norm(other):
            whole = start + travel - first
            in_line = whole @ other > PLANE * np.linalg.norm(whole) * np.linalg.norm(other)
            travels = [(first, other), (start, travel), *([(first, whole)] if in_line else [])]
            return [*found[:i], max(travels, key=lambda one: np.linalg.norm(one[1])), *found[i + 1:]]
    return [*found, (start, travel)]


def bodies_joined_to(scene, number, kinds=AT_POINT):
    """Numbers of the bodies that joints of some `kinds`, those at points, connect with a body, over any number of others;
    None of the ground."""
    names, found = [body.name for body in scene.bodies], {number}
    pairs = [{*map(names.index, joint.bodies), *([None] if len(joint.bodies) == 1 else [])}
             for joint in scene.joints if joint.kind in kinds]
    for _ in pairs:
        for pair in pairs:
            found |= pair if (found & pair) - {None} else set()
    return found - {number}
