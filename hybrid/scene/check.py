"""Checks of a scene: the range of each key, as declared, and keys that exclude, need or limit one another.

Each fault is a text with key, value, limit and remedy. Ranges are declared with the keys (`hybrid.scene.table`); this
module has what relates several keys, or a key to names and files.
"""

import re
from math import hypot

from hybrid.runtime.data import shipped_names
from hybrid.runtime.errors import SceneError
from hybrid.scene.body import out_of_plane
from hybrid.scene.check_grid import grid_faults
from hybrid.scene.check_joint import contact_faults, joint_faults
from hybrid.scene.check_material import material_faults
from hybrid.scene.check_stage import spatial_spin, stage_faults, velocities
from hybrid.scene.defaults import resolve
from hybrid.scene.read import clipped, did_you_mean
from hybrid.scene.soil import clay_layers, laws
from hybrid.scene.table import TINY, need, range_faults, shown
from hybrid.scheme import Scheme

LONGEST_NAME = 100      # bytes; file systems take 255 with what output adds


def faults(scene):
    """Texts of all faults of a Scene whose values already have their declared types."""
    yield from range_faults(scene)
    scene, _ = resolve(scene)
    yield from _plain_name("name", scene.name)
    yield from grid_faults(scene)
    yield from _soil("soil", scene.soil, scene.grid)
    if scene.grid.z.start is not None and scene.grid.z.end is not None:
        yield from material_faults(scene.soil, scene.grid)
    for i, body in enumerate(scene.bodies):
        yield from _body(f"body.{i}", body, scene.time.inertia)
        yield from _in_plane(f"body.{i}", body, scene.grid)
        yield from _interface(f"body.{i}", body, scene.soil)
        yield from need(body.contact != "faces" or scene.soil.basis == "gimp", f"body.{i}.contact", body.contact,
                        f"'corners' with soil.basis = {scene.soil.basis!r}, whose points have no faces", "leave it out")
        if body.pull and body.pull.diameter is not None:
            yield from _line_in_soil(f"body.{i}.pull.diameter", body.pull, scene.soil)
    yield from _time("time", scene.time)
    yield from need(scene.stages, "stage", "none", "at least one", "add a [[stage]] with a name and steps")
    for i, stage in enumerate(scene.stages):
        yield from _stage(f"stage.{i}", stage, scene.time)
        yield from stage_faults(f"stage.{i}", stage, scene)
    first = scene.stages[0].gravity[0] if scene.stages else 1.0
    yield from need(not scene.soil.geostatic or scene.soil.held or first == 1.0, "stage.0.gravity", first,
                    "1 at the start of soil in geostatic stress", "set soil.geostatic = false to turn gravity on")
    yield from _distinct_names("soil.layer", scene.soil.layers)
    yield from _distinct_names("body", scene.bodies, file_label)
    yield from _distinct_names("stage", scene.stages)
    yield from _distinct_names("joint", scene.joints, file_label)
    yield from joint_faults(scene)
    yield from contact_faults(scene)


def file_label(name):
    """A name as part of the names of files: letters, digits, point and dash; everything else becomes _."""
    return re.sub(r"[^\w.-]+", "_", name)


def _plain_name(key, name):
    # Names become folders and files of the output.
    plain = name.strip() == name != "" and name not in (".", "..") and "/" not in name and "\\" not in name
    fits = name.isprintable() and len(name.encode(errors="replace")) <= LONGEST_NAME
    return need(plain and fits, key, clipped(name), f"a plain file name of at most {LONGEST_NAME} bytes",
                "use letters, digits, - and _")


def _distinct_names(key, items, label=str):
    """Names that are the same, or the same as a `label`."""
    names = [item.name for item in items]
    for i, name in enumerate(names):
        others = [other for other in names[:i] if label(other) == label(name)]
        limit = "different from the other names"
        if others and others[0] != name:
            limit = f"different from {others[0]!r} as the name of a file, {label(name)!r}"
        yield from need(not others, f"{key}.{i}.name", clipped(name), limit,
                        f"name every [[{key}]]; output is labelled by it")


# ------------------------------------------------------------------ soil


