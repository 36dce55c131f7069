"""Ranges of a scene's values: a generator of faults per dataclass, each with value, limit and remedy."""

from math import cos, hypot, prod, radians, sin

from hybrid.scene import Target
from hybrid.scene.check_grid import grid_faults, need, shown
from hybrid.scene.material import material_faults
from hybrid.scheme import Scheme


def faults(scene):
    """Texts of everything out of range in a Scene whose values already have their declared types."""
    yield from _name("name", scene.name)
    yield from grid_faults(scene)
    yield from _soil("soil", scene.soil, scene.grid)
    if scene.grid.z.start is not None and scene.grid.z.end is not None:
        yield from material_faults(scene.soil, scene.grid)
    for i, body in enumerate(scene.bodies):
        yield from _body(f"body.{i}", body, scene.time.inertia)
        yield from need(not body.second_pass or scene.soil.basis == "gimp", f"body.{i}.second_pass", body.second_pass,
                        f"0 with soil.basis = {scene.soil.basis!r}, whose points have no faces",
                        "leave it out or set soil.basis = 'gimp'")
    yield from _time("time", scene.time)
    yield from need(scene.stages, "stage", "none", "at least one", "add a [[stage]] with a name and steps")
    for i, stage in enumerate(scene.stages):
        yield from _stage(f"stage.{i}", stage, scene.time)
    first = scene.stages[0].gravity[0] if scene.stages else 1.0
    yield from need(not scene.soil.geostatic or scene.soil.held or first == 1.0, "stage.0.gravity", first,
                    "1 at the start of soil in geostatic stress", "set soil.geostatic = false to turn gravity on")
    if isinstance(scene.accuracy, Target):
        yield from _target("accuracy", scene.accuracy)
    yield from _distinct("soil.layer", scene.soil.layers)
    yield from _distinct("body", scene.bodies)
    yield from _distinct("stage", scene.stages)
    yield from _solver("solver", scene.solver)
    yield from _output("output", scene.output)


def _name(key, name):
    # Names become folders and files of the output.
    plain = name.strip() == name != "" and name not in (".", "..") and not set(name) & set("/\\\0\n")
    return need(plain, key, repr(name), "a plain file name", "use letters, digits, - and _")


def _distinct(key, items):
    names = [item.name for item in items]
    for i, name in enumerate(names):
        yield from need(name not in names[:i], f"{key}.{i}.name", repr(name),
                        "different from the other names", f"name every [[{key}]]; output is labelled by it")


# ------------------------------------------------------------------ soil


def _soil(key, soil, grid):
    axes = (grid.x, grid.y, grid.z)
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
    per_axis = soil.points_per_axis
    counts = per_axis if isinstance(per_axis, tuple) else (per_axis,) * 3
    yield from need(all(1 <= n <= 10 for n in counts), f"{key}.points_per_axis", per_axis, "from 1 to 10",
                    f"2 is usual; this asks for {prod(counts)} points per cell")
    yield from need(0 <= soil.ghost <= 1, f"{key}.ghost", soil.ghost, "from 0 to 1", "0 leaves it out, 0.033 is usual")
    yield from need(soil.blend is None or soil.transfer == "blended", f"{key}.blend", soil.blend,
                    f"left out with transfer = {soil.transfer!r}", "or set transfer = 'blended'")
    yield from need(soil.blend is None or 0 < soil.blend <= 1, f"{key}.blend", soil.blend, "above 0, at most 1",
                    "1 takes the nodes' velocity alone, 0.05 is usual")
    if soil.k0 is not None:
        yield from need(soil.k0 > 0, f"{key}.k0", soil.k0, "positive", "leave it out for the material's own")


# ------------------------------------------------------------------ bodies


