"""Joined bodies high above held soil: bars along x, and a pendulum."""

from dataclasses import replace

from hybrid.scene import Joint
from hybrid.study.scenes import box, plane

G = 9.81
LENGTHS = 0.6, 0.4
GRAVITY = (0.0, 0.0, -G)
CENTRE = 0.0      # height of the centre of the bars in their geometry
TIGHT = {"linear": "direct", "tolerance": 1e-9}


def joined(bodies, joints, steps, step, gravity=GRAVITY, **options):
    """Scene of joined bodies high above held soil."""
    scene = plane(bodies[0], steps, step, gravity=gravity, solver=TIGHT, **options)
    return replace(scene, bodies=tuple(bodies), joints=tuple(joints))


def arm(name, length, x, **given):
    """A bar along x, whose middle is `x` m from the origin and 5 m above the soil."""
    return box(length, 0.1, 0.08, name=name, position=(x, 0.0, 5.0), **given)


def pendulum(steps, step, **joint):
    """A bar that hangs on a hinge at its left end, level at the start."""
    hinge = Joint(name="pin", kind="hinge", bodies=("upper",), point=(-LENGTHS[0] / 2, 0.0, CENTRE),
                  axis=(0.0, 1.0, 0.0), **joint)
    return joined([arm("upper", LENGTHS[0], LENGTHS[0] / 2)], [hinge], steps, step)


def bar(length):
    """Mass and moment of inertia about y of a bar."""
    mass = 1000.0 * length * 0.1 * 0.08
    return mass, mass * (length**2 + 0.08**2) / 12