def _soil(key, soil, grid):
    axes = grid.axes
    if any(axis.start is None or axis.end is None for axis in axes):
        return  # the grid's own fault, found already
    start, end = tuple(a.start for a in axes), tuple(a.end for a in axes)
    top = end[2] if soil.top is None else soil.top
    yield from need(start[2] < top <= end[2], f"{key}.top", top,
                    f"above {shown(start[2])} and at most {shown(end[2])}, the ends of the grid",
                    "leave room above the surface for heave by raising grid.z.end")
    lower, upper = soil.lower or start, soil.upper or (*end[:2], top)
    given = [name for name in ("lower", "upper") if getattr(soil, name) is not None]
    for name in given:
        corner = getattr(soil, name)
        yield from need(all(s <= c <= e for s, c, e in zip(start, corner, end)), f"{key}.{name}", corner,
                        f"inside the grid, {shown(start)} to {shown(end)}", "move it in or widen the grid")
    if given:
        yield from need(all(a < b for a, b in zip(lower, (*upper[:2], min(upper[2], top)))),
                        f"{key}.lower", lower,
                        f"below upper = {shown(upper)} and top = {shown(top)} along each axis",
                        "swap the corners")
    if soil.ground is not None:
        yield from _ground(f"{key}.ground", soil, grid, top)


def _line_in_soil(key, pull, soil):
    for wrong, what in ((soil.held, "soil.held"), (bool(soil.layers), "soil.layer"),
                        (soil.ground is not None, "soil.ground"),
                        (soil.material.law in ("hencky", "user"), f"soil.material.law = {soil.material.law!r}"),
                        (not pull.tension_only, "tension_only = false")):
        yield from need(not wrong, key, pull.diameter,
                        f"left out with {what}: the bearing of a line is known in level clay or sand of one kind",
                        "leave it out")


def _ground(key, soil, grid, top):
    from hybrid.scene.ground import heights  # late: it loads numpy, which other scenes are read without

    moving = [name for name in "xyz" if getattr(grid, name).window]
    yield from need(not moving, key, "given",
                    f"left out with grid.{'.'.join(moving)}.window: soil that comes in would not have settled",
                    "leave out the window")
    yield from need(soil.basis == "gimp", key, "given", "left out with soil.basis = 'mpm', whose points have no domains to "
                    "cut", "leave out soil.basis")
    try:
        x, y, z = heights(soil.ground, key)
    except SceneError as error:
        yield str(error)
        return
    yield from need(y is not None or not grid.x.collapsed, key, "a profile along x", "along an axis that is modelled; "
                    "grid.x.collapsed is true", "let y be the collapsed axis, or give heights at x and y in a file")
    low, high = grid.z.start, top
    yield from need(low < z.min() and z.max() <= high + 1e-9 * (high - low), key, f"{z.min():g} to {z.max():g} m",
                    f"above {low:g} m, the end of the grid, and at most soil.top = {high:g} m",
                    "lower grid.z.start, or raise the ground" if z.min() <= low else
                    "raise soil.top and grid.z.end, or lower the ground")


# ------------------------------------------------------------------ bodies


def _body(key, body, inertia):
    yield from _plain_name(f"{key}.name", body.name)
    yield from need(body.name != "soil", f"{key}.name", body.name, "other than 'soil'", "output labels the soil by it")
    if not body.geometry.is_file():
        yield from need(False, f"{key}.geometry", body.geometry, "an existing file",
                        "the path is relative to the scene file, or to the working folder from Python; hybrid comes with "
                        f"{', '.join(shipped_names())}, which go by name{did_you_mean(body.geometry.name, shipped_names())}")
    yield from need(body.density != {}, f"{key}.density", body.density, "a number, or one for each volume of the geometry "
                    "by its name", "7850.0 is steel")
    if body.rotation is not None:
        yield from need(hypot(*body.rotation[:3]) > TINY, f"{key}.rotation", body.rotation, "an axis other than zero",
                        "write [ax, ay, az, degrees], such as [0, 1, 0, 30]")
    both = [f for f in body.driven if f in body.held]
    yield from need(not both, f"{key}.driven", both, "other than held", "keep it in one of the two lists")
    for name, freedoms, motion in (("velocity", ("x", "y", "z"), body.velocity),
                                   ("spin", ("rx", "ry", "rz"), spatial_spin(body))):
        given = getattr(body, name)
        moves = [f for f, v in zip(freedoms, motion) if v and f not in body.driven]
        yield from need(inertia or not moves, f"{key}.{name}", given, "zero in a quasi-static scene, unless driven",
                        f"set time.inertia = true, or driven = {moves}")
        against = [f for f, v in zip(freedoms, motion) if v and f in body.held]
        yield from need(not against, f"{key}.{name}", given, f"zero along held {', '.join(against)}",
                        "release that freedom or start it at rest")
    if body.pull is not None:
        yield from _pull(f"{key}.pull", body.pull)


