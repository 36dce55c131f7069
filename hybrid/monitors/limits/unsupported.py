"""Scenes without inertia in which nothing balances a weight or a load, or holds a body: no step of them has an
equilibrium."""

from dataclasses import replace

import numpy as np

from hybrid.body.paths import path_along
from hybrid.monitors.limits.shape import leads
from hybrid.monitors.limits.start import initial_pose, initial_vertices, outline, top_of
from hybrid.monitors.load_reached import components_of, held_down
from hybrid.runtime.comm import total
from hybrid.soil.points import extent

FLUSH = 0.5     # cells between a body and the soil from which on a step does not find its contact
SUNK = 0.25     # cells above its lowest point up to which the surface of a body laid on the soil supports it
BALANCED = 0.01     # radii of a body that its centre of mass may lie beside the joint on which it hangs
BESIDE = 0.25   # cells from that support to the centre of mass from which on the body topples


def soil_without_support(scene, model):
    """Soil with weight, or that a body presses, which no face of the grid and no body below it holds."""
    soil, gravity = model.soil, np.asarray(scene.gravity, float)
    if soil.held or model.scheme.inertia or soil.grid.collapsed[2] or not gravity[2] and not _pressed(scene):
        return
    if any(_supports(scene, soil, axis, side) for axis in range(3) for side in (0, 1)):
        return
    if any(body.interface and body.interface.tension for body in model.bodies):     # it may hang on them
        return
    (low, _), cell = extent(soil.constants, 2), soil.grid.smallest_cell
    if any(initial_vertices(described, body)[:, 2].min() < low - 0.5 * cell
           for described, body in zip(scene.bodies, model.bodies)) or scene.joints:
        return
    apart = low - soil.grid.extent[2, 0]
    where = (f'grid.faces.z_min = "{scene.grid.faces.z_min}"' if apart < 0.5 * cell else
             f"the soil ends at z = {low:.3g} m, {apart:.3g} m above the grid's lower end")
    weight = total(soil.constants.mass) * np.abs(gravity[2])
    what, outcome = ((f"Nothing supports the weight of the soil, {weight:.3g} N", "falls and no step has an equilibrium")
                     if weight else ("Nothing holds the soil along z", "gives way as a whole to what presses it"))
    yield (f"{what}, without inertia: {where}, and no face is fixed, so that it {outcome}. Set "
           'grid.faces.z_min = "fixed", with the soil down to it, or time.inertia = true')


def _pressed(scene):
    """Whether a body is moved or loaded along z."""
    loads = [load.force for stage in scene.stages for load in stage.loads if load.force is not None]
    return bool(loads) or any(any(any(stage) for stage in path_along(scene, body, "z")) for body in scene.bodies)


def _supports(scene, soil, axis, side):
    """Whether a face of the grid that the soil reaches holds it along z: the lower or upper one that is not free, or a
    fixed one at a side."""
    condition = scene.grid.faces.of(axis, side)
    if condition == "free" or soil.grid.collapsed[axis] or axis != 2 and condition != "fixed":
        return False
    return abs(extent(soil.constants, axis)[side] - soil.grid.extent[axis, side]) < 0.5 * soil.grid.smallest_cell


def loads_that_lift(scene, model):
    """Bodies on the soil that forces of a stage pull up by more than their weight, with nothing that holds on to them."""
    soil = model.soil
    if model.scheme.inertia or scene.joints:
        return
    for described, body in zip(scene.bodies, model.bodies):
        place = initial_vertices(described, body)
        if place[:, 2].mean() < top_of(soil) or held_down(body):
            continue
        weight = 0.0 - body.mass.mass * scene.gravity[2]     # not -0
        for s, stage in enumerate(body.stages or ()):
            forces = [load.force.values for load in stage.loads if load.force is not None]
            if len(forces) != 1 or stage.held[2] or stage.driven[2]:    # tables of several need not have the same times
                continue
            force = forces[0][np.argmax(forces[0][:, 2])]
            if force[2] > max(0.0, weight):
                yield (f"stage.{s}.load on {body.name}, {components_of(force)}, lifts it off the soil: that is more than "
                       f"its weight, {weight:.3g} N, and without inertia nothing balances it. z points up, so that a "
                       "load that presses down is negative: change its sign, or let the soil hold on to the body "
                       "(body.tension), or set time.inertia = true")


def released_bodies(scene, model):
    """Bodies with components that a stage leaves free and nothing supports: along z of one that is above the soil, about
    the edge on which it stands, along the ground of one that lies on it without friction, if it is pushed there or has no
    plane base."""
    if model.scheme.inertia or scene.joints or len(model.bodies) > 1:     # a body may rest on another
        return
    for i, (described, body) in enumerate(zip(scene.bodies, model.bodies)):
        whole, place = outline(described, body, model.soil)
        for s, stage in enumerate(scene.stages):
            staged = model.for_stage(stage.held, number=s)
            before = path_along(replace(scene, stages=scene.stages[:s]), described, "z")
            centre = initial_pose(described, whole)[0]
            found = not s and _toppling(scene, model.soil, staged.bodies[i], whole, place, centre)
            found = found or _loose(scene, model.soil, staged.bodies[i], whole, place, before[-1][-1] if before else 0.0)
            if found and not staged.guides:     # of points, which hold a body too
                yield (f"stage {stage.name!r}: {body.name} {found}, and without inertia a step may have no equilibrium. "
                       "Hold what nothing supports (stage.held, body.held), or set time.inertia = true")
                break


