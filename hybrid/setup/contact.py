"""Contact of a body with the soil of a scene: where it is evaluated, how stiff it is, and its part in plane strain.

Spacing of the places on the faces of domains    s = 2 l / k <= r/16, on held soil r/32      k from 4 to 32
penalty on soil that deforms                      p_f = 200 / h
penalty on held soil                              p_f E = W / (π r δ²),  δ = 2 s²/r

with l the largest half-width of a domain, h the smallest cell, r the smallest radius of curvature of the body (a
body of planes: its size) and W its weight. On soil that deforms the overlap is that of 1/200 of a cell under the
same pressure (platen: 0.3 % of the force). On held soil nothing but the penalty gives way: there δ is the
overlap of a sphere under its weight, whose contact patch, sqrt(2 r δ), has a radius of two spacings; a stiffer one
would feel the places one by one. Measured in DESIGN, "Contact".
"""

from dataclasses import replace

import numpy as np

from hybrid.body import rigid
from hybrid.body.rigid import FREEDOMS
from hybrid.contact import places
from hybrid.runtime.comm import largest
from hybrid.runtime.errors import SceneError

FEWEST, MOST = 4, 32                # places along a face
CURVATURE, HELD_CURVATURE = 16, 32  # spacings in a radius of curvature
STIFFNESS = 200.0                   # p_f h
PATCH = 2.0                         # spacings in the radius of a contact patch on held soil
PUBLISHED = 50.0                    # [1/m] p_f
STRAIGHT = 1e-6                     # sine of the angle between a prism's surface and its axis


def connect_to_soil(described, body, soil, gravity):
    """The body with all of its contact that follows from `soil`; gravity (3,) [m/s²]. Raises SceneError."""
    body = in_slice(body, soil.grid, described.rotation)
    chosen, spacing, radius = _places(described, body, soil)
    body = replace(body, places=chosen, penalty=_penalty(described, body, soil, spacing, radius, gravity))
    return rigid.with_stiffness(body, soil.law.young, soil.held)


def _places(described, body, soil):
    """(Places, their spacing [m], smallest radius of curvature [m] of the body)."""
    width, radius = 2 * largest(soil.constants.half_width[:, ~soil.grid.collapsed]), body.surface.smallest_radius
    if described.contact == "corners":
        return places.corners(), width, radius
    wanted = (HELD_CURVATURE if soil.held else CURVATURE) * width / radius
    k = int(np.clip(np.ceil(wanted), FEWEST, MOST))
    return places.faces(k, soil.grid.collapsed), width / k, radius


def _penalty(described, body, soil, spacing, radius, gravity):
    """p_f [1/m], or on held soil p_f E [N/m³]."""
    young, weight = largest(soil.law.young), body.mass.mass * np.linalg.norm(gravity)
    factor = young if soil.held else 1.0
    if described.penalty is not None:
        return described.penalty * factor
    if described.contact == "corners":
        return PUBLISHED * factor
    if not soil.held or weight == 0.0:
        return STIFFNESS / soil.grid.smallest_cell * factor
    radius = min(radius, body.radius)
    overlap = 0.5 * (PATCH * min(spacing, radius / HELD_CURVATURE)) ** 2 / radius
    return weight / (np.pi * radius * overlap**2)


def in_slice(body, grid, rotation=None):
    """The body as it is modelled on a grid with collapsed axes: the part of a prism that lies in the slice.

    Its mass is that on the thickness of the slice, and it neither moves along a collapsed axis nor tilts it.
    Raises SceneError when it is no prism along such an axis.
    """
    for axis in np.flatnonzero(grid.collapsed):
        letter, thickness = "xyz"[axis], np.ptp(grid.extent[axis])
        turned = np.zeros(3) if rotation is None else np.array(rotation[:3])
        slope = np.abs(body.surface.normals[:, axis])
        tilted = turned.any() and np.linalg.norm(np.delete(turned, axis)) > STRAIGHT
        if tilted or ((slope > STRAIGHT) & (slope < 1 - STRAIGHT)).any():
            raise SceneError(
                f"body {body.name!r} is no prism along the collapsed axis {letter}: in plane strain all sections of a "
                f"body across {letter} are equal. Use a prism, such as geometry/box.geo, rotated about {letter} at most, or "
                f"model the third dimension with grid.{letter}.collapsed = false")
        share = thickness / np.ptp(body.surface.vertices[:, axis])
        mass = replace(body.mass, **{name: share * getattr(body.mass, name)
                                     for name in ("mass", "inertia", "matrix", "gravity_load")})
        fixed = np.array([freedom == letter or (freedom.startswith("r") and freedom != "r" + letter)
                          for freedom in FREEDOMS])
        body = replace(body, mass=mass, free=body.free & ~fixed)
    return body
