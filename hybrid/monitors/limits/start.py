"""Soil and bodies of a model at the start: heights of the soil, poses of bodies and their vertices."""

from dataclasses import replace

import numpy as np

from hybrid.body.attitude import initial_rotation
from hybrid.monitors.limits.cell_size import ON_LINE
from hybrid.scene.ground import heights, heights_at, steepest
from hybrid.soil.given_ground import STEEPEST
from hybrid.soil.points import extent

STEEP = 1.5     # cells: a lower step of the ground is a slope
FLUSH = 1e-3    # of the height of a body, by which it may overlap another one that it stands on
RIM = 0.15      # cells that a lid may leave uncovered: contact sees its edges there as on the lines of the grid


def top_of(soil):
    """Height [m] of the highest soil at the start."""
    return extent(soil.constants, 2)[1]


def step_of_ground(scene, soil):
    """Height [m] of the highest upright step of soil.ground, 0 where there is none."""
    if scene.soil.ground is None:
        return 0.0
    cell, (x, y, z) = soil.grid.smallest_cell, heights(scene.soil.ground)
    steps = [(np.diff(z, axis=0), np.diff(x))] + ([] if y is None else [(np.diff(z, axis=1), np.diff(y))])
    return max(float(np.abs(rise[width < cell] if axis == 0 else rise[:, width < cell]).max(initial=0.0))
               for axis, (rise, width) in enumerate(steps))


def under_all(soil, place):
    """Whether a body with its vertices at `place` (V, 3) [m] is below all of the soil."""
    return place[:, 2].max() <= extent(soil.constants, 2)[0] + ON_LINE * soil.grid.resolution


def levelled(soil, place):
    """Places (V, 3) [m] as far above or below the top of the soil as they are above or below the ground, where its heights
    are given and it has no wall: as if it were level."""
    if soil.heights is None or steepest(soil.heights[0]) > STEEPEST:
        return place
    height = np.minimum(heights_at(soil.heights[0], place[:, :2]), soil.heights[1])
    return place + np.array([0.0, 0.0, 1.0]) * (top_of(soil) - height)[:, None]


def initial_vertices(described, body, surface=None):
    """Vertices (V, 3) [m] of a body's surface of contact, or of another `surface` of it, at its initial pose."""
    centre, rotation = initial_pose(described, body)
    return centre + (surface or body.surface).vertices @ rotation.T


def stands_on(place, other):
    """Whether a body with its vertices at `place` (V, 3) [m] is above another one, and over it."""
    (low, high), (start, end) = ((each.min(axis=0), each.max(axis=0)) for each in (place, other))
    return low[2] > end[2] - FLUSH * (high[2] - low[2]) and (low < end)[:2].all() and (high > start)[:2].all()


def initial_pose(described, body):
    """(centre of mass (3,) [m], rotation (3, 3)) of a body at the start."""
    rotation = initial_rotation(described)
    centre = np.array(described.position or (0.0, 0.0, 0.0)) + rotation @ body.mass.centre
    if described.rest_on is not None:
        centre[2] = described.rest_on + body.outline.extent(-rotation[2])
    return centre, rotation


def outline(described, body, soil):
    """(RigidBody with the surface of the whole body, places (V, 3) [m] of its vertices at the start, over level ground)."""
    whole = replace(body, surface=body.outline)
    return whole, levelled(soil, initial_vertices(described, whole))


def covers(vertices, soil):
    """Whether a body reaches over all of the soil in plan, but for RIM, so that hardly any gets above it."""
    slack = RIM * soil.grid.smallest_cell
    ends = [(vertices[:, axis], *extent(soil.constants, axis)) for axis in np.flatnonzero(~soil.grid.collapsed[:2])]
    return all(x.min() <= low + slack and x.max() >= high - slack for x, low, high in ends)
