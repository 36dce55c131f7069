"""Loads and motions that a held component swallows, such as those across a plane of symmetry of half a model."""

import numpy as np

from hybrid.body.paths import path_along
from hybrid.body.rigid import FREEDOMS
from hybrid.body.symmetry import AXES
from hybrid.monitors.limits.start import initial_pose, initial_vertices, top_of
from hybrid.runtime.units import force as force_text
from hybrid.scene.body import out_of_plane
from hybrid.scene.check_stage import moved
from hybrid.scene.ground import heights, heights_at
from hybrid.soil.points import extent

SWALLOWED = 0.01    # of the largest force of a load, along a component that does not feel it
ASIDE = 0.05        # of the size of a body: arms of its loads below it are none
PRESSED = 1e-4      # of the radius of a body: it is driven into the ground
MIDDLE = 0.02       # the same between the middle of a body and the end of the grid, where the body is half a model


def swallowed_loads(scene, model):
    """Forces and moments of stages on components that are held or driven, which change the reaction there and nothing
    else."""
    for s, stage in enumerate(scene.stages):
        staged = model.for_stage(stage.held, number=s)
        for described, body in zip(scene.bodies, staged.bodies):
            own = [i for i, load in enumerate(stage.loads) if load.body in (None, described.name)]
            for i, load in zip(own, body.loads):
                found = {}
                for component, text in _lost(described, body, load):
                    found.setdefault(_why(scene, body, component), []).append((FREEDOMS[component], text))
                for (reason, remedy), parts in found.items():
                    names, texts = (" and ".join(each) for each in zip(*parts))
                    yield (f"stage.{s}.load.{i} on {body.name}: {texts} act{'s' if len(parts) == 1 else ''} on {names}, "
                           f"{reason}: the body does not feel it, it only changes the reaction. {remedy}")


def _lost(described, body, load):
    """(component 0 to 5, text of the force or moment) of what a PointLoad puts on components that are not free."""
    force, moment = ([np.zeros(3)] if table is None else table.values for table in (load.force, load.moment))
    arm, least = _arm(described, body, load.point), ASIDE * np.ptp(body.outline.vertices, axis=0).max()
    largest = max(np.linalg.norm(row) for row in force)
    for axis in np.flatnonzero(~body.free[:3]):
        value = max((row[axis] for row in force), key=abs)
        if abs(value) > SWALLOWED * largest:
            yield axis, f"f{'xyz'[axis]} = {force_text(value)}"
    # forces across a plane of symmetry are reported above
    across = np.array([not any(mirror.axis == name for mirror in body.mirrors) for name in "xyz"])
    for axis in np.flatnonzero(~body.free[3:]):
        given = max((row[axis] for row in moment), key=abs)
        of_force = max((np.cross(arm, row * across)[axis] for row in force), key=abs)
        if abs(given) > SWALLOWED * max(np.linalg.norm(row) for row in moment):
            yield axis + 3, f"m{'xyz'[axis]} = {force_text(given, 'N m')}"
        elif abs(of_force) > least * largest:
            yield axis + 3, f"the moment m{'xyz'[axis]} = {force_text(of_force, 'N m')} of the force at its point"


def _arm(described, body, point):
    """Arm (3,) [m] in space of a point of a body at the start. Where the body is cut its loads may act in the plane, as
    half of those on the whole, or at its centre, so that this arm is none."""
    centre, rotation = initial_pose(described, body)
    arm = rotation @ point
    for mirror in body.mirrors:
        a = AXES[mirror.axis]
        if mirror.cut and abs(centre[a] + arm[a] - mirror.at) < ASIDE * np.ptp(body.outline.vertices[:, a]):
            arm[a] = 0.0
    return arm


