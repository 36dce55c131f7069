"""Checks of the joints of a scene, and of the contacts between its bodies."""

from math import hypot

from hybrid.scene.read import clipped, did_you_mean
from hybrid.scene.table import TINY, need
from hybrid.scheme import Scheme

COLUMNS = "contact", "reaction", "load"     # of forces in history.csv, after the name of a body
DAMPED = 0.95   # spectral radius up to which multipliers do not oscillate for long


def joint_faults(scene):
    """Texts of all faults in the joints of a Scene whose keys are decided."""
    names = [body.name for body in scene.bodies]
    for i, joint in enumerate(scene.joints):
        key = f"joint.{i}"
        yield from need(joint.name not in names, f"{key}.name", joint.name, "different from the names of bodies",
                        "output is labelled by it")
        for name in names:
            labels = *(f"{name}_{kind}" for kind in COLUMNS), *(f"{name}_on_{other}" for other in names)
            yield from need(joint.name not in labels, f"{key}.name", joint.name,
                            f"other than {', '.join(labels[:3])} and the like",
                            f"columns of history.csv have these names, of body {name}")
        yield from need(len(joint.bodies) in (1, 2) and len(set(joint.bodies)) == len(joint.bodies), f"{key}.bodies",
                        joint.bodies, "one name, or two different ones", "one body is joined to the ground")
        yield from _named(f"{key}.bodies", joint.bodies, names)
        yield from _kind(key, joint)
    points = any(motion.point is not None for stage in scene.stages for motion in stage.motions)
    if (scene.joints or points) and scene.time.inertia:
        yield from _scheme(scene)


def contact_faults(scene):
    """Texts of all faults in the contacts of a Scene."""
    names, met = [body.name for body in scene.bodies], set()
    for i, contact in enumerate(scene.contacts):
        key, pair = f"contact.{i}.bodies", frozenset(contact.bodies)
        yield from need(len(pair) == 2, key, contact.bodies, "two different names", "a body does not touch itself")
        yield from _named(key, contact.bodies, names)
        yield from need(pair not in met, key, contact.bodies, "in one [[contact]]", "put its keys together")
        joined = any(frozenset(joint.bodies) == pair for joint in scene.joints)
        yield from need(not joined, key, contact.bodies, "bodies that no joint connects",
                        "joined bodies do not touch one another")
        met.add(pair)


def _named(key, given, names):
    for name in given:
        yield from need(name in names, key, clipped(name), f"names of bodies: {', '.join(names) or 'none'}",
                        f"name a [[body]]{did_you_mean(name, names)}")


def _kind(key, joint):
    two_ends, hinge = joint.kind in ("rod", "line"), joint.kind == "hinge"
    for name, wanted in (("end", two_ends), ("axis", hinge)):
        given = getattr(joint, name) is not None
        yield from need(given == wanted, f"{key}.{name}", "given" if given else "left out",
                        f"{'given' if wanted else 'left out'} with kind = {joint.kind!r}",
                        "a hinge has an axis, a rod and a line an end")
    yield from need(joint.axis is None or hypot(*joint.axis) > TINY, f"{key}.axis", joint.axis, "other than zero",
                    "[0.0, 1.0, 0.0] is an axis along y")
    yield from need(not isinstance(joint.end, str) or len(joint.bodies) == 2, f"{key}.end", joint.end,
                    "three coordinates where the other end is on the ground", "names are those of points of a second body")
    yield from need(two_ends or joint.length is None, f"{key}.length", joint.length, f"left out with kind = {joint.kind!r}",
                    "rods and lines have one")
    yield from need(hinge or joint.limits is None and not joint.friction_moment, f"{key}.limits, {key}.friction_moment",
                    "given", f"left out with kind = {joint.kind!r}", "only a hinge has them")
    if joint.limits is not None:
        yield from need(joint.limits[0] <= 0.0 <= joint.limits[1] and joint.limits[0] < joint.limits[1], f"{key}.limits",
                        joint.limits, "[lowest, highest] with 0, the angle at the start, between them", "swap or widen them")


def _scheme(scene):
    for stage in scene.stages:
        radius = Scheme.of(scene.time).with_pair(stage.beta, stage.gamma).spectral_radius
        yield from need(radius <= DAMPED, "time.scheme", scene.time.scheme,
                        f"one that damps in a scene with joints or guided points (spectral radius {radius:.3g}, limit "
                        f"{DAMPED:g})",
                        "leave it out; without damping their forces oscillate")
