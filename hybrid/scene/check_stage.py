"""Checks of the motions and loads of bodies in the stages of a scene."""

from math import cos, hypot, radians, sin

from hybrid.runtime.errors import SceneError
from hybrid.scene.body import out_of_plane
from hybrid.scene.read import clipped, did_you_mean
from hybrid.scene.stage import table_rows
from hybrid.scene.table import need


def stage_faults(key, stage, scene):
    """Texts of all faults in the motions and loads of a Stage, at the `key` of a scene file."""
    taken = {}
    for i, motion in enumerate(stage.motions):
        path = f"{key}.motion.{i}"
        yield from _body(path, motion, scene)
        yield from _motion(path, motion, scene.grid)
        name = motion.body or (scene.bodies[0].name if len(scene.bodies) == 1 else None)
        for component in components(motion):
            one = name, motion.point, component
            yield from need(one not in taken, path, component, f"in one motion of the stage and is in {taken.get(one)} too",
                            "keep one of them")
            taken.setdefault(one, path)
        if key == "stage.0" and name in (names := [body.name for body in scene.bodies]):
            body = scene.bodies[names.index(name)]
            lost = [component for component in motion.held if motion.point is None and velocities(body)[component]]
            yield from need(not lost, f"{path}.held", lost, f"other than what {name} moves along at the start, a velocity "
                            "that holding it ends", "start it at rest, or give the later stage motion = { component = "
                            "..., velocity = ... }")
    for i, load in enumerate(stage.loads):
        path = f"{key}.load.{i}"
        yield from _body(path, load, scene)
        yield from need(load.force is not None or load.moment is not None, path, "nothing", "a force or a moment",
                        "give force = [0.0, 0.0, -1e3] for a load of 1 kN downwards")
        yield from need(load.point is None or load.force is not None, f"{path}.point", load.point,
                        "left out without a force", "a moment has no point")
        yield from _tables(path, (("force", load.force, 4), ("moment", load.moment, 4)))


def components(motion):
    """Names of the components that a Motion speaks of."""
    return (*motion.free, *motion.held, *([motion.component] if motion.component else []))


def moved(scene, described, names):
    """Components among `names` in which something moves a body: its velocity and spin, what drives it, or motions of
    stages."""
    rates = velocities(described)
    found = [name for name in names if name in described.driven or rates.get(name)]
    for stage in scene.stages:
        found += [name for motion in stage.motions if motion.body in (None, described.name)
                  for name in components(motion) if name in names and name not in motion.held]
    return list(dict.fromkeys(found))


def velocities(body):
    """{component: velocity [m/s] or spin [rad/s] about the axes of space} of a body at the start."""
    return dict(zip(("x", "y", "z", "rx", "ry", "rz"), (*body.velocity, *spatial_spin(body))))


def spatial_spin(body):
    """Spin (3,) about the axes of space, in which rotations are held and driven, without the rotation's round-off."""
    if body.rotation is None or not any(body.rotation[:3]):
        return body.spin
    length, angle = hypot(*body.rotation[:3]), radians(body.rotation[3])
    (x, y, z), (p, q, r) = (a / length for a in body.rotation[:3]), body.spin
    along, across = x * p + y * q + z * r, (y * r - z * q, z * p - x * r, x * q - y * p)
    turned = [v * cos(angle) + w * sin(angle) + a * along * (1 - cos(angle))
              for v, w, a in zip(body.spin, across, (x, y, z))]
    return tuple(v if abs(v) > 1e-12 * hypot(*body.spin) else 0.0 for v in turned)


def _body(path, given, scene):
    names = [body.name for body in scene.bodies]
    if given.body is None:
        yield from need(len(names) == 1, f"{path}.body", "left out", "given where the scene does not have one body",
                        f"name one of {', '.join(names)}" if names else "add a [[body]]")
    else:
        yield from need(given.body in names, f"{path}.body", clipped(given.body),
                        f"one of {', '.join(names) or 'the bodies, of which there are none'}",
                        f"name a [[body]]{did_you_mean(given.body, names)}")


def _motion(path, motion, grid):
    named = components(motion)
    yield from need(named, path, "nothing", "a motion of a component", "give free, held, or component with a velocity or "
                    "a displacement")
    given = [name for name in ("velocity", "displacement") if getattr(motion, name) is not None]
    yield from need(len(given) == (motion.component is not None), f"{path}.component", motion.component or "left out",
                    f"with one of velocity and displacement, but has {' and '.join(given) or 'none of them'}",
                    f"write component = '{motion.component or 'x'}' and velocity = 0.1")
    if motion.point is not None:
        yield from need(not motion.free, f"{path}.free", motion.free, "left out with a point", "release components of the "
                        "centre of mass; points are guided in the stages that say so")
        turns = [name for name in named if len(name) == 2]
        yield from need(not turns, path, turns, "translations with a point", "a body turns alike at all of its points: "
                        "give rotations in a motion without a point")
    for axis in "xyz":
        if getattr(grid, axis).collapsed:
            fixed = [name for name in named if name in out_of_plane(axis)]
            yield from need(not fixed, path, fixed, f"a motion in the plane across the collapsed axis {axis}",
                            "leave these components out")
    yield from _tables(path, (("velocity", motion.velocity, 2), ("displacement", motion.displacement, 2)))


def _tables(path, tables):
    for name, value, columns in tables:
        if value is not None:
            try:
                table_rows(value, columns, f"{path}.{name}")
            except SceneError as error:
                yield str(error)