def _body(key, body, inertia):
    yield from _name(f"{key}.name", body.name)
    yield from need(body.geometry.is_file(), f"{key}.geometry", body.geometry, "an existing file",
                    "the path is relative to the scene file, or to the working folder from Python")
    yield from need(body.density > 0, f"{key}.density", body.density, "positive", "in kg/m³: 7850 is steel")
    yield from need(body.friction >= 0, f"{key}.friction", body.friction, "at least 0",
                    "0.45 is steel on sand")
    yield from need(body.penalty > 0, f"{key}.penalty", body.penalty, "positive", "50 is usual, in 1/m")
    yield from need(0 <= body.second_pass <= 1, f"{key}.second_pass", body.second_pass, "from 0 to 1",
                    "0 leaves it out, 0.5 gives both passes the same share")
    yield from need(body.tangential > 0, f"{key}.tangential", body.tangential, "positive", "1 is usual")
    if body.rotation is not None:
        yield from need(any(body.rotation[:3]), f"{key}.rotation", body.rotation, "an axis other than zero",
                        "write [ax, ay, az, degrees], such as [0, 1, 0, 30]")
    both = [f for f in body.driven if f in body.held]
    yield from need(not both, f"{key}.driven", both, "other than held", "keep it in one of the two lists")
    for name, freedoms, motion in (("velocity", ("x", "y", "z"), body.velocity),
                                   ("spin", ("rx", "ry", "rz"), _spatial_spin(body))):
        given = getattr(body, name)
        moves = [f for f, v in zip(freedoms, motion) if v and f not in body.driven]
        yield from need(inertia or not moves, f"{key}.{name}", given, "zero in a quasi-static scene, unless driven",
                        f"set time.inertia = true, or driven = {moves}")
        against = [f for f, v in zip(freedoms, motion) if v and f in body.held]
        yield from need(not against, f"{key}.{name}", given, f"zero along held {', '.join(against)}",
                        "release that freedom or start it at rest")
    if body.pull is not None:
        yield from _pull(f"{key}.pull", body.pull)


def _spatial_spin(body):
    """Spin (3,) about the axes of space, in which rotations are held and driven; round-off of the turn left out."""
    if body.rotation is None or not any(body.rotation[:3]):
        return body.spin
    length, angle = hypot(*body.rotation[:3]), radians(body.rotation[3])
    (x, y, z), (p, q, r) = (a / length for a in body.rotation[:3]), body.spin
    along, across = x * p + y * q + z * r, (y * r - z * q, z * p - x * r, x * q - y * p)
    turned = [v * cos(angle) + w * sin(angle) + a * along * (1 - cos(angle))
              for v, w, a in zip(body.spin, across, (x, y, z))]
    return tuple(v if abs(v) > 1e-12 * hypot(*body.spin) else 0.0 for v in turned)


def _pull(key, pull):
    yield from need(pull.stiffness > 0, f"{key}.stiffness", pull.stiffness, "positive",
                    "in N/m, for example 1e6")
    yield from need(pull.length > 0, f"{key}.length", pull.length, "positive", "in m, for example 10")
    if pull.direction is None:
        yield from need(any(pull.velocity), f"{key}.velocity", pull.velocity,
                        "other than zero without a direction",
                        "give direction for a line whose far end stands still")
    else:
        yield from need(any(pull.direction), f"{key}.direction", pull.direction, "other than zero",
                        "leave it out for the direction of velocity")


# ------------------------------------------------------------------ time, solver, output


