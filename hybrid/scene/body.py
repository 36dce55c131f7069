"""The rigid bodies of a scene and the lines that pull them."""

from pathlib import Path
from typing import Literal

from hybrid.scene.table import key, table

Vector = tuple[float, float, float]
Freedom = Literal["x", "y", "z", "rx", "ry", "rz"]


def out_of_plane(axis):
    """Components of a body out of the plane normal to `axis`: the translation along it and both rotations that tilt it."""
    return (axis, *(f"r{other}" for other in "xyz" if other != axis))


@table
class Pull:
    """An elastic line from a point of a body to a far end that moves at a constant velocity.

    The line is just taut at the start of the first stage that pulls.
    """

    point: str | Vector = key("name of a physical point of the geometry, or three coordinates of the geometry", "m")
    velocity: Vector = key("velocity of the far end", "m/s")
    stiffness: float = key("stiffness of the line; of a half body that of half of the line", "N/m", above=0,
                           remedy="for example 1e6")
    length: float = key("unstretched length", "m", above=0, remedy="for example 10")
    direction: Vector | None = key("direction from the point to the far end at the start; left out: along `velocity`",
                                   "-", default=None)
    tension_only: bool = key("the line goes slack instead of pushing", default=True)
    diameter: float | None = key(
        "of the wire, or of the bars of the chain, that cuts through the soil between the ground and the point: it is "
        "pulled at the ground, and its force on the body is smaller and steeper; left out: no soil acts on the line. Of a "
        "half body half of the line is modelled", "m", default=None,
        above=0, remedy="0.05 is a chain of 50 mm")
    chain: bool = key("with `diameter`: a chain, which bears on 2.5 diameters; else a wire, on one", default=True)
    bearing_factor: float | None = key(
        "Nc of clay (von-mises, or friction_angle = 0) or Nq of sand in the bearing of that line; left out: 11, or "
        "exp(π tan φ) tan²(45° + φ/2)", "-", default=None, above=0, remedy="8.5 to 14 is usual in clay")
    line_friction: float = key("friction along that line over its bearing", "-", default=0.4, at_least=0, at_most=1,
                               remedy="0.35 to 0.5 is usual of a chain")


@table
class Body:
    """A rigid body meshed from a file of gmsh or CAD."""

    geometry: Path = key("path of the geometry (.geo), or of a solid, triangles or a mesh (.step, .iges, .brep, .stl, "
                         ".msh); in a scene file relative to that file, or the name of one that hybrid comes with, such as "
                         "box.geo",
                         also=("file", "mesh", "stl", "path", "shape"))
    density: float | dict[str, float] = key(
        "density of the body, or of each of its physical volumes by name, such as { shank = 7850.0, fluke = 7200.0 }",
        "kg/m³", above=0, remedy="7850 is steel", also=("rho", "mass", "weight"))
    name: str = key("label of the body and of its files in the output", default="body")
    parameters: dict[str, float] = key("values of the geometry's named parameters, in the units that the .geo states",
                                       default_factory=dict,
                                       also=("dimensions", "size", "radius", "diameter", "length", "width", "height"))
    scale: float = key("metres in a unit of the geometry's coordinates, 0.001 for triangles in millimetres; .step and "
                       ".iges are read in metres whatever their unit, and points of loads, joints and lines are in "
                       "metres", "-", default=1.0, above=0,
                       remedy="0.001 is for millimetres, 1 for metres")
    symmetry: Literal["x", "y"] | None = key(
        "the file has the whole body, and the half of it at positive x or y of the geometry is modelled; a .geo file cuts "
        "by itself", default=None)
    position: Vector | None = key("place of the geometry's origin; left out: (0, 0, 0)", "m", default=None,
                                  also=("center", "centre", "origin", "location"))
    rotation: tuple[float, float, float, float] | None = key(
        "(ax, ay, az, angle): axis and angle of a rotation about the geometry's origin; left out: none", "-, deg",
        default=None, also=("orientation", "rotate", "angle", "attitude"))
    rest_on: float | Literal["ground"] | None = key(
        "height z of the lowest contact vertex, instead of position z; ground: as low as soil.ground, or soil.top, lets it; "
        "left out: as positioned", "m", default=None)
    velocity: Vector = key("velocity of the centre of mass at the start", "m/s", default=(0.0, 0.0, 0.0))
    spin: Vector = key("angular velocity at the start, about the axes of the body", "rad/s", default=(0.0, 0.0, 0.0),
                       also=("omega", "angular_velocity"))
    held: tuple[Freedom, ...] = key("translations and rotations (about the axes of space) that do not change",
                                    default=(), also=("fixed", "constraints", "locked"))
    driven: tuple[Freedom, ...] = key(
        "translations and rotations that keep the velocity and spin of the start, whatever force that needs",
        default=(), also=("motion", "prescribed"))
    friction: float | None = key("Coulomb coefficient μ against the soil: shear is at most μ times the pressure; left "
                                 "out: 0, or no such limit with `adhesion`", "-", default=None, at_least=0,
                                 remedy="0.45 is steel on sand", also=("mu", "friction_coefficient"))
    adhesion: float | None = key("adhesion factor α against clay (von-mises, or friction_angle = 0): shear is at most α "
                                 "times the s_u of the touching soil, softened where that softens; with `friction` the "
                                 "smaller limit holds, without `tension` 10 times the pressure too; other soil has "
                                 "friction alone; left out: 1 with friction, where some of the soil is clay", "-",
                                 default=None, at_least=0, at_most=1,
                                 remedy="0.3 to 0.5 is usual of steel in soft clay", also=("alpha", "roughness"))
    tension: float | Literal["full"] | None = key(
        "tension that soil on the body bears before it breaks away there, once and for all; full: it never breaks away; "
        "left out: none", "Pa", default=None, above=0, remedy="leave it out for soil that comes off freely")
    contact: Literal["faces", "corners"] | None = key(
        "where contact is evaluated on the soil's points: the faces of their domains, or the corners of the domains as "
        "in the published method", default=None)
    penalty: float | None = key("p_f: contact has a pressure of p_f E per unit of overlap; left out: stiff beside the "
                                "cells of the soil, or beside the weight of the body on held soil", "1/m", default=None,
                                above=0, remedy="leave it out")
    tangential: float | None = key("ratio ε_T / ε_N of tangential to normal stiffness of contact with the soil; the "
                                   "larger, the less a rolling body creeps; left out: 3, or 0.3 where clay sticks, and on "
                                   "soil that deforms without a curved face to roll on; 1 at corners", "-", default=None,
                                   above=0, remedy="1 is usual")
    pull: Pull | None = key("line that drags the body", default=None)