def _loose(scene, soil, body, whole, place, travel):
    """Text about components of a body, moved by a `travel` [m] along z from its `place`, that nothing supports; else ""."""
    cell, gap = soil.grid.smallest_cell, place[:, 2].min() + travel - top_of(soil)
    if body.line is not None or body.interface and (body.interface.tension or body.interface.adhesion):
        return ""
    if gap > FLUSH * cell and body.free[2] and (scene.gravity[2] or body.loads):
        return f"is free along z, {gap:.3g} m above the soil, where nothing supports it"
    free = [axis for axis in (0, 1) if body.free[axis] and not soil.grid.collapsed[axis]]
    if body.friction or abs(gap) > 0.5 * cell or scene.soil.ground is not None or not free:
        return ""
    pushed = ", ".join("xy"[axis] for axis in free if _pushed(scene, body, axis))
    if not leads(whole, place, np.array([0.0, 0.0, -1.0])):
        return (f"lies on level ground without a plane base and without friction (body.friction = 0), free along "
                f"{', '.join('xy'[axis] for axis in free)}, where only the unevenness of cells that it presses holds it")
    return pushed and f"is pushed along {pushed} on its plane base, without friction (body.friction = 0) that holds it"


def _toppling(scene, soil, body, whole, place, centre):
    """Text about a body with vertices at `place` (V, 3) [m] that lies on level ground with its `centre` (3,) of mass beside
    all that supports it; else ""."""
    cell, low = soil.grid.smallest_cell, place[:, 2].min()
    held = body.line is not None or body.interface and body.interface.tension
    weighs = scene.gravity[2] < 0.0 and body.free[2]
    if held or not weighs or abs(low - top_of(soil)) > SUNK * cell or scene.soil.ground is not None:
        return ""
    angles = np.linspace(0.0, 2 * np.pi, 72, endpoint=False)
    travels = np.column_stack([np.cos(angles), np.sin(angles)])
    about = np.where(soil.grid.collapsed[:2], False, body.free[[4, 3]])     # ry topples along x, rx along y
    if not about.any():
        return ""
    travels = travels[(np.abs(travels) < 1e-9)[:, ~about].all(axis=1)]
    bears = place[:, 2] < low + SUNK * cell
    beside = -((place[bears, :2] - centre[:2]) @ travels.T).max(axis=0).min()
    if beside <= BESIDE * cell + _between_vertices(whole.surface, bears, place):
        return ""
    return f"stands on an edge or a point {beside:.3g} m beside its centre of mass, about which it topples"


def _between_vertices(surface, bears, place):
    """Longest edge [m] of curved triangles at the vertices that bear (V,) bool, between which a round body may stand."""
    own = surface.triangles[surface.curved & bears[surface.triangles].any(axis=1)]
    return np.linalg.norm(place[own] - place[np.roll(own, 1, axis=1)], axis=2).max(initial=0.0)


def _pushed(scene, body, axis):
    """Whether its weight, or a load of the stage, acts on a body along an axis."""
    loads = any(load.force is not None and load.force.values[:, axis].any() for load in body.loads)
    return bool(scene.gravity[axis] or loads)


def swinging_bodies(scene, model):
    """Bodies above the soil on a single hinge or ball joint, about which their weight turns them."""
    stage, pair = scene.stages[0], [number for joint in model.joints for number in joint.bodies if number is not None]
    staged = model.for_stage(stage.held, number=0)
    others = set(range(len(model.bodies))) - set(pair)      # on which it may lie
    if model.scheme.inertia or not np.any(scene.gravity) or staged.guides or others:
        return
    top, cell = top_of(model.soil), model.soil.grid.smallest_cell
    joined = [number for joint in model.joints for number in joint.bodies]
    for described, joint in zip(scene.joints, model.joints):
        for number, point in zip(joint.bodies, joint.points):
            if number is None or joint.length is not None or len(joint.pairs) > 2 or joined.count(number) > 1:
                continue
            body, of_scene = staged.bodies[number], scene.bodies[number]
            gap = initial_vertices(of_scene, body)[:, 2].min() - top
            moment = np.cross(initial_pose(of_scene, body)[1] @ -point, scene.gravity) * body.free[3:]   # of a unit of mass
            along = [described.axis / np.linalg.norm(described.axis)] if described.axis else np.eye(3)
            free = (body.free[:3] | model.soil.grid.collapsed).all() and body.line is None and not body.loads
            turning = max(abs(moment @ axis) for axis in along)
            held = joint.friction > body.mass.mass * turning or joint.limits is not None
            if free and not held and gap > FLUSH * cell and turning > BALANCED * body.radius * np.linalg.norm(scene.gravity):
                yield (f"{body.name} hangs on {joint.name}, {gap:.3g} m above the soil, and its weight turns it about that "
                       "until it lies on something: without inertia nothing balances it, and the first step may have no "
                       "equilibrium. Let it start where it rests (position, rotation), hold its rotation (body.held), or "
                       "set time.inertia = true")


LIMITS = (soil_without_support, loads_that_lift, released_bodies, swinging_bodies)
