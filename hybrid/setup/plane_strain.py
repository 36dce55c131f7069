"""A body on a grid with collapsed axes: the part of a prism that lies in the slice."""

from dataclasses import replace

import numpy as np

from hybrid.body.rigid import FREEDOMS
from hybrid.body.surface import build_surface
from hybrid.runtime.errors import SceneError
from hybrid.scene.body import out_of_plane


def in_slice(body, grid, rotation):
    """The body as it is modelled on a grid with collapsed axes: the part of a prism that lies in the slice.

    Its mass is that on the thickness of the slice, and it neither moves along a collapsed axis nor tilts it.
    Raises SceneError when it is no prism along such an axis.
    """
    for axis in np.flatnonzero(grid.collapsed):
        letter, thickness = "xyz"[axis], np.ptp(grid.extent[axis])
        if not body.surface.is_prism(rotation[axis]):
            raise SceneError(
                f"body {body.name!r} is no prism along the collapsed axis {letter}: in plane strain all sections of a "
                f"body across {letter} are equal. Use a prism, such as geometry/box.geo, rotated about {letter} at most, or "
                "for curved faces smaller elements (parameters.size); or model the third dimension with "
                f"grid.{letter}.collapsed = false")
        share = thickness / np.ptp(body.surface.vertices @ rotation[axis])
        body = replace(body, mass=body.mass.times(share), free=body.free & ~np.isin(FREEDOMS, out_of_plane(letter)),
                       surface=_without_ends(body.surface, rotation[axis]))
    return body


def section(body, rotation, grid):
    """ContactSurface of a body's geometry, on a grid with a collapsed axis without the ends of the prism."""
    surface = body.outline
    for axis in np.flatnonzero(grid.collapsed):
        surface = _without_ends(surface, rotation[axis])
    return surface


def _without_ends(surface, axis):
    """The surface of a prism without its ends, which no point of its section is near."""
    sides = np.abs(surface.normals @ axis) < 0.5
    return build_surface(surface.vertices, surface.triangles[sides], surface.corner_normals[sides])