def _in_plane(key, body, grid):
    """Motions across collapsed axes, which would carry the body out of the slice."""
    rates = velocities(body)
    for axis in "xyz":
        if getattr(grid, axis).collapsed:
            out = [name for name in out_of_plane(axis) if rates[name]]      # driven ones without a rate are held
            yield from need(not out, f"{key}.velocity, spin", out, f"motions in the plane across the collapsed axis {axis}",
                            "leave these components out (spin is about the axes of the body), or model the third dimension "
                            f"with grid.{axis}.collapsed = false")


def _interface(key, body, soil):
    found = ", ".join(map(repr, sorted(laws(soil))))
    yield from need(body.adhesion is None or any(clay_layers(soil)), f"{key}.adhesion", body.adhesion,
                    f"left out with law = {found}, which has no s_u",
                    "use law = 'von-mises', or friction_angle = 0, for clay, or friction alone")
    yield from need(body.tension is None or not soil.held, f"{key}.tension", body.tension,
                    "left out on held soil, which follows no body", "set soil.held = false")


def _pull(key, pull):
    if pull.direction is None:
        yield from need(hypot(*pull.velocity) > TINY, f"{key}.velocity", pull.velocity,
                        "other than zero without a direction",
                        "give direction for a line whose far end stands still")
    else:
        yield from need(hypot(*pull.direction) > TINY, f"{key}.direction", pull.direction, "other than zero",
                        "leave it out for the direction of velocity")


# ------------------------------------------------------------------ time


def _time(key, time):
    for name, scheme in (("beta", "newmark"), ("gamma", "newmark"), ("spectral_radius", "generalised-alpha")):
        value = getattr(time, name)
        yield from need(value is None or time.scheme == scheme, f"{key}.{name}", value,
                        f"left out with scheme = {time.scheme!r}", f"or set scheme = {scheme!r}")
    if time.scheme == "newmark":
        yield from _newmark_pair(key, Scheme.newmark(time.beta, time.gamma))
    if time.smallest is not None:
        yield from need(time.smallest <= time.step, f"{key}.smallest", time.smallest,
                        f"at most step = {shown(time.step)} s", "leave it out for step/64")
    if time.accuracy is not None:
        yield from need(time.inertia, f"{key}.accuracy", time.accuracy,
                        "left out in a quasi-static scene, which has no error of time integration",
                        "choose time.step, or set time.inertia = true")


def _newmark_pair(key, scheme):
    yield from need(0.5 <= scheme.gamma <= 1, f"{key}.gamma", scheme.gamma, "from 0.5 to 1",
                    "below 0.5 the motion grows without bound, 0.5 has no numerical damping")
    yield from need(scheme.beta >= scheme.gamma / 2, f"{key}.beta", scheme.beta,
                    f"at least gamma/2 = {shown(scheme.gamma / 2)}", "(0.25, 0.5) and (0.5625, 1) are stable")


def _stage(key, stage, time):
    yield from _plain_name(f"{key}.name", stage.name)
    if stage.beta is not None or stage.gamma is not None:
        yield from _newmark_pair(key, Scheme.newmark(time.beta, time.gamma).with_pair(stage.beta, stage.gamma))
    if stage.step is not None and time.smallest is not None:
        yield from need(stage.step >= time.smallest, f"{key}.step", stage.step,
                        f"at least time.smallest = {shown(time.smallest)} s", "leave it out for time.step")
