"""Level held ground under bodies of plane faces: which are in contact with it at places of their own, and how stiff.

    k = F / ((d/4)² δ)      F the weight of the body, d its size, δ = d/10 000 its overlap on a face of d/4

in plane strain F / (b d/4 δ), b the thickness of the slice. Edges count with a width, and corners with an area, with which
they alone carry F at an overlap of δ, as where bodies meet (`hybrid.setup.body_contact`). There δ is ten times that: a block
of 0.2 x 0.6 m that slides with 0.9 of the friction at which it tips then does tip, as what it rests on swings when friction
sets in. With a given penalty, p_f E for each area of the ground, points of the ground are in contact, exactly so.

Equations: FORMULATION (60).
"""

from dataclasses import replace

import numpy as np

from hybrid.body import rigid
from hybrid.body.surface import build_surface
from hybrid.contact.body_to_body import Side
from hybrid.contact.closest_points import nearest
from hybrid.contact.on_ground import Ground
from hybrid.contact.samples import sample
from hybrid.runtime.comm import maximum, minimum

PLACES = 16         # in the size of a body
SINKS = 1e-4        # of the size: overlap under F
EDGE, CORNER = 1 / 8, 1 / 16        # of the size: width of edges; of its square: area of corners
INSIDE = 0.1        # of the radius: what begins deeper in the ground, or beside it, meets its sides too
STANDARD = 9.81     # [m/s²] where a scene has no gravity
FAR = 1e3           # sizes that the ground reaches along a collapsed axis
SIDES = (0, 2, 1), (0, 3, 2), (4, 5, 6), (4, 6, 7)      # triangles of bottom and top of a block, by its corners


def is_made_for(described, body, motion, soil):
    """Whether a body touches the held ground at places of its own: one without a curved face, above level ground at least as
    wide as half of it, with a penalty that is left out. motion: BodyState at the start."""
    plain = soil.held and soil.heights is None and described.penalty is None and described.contact != "corners"
    if not plain or body.mirrors or body.interface or body.surface.curved.any() or soil.grid.collapsed[2]:
        return False
    low, high = _ends(soil)
    above = rigid.bounding_box(body, motion)[0][2] > high[2] - INSIDE * body.surface.radius
    return above and bool((high - low)[:2][~soil.grid.collapsed[:2]].min(initial=np.inf) >= body.surface.radius)


def ground_of(body, rotation, soil, gravity):
    """Ground under a body at an initial `rotation` (3, 3); gravity (3,) [m/s²]."""
    collapsed, size = soil.grid.collapsed, 2.0 * _radius(body.surface, rotation, soil.grid.collapsed)
    thickness = np.prod(np.ptp(soil.grid.extent[collapsed], axis=1)) if collapsed.any() else None
    weight = body.mass.mass * (float(np.linalg.norm(gravity)) or STANDARD)
    face = (size / 4)**2 if thickness is None else thickness * size / 4
    stiffness = weight / (face * SINKS * size)
    flat, share = None, 1.0
    if collapsed.any():
        flat = rotation[collapsed]
        share = thickness / np.prod([np.ptp(body.surface.vertices @ axis) for axis in flat])
    samples = sample(body.surface, size / PLACES, EDGE * size, CORNER * size**2, flat, share)
    samples = replace(samples, first_edge=0)    # all places press on the nearest side of the ground alone
    beside = nearest(samples.edges.point, samples.edges.normal, body.surface)[0]
    return Ground(Side(0, 1, samples, _block(soil, FAR * size)), stiffness, beside, collapsed, size / PLACES)


def _block(soil, far):
    """ContactSurface of the ground's top, and of a bottom `far` [m] below it, so that what goes deep in a long step is
    pushed up. It has no sides: what is beside it is out of its bounds. Along collapsed axes, about which bodies are at 0,
    it reaches `far`."""
    low, high = _ends(soil)
    low, high = np.where(soil.grid.collapsed, -far, low), np.where(soil.grid.collapsed, far, high)
    low[2] = high[2] - far
    corners = [(x, y, z) for z in (low[2], high[2])
               for x, y in ((low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1]))]
    return build_surface(np.array(corners), np.array(SIDES))


def _ends(soil):
    """(low, high) (3,) [m] of all of the soil."""
    points = soil.constants
    return (np.array([minimum(lower) for lower in (points.position - points.half_width).T]),
            np.array([maximum(upper) for upper in (points.position + points.half_width).T]))


def _radius(surface, rotation, collapsed):
    """[m] of a ball around the section of a body."""
    return float(np.linalg.norm(surface.vertices @ rotation[~collapsed].T, axis=1).max())
