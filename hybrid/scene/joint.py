"""Joints between two bodies of a scene, or between a body and the ground, and contacts of two bodies."""

from typing import Literal

from hybrid.scene.body import Vector
from hybrid.scene.table import key, table

# other words for the kinds
KIND_WORDS = {
    **dict.fromkeys(("pin", "pinned", "revolute", "pivot"), "hinge"),
    **dict.fromkeys(("spherical", "ball-joint", "ball joint"), "ball"),
    **dict.fromkeys(("fixed", "rigid", "clamp", "clamped"), "weld"),
    **dict.fromkeys(("link", "bar", "strut"), "rod"),
    **dict.fromkeys(("rope", "cable", "chain", "wire", "tether"), "line"),
}


@table
class Joint:
    """An exact joint of two bodies, or of a body and the ground. Joined bodies do not touch one another, others do
    (`contact`)."""

    name: str = key("label of the joint in the output")
    kind: Literal["hinge", "ball", "weld", "rod", "line"] = key(
        "hinge: one rotation is left; ball: all rotations; weld: none; rod: two points keep their distance; line: they "
        "come no farther apart than its length, straight through whatever is between them", words=KIND_WORDS)
    bodies: tuple[str, ...] = key("names of two bodies, or of one that is joined to the ground")
    point: str | Vector = key("where the first body is joined: name of a physical point of its geometry, or three "
                              "coordinates of that geometry", "m")
    end: str | Vector | None = key(
        "of a rod or line: its other end, likewise in the geometry of the second body, or three coordinates in space", "m",
        default=None)
    length: float | None = key("of a rod or line; left out: the distance of its ends at the start", "m", default=None,
                               above=0, remedy="leave it out")
    axis: Vector | None = key("of a hinge: direction in space at the start", "-", default=None)
    limits: tuple[float, float] | None = key(
        "smallest and largest angle of a hinge, at which it stops without rebound: rotation of the first body about the "
        "axis relative to the second one, 0 at the start", "deg", default=None, at_least=-170, at_most=170,
        remedy="leave it out for a hinge that turns freely")
    friction_moment: float = key("moment of a hinge that resists its rotation; of half bodies that on the half", "N m",
                                 default=0.0, at_least=0, remedy="0 is a hinge without friction")


@table
class Contact:
    """Contact of two bodies with one another, where it differs from what holds for all: bodies that no joint connects
    touch, with the smaller friction of the two."""

    bodies: tuple[str, str] = key("names of the two bodies")
    friction: float | None = key("Coulomb coefficient μ between them; left out: the smaller of their `friction`", "-",
                                 default=None,
                                 at_least=0, remedy="0.2 to 0.5 is usual of steel on steel")
    load: float | None = key(
        "force under which they overlap by at most a thousandth of the smaller one; left out: the weight of the lighter "
        "one", "N",
        default=None, above=0, remedy="the force with which one presses on the other")