def _why(scene, body, component):
    """(why a component is not free, what to do) as texts."""
    name = FREEDOMS[component]
    for mirror in body.mirrors:
        if name in out_of_plane(mirror.axis):
            return (f"held, as the model is symmetric about {mirror} and its mirror image carries the mirrored load",
                    "Model the whole body for a load that is not symmetric")
    collapsed = [axis for axis in "xyz" if getattr(scene.grid, axis).collapsed]
    if any(name in out_of_plane(axis) for axis in collapsed):
        return (f"held across the collapsed axis {', '.join(collapsed)}",
                "Leave this component out, or model all three dimensions")
    if body.drive[component] or any(guide.component == component for guide in body.guides):
        return "driven", "Leave this component out, or do not drive it"
    return "held", "Release it (body.held, stage.held, or a motion with free), or leave this component out"


def driven_into_held_ground(scene, model):
    """Bodies that guides press into ground that does not deform: the penalty alone, a number of the method, resists."""
    if not model.soil.held or model.soil.grid.collapsed[2]:
        return
    for described, body in zip(scene.bodies, model.bodies):
        place = initial_vertices(described, body)
        down = min([0.0, *(z for stage in path_along(scene, described, "z") for z in stage)])
        level = top_of(model.soil) if scene.soil.ground is None else heights_at(heights(scene.soil.ground), place[:, :2])
        deep = (level - place[:, 2]).max() - down
        if down < 0.0 and deep > PRESSED * body.radius:
            yield (f"{body.name} is driven {deep:.3g} m into soil that does not deform, limit 0: nothing but the penalty "
                   "resists, and its force is none of the soil's. Leave out soil.held = true, or load the body "
                   "(stage.load) instead")


def swallowed_pulls(scene, model):
    """Pull lines that lead across a plane of symmetry."""
    for i, (described, body) in enumerate(zip(scene.bodies, model.bodies)):
        if described.pull is None:
            continue
        travel = np.array(described.pull.direction or described.pull.velocity)
        for mirror in body.mirrors:
            if abs(travel[AXES[mirror.axis]]) > ASIDE * np.linalg.norm(travel):
                yield (f"body.{i}.pull of {body.name} leads along {mirror.axis}, held, as the model is symmetric about "
                       f"{mirror} and its mirror image is pulled the other way: the body does not feel this part of its "
                       "tension. Model the whole body, or let the line lie in the plane")


def moving_halves(scene, model):
    """Bodies with their middle in a roller face of the grid, as half a model, that move out of it or are joined beside it:
    the other half has no soil."""
    for described, body in zip(scene.bodies, model.bodies):
        place = initial_vertices(described, body)
        for axis, a in AXES.items():
            mirrored = any(mirror.axis == axis for mirror in body.mirrors)
            if getattr(scene.grid, axis).collapsed or scene.gravity[a] or mirrored:
                continue
            names = moved(scene, described, out_of_plane(axis))
            joints = [joint.name for joint in scene.joints if body.name in joint.bodies]
            what, remedy = f"is joined beside it by {', '.join(joints)}: its mirror image has other joints", "join it there"
            if names:
                what = f"moves in {', '.join(names)}: its mirror image would move against it"
                remedy = "leave these components out"
            ends = _half_at(scene, model.soil, axis, place[:, a].min(), place[:, a].max()) if names or joints else ()
            for end in ends:
                yield (f"{body.name} lies across {axis} = {end:.4g} m, the end of the grid, with its middle in it, as "
                       f"half a model does, and {what}, so that it is taken as a whole body with soil on one side alone. "
                       f"Extend the grid to both sides of it, or {remedy}")


def _half_at(scene, soil, axis, low, high):
    """Coordinates [m] of the roller faces across an axis in which the middle of a body from `low` to `high` [m] lies
    beside soil."""
    a, (start, end) = AXES[axis], soil.grid.extent[AXES[axis]]
    lowest, highest = extent(soil.constants, a)
    covers = low <= start and high >= end
    for side, face, reached in ((0, start, lowest), (1, end, highest)):
        middle = abs(0.5 * (low + high) - face) < MIDDLE * (high - low)
        near = abs(reached - face) < soil.grid.smallest_cell
        if middle and not covers and near and scene.grid.faces.of(a, side) == "roller":
            yield face


LIMITS = (driven_into_held_ground, swallowed_loads, swallowed_pulls, moving_halves)