def _time(key, time):
    yield from need(time.step > 0, f"{key}.step", time.step, "positive", "in s, for example 0.04")
    for name, scheme in (("beta", "newmark"), ("gamma", "newmark"), ("spectral_radius", "generalised-alpha")):
        value = getattr(time, name)
        yield from need(value is None or time.scheme == scheme, f"{key}.{name}", value,
                        f"left out with scheme = {time.scheme!r}", f"or set scheme = {scheme!r}")
    if time.scheme == "newmark":
        yield from _pair(key, Scheme.newmark(time.beta, time.gamma))
    rho = time.spectral_radius
    yield from need(rho is None or 0 <= rho <= 1, f"{key}.spectral_radius", rho, "from 0 to 1",
                    "0 removes high frequencies in one step, 1 damps nothing, 0.8 is usual")
    if time.smallest is not None:
        yield from need(0 < time.smallest <= time.step, f"{key}.smallest", time.smallest,
                        f"above 0 and at most step = {shown(time.step)}", "leave it out for step/64")
    if time.accuracy is not None:
        yield from need(0 < time.accuracy <= 1, f"{key}.accuracy", time.accuracy, "above 0, at most 1",
                        "in smallest cells a step: 1e-3 is usual")
        yield from need(time.inertia, f"{key}.accuracy", time.accuracy, "left out in a quasi-static scene, where time "
                        "is only the order of events", "choose time.step, or set time.inertia = true")


def _pair(key, scheme):
    yield from need(0.5 <= scheme.gamma <= 1, f"{key}.gamma", scheme.gamma, "from 0.5 to 1",
                    "less than 0.5 grows without bound; 0.5 has no numerical damping")
    yield from need(scheme.beta >= scheme.gamma / 2, f"{key}.beta", scheme.beta,
                    f"at least gamma/2 = {shown(scheme.gamma / 2)}", "(0.25, 0.5) and (0.5625, 1) are stable")


def _stage(key, stage, time):
    yield from _name(f"{key}.name", stage.name)
    yield from need(stage.steps >= 1, f"{key}.steps", stage.steps, "at least 1",
                    "remove the stage to leave it out")
    if stage.beta is not None or stage.gamma is not None:
        yield from _pair(key, Scheme.newmark(time.beta, time.gamma).with_pair(stage.beta, stage.gamma))
    yield from need(all(0 <= s <= 10 for s in stage.gravity), f"{key}.gravity", stage.gravity, "shares from 0 to 10",
                    "[0.0, 1.0] turns gravity on, leave it out for all of it")
    if stage.step is not None:
        smallest = 0.0 if time.smallest is None else time.smallest
        yield from need(stage.step > 0 and stage.step >= smallest, f"{key}.step", stage.step,
                        f"positive and at least time.smallest = {shown(smallest)}",
                        "leave it out for time.step")


def _target(key, target):
    yield from need(0 < target.error < 1, f"{key}.error", target.error, "above 0 and below 1", "0.02 is 2 %")
    yield from need(target.length > 0, f"{key}.length", target.length, "positive",
                    f"in m: the length of this scene that {target.like!r} has its cells across")


def _solver(key, solver):
    for name in ("tolerance", "linear_tolerance", "augmentation_tolerance"):
        value = getattr(solver, name)
        yield from need(1e-14 <= value < 1, f"{key}.{name}", value, "from 1e-14 to below 1",
                        "1e-6 for Newton and 1e-3 for the linear solver are usual")
    for name in ("loosest_tolerance", "tangent_tolerance"):
        yield from need(0 <= getattr(solver, name) < 1, f"{key}.{name}", getattr(solver, name), "from 0 to below 1",
                        "0 switches it off")
    yield from need(0 <= solver.elastic_share < 1, f"{key}.elastic_share", solver.elastic_share, "from 0 to below 1",
                    "0 is the consistent tangent, 0.1 helps loose sand")
    for name in ("iterations", "augmentations"):
        yield from need(getattr(solver, name) >= 1, f"{key}.{name}", getattr(solver, name), "at least 1",
                        "15 and 5 are usual")


def _output(key, output):
    for name in ("every", "checkpoint"):
        value = getattr(output, name)
        yield from need(value >= 0, f"{key}.{name}", value, "at least 0", "0 writes none")
    yield from need(all(step >= 1 for step in output.pictures), f"{key}.pictures", output.pictures,
                    "steps of the last stage, from 1", "leave out step 0")
