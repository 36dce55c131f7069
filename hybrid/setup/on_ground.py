"""Level held ground under bodies with edges: which are in contact with it at places of their own, and how stiff.

    k = F / (d d'/16 δ)     F the weight of the body, d and d' its sides (`hybrid.setup.foot`), δ = d/80 000

in plane strain F / (b d/4 δ), b the thickness of the slice: on a face of a quarter of the sides it overlaps by δ. Edges count
with a width, and corners with an area, with which they alone carry F at an overlap of 8 δ, less in space, where corners stand beside an edge. In space they press
from an overlap on that is DEEPER times that of a face of a fifth of the surface, so that such a face carries alone when it
lies flat. Where bodies meet, overlaps are ten times as large (`hybrid.setup.body_contact`): a block of 0.2 x 0.6 m that
slides with 0.9 of the friction at which it tips then does tip, as what it rests on swings when friction sets in.
With a given penalty, p_f E for each area of the ground, points of the ground are in contact, exactly so.

Equations: FORMULATION (60).
"""

import numpy as np

from hybrid.body import rigid
from hybrid.body.surface import build_surface
from hybrid.body.symmetry import AXES, copies
from hybrid.contact.body_to_body import Side
from hybrid.contact.on_ground import HeldGround, SurfacePoints, PlacesOverPlane
from hybrid.contact.samples import flat_overlap, on_curves, sample
from hybrid.runtime.comm import maximum, minimum
from hybrid.scene.defaults import STANDARD_GRAVITY
from hybrid.setup.foot import sides_of_contact

PLACES = 16         # in the size of a body
SINKS = 1.25e-5     # of the least side: overlap under F
EDGE, CORNER = 1 / 64, 1 / 128      # of the least side: width of edges; of the sides' product: area of corners
DEEPER = 4.0        # times the overlap of faces that lie flat: overlap from which on edges and corners press
IN_SLICE = 6.0      # times that width in plane strain, where no corners stand beside an edge
FAR = 1e3           # sizes that the ground goes down, and along a collapsed axis
ON_FACE = 1e-6      # of the radius, between a place and the face that it is on
INSIDE = 2e-3       # of the size: what begins deeper in the ground, or beside it, is left to points of the ground
TURN = np.radians(6.0)          # between normals of neighbours in an SurfacePoints
SIDES = (0, 2, 1), (0, 3, 2), (4, 5, 6), (4, 6, 7)      # triangles of bottom and top of a block, by its corners


def is_made_for(described, body, motion, soil):
    """Whether a body touches the held ground at places of its own where it stands on them: one that is not curved all over,
    above level ground, with a penalty that is left out. motion: BodyState at the start."""
    plain = soil.held and described.penalty is None and described.contact != "corners"
    if not plain or body.interface or body.surface.curved.all() or soil.grid.collapsed[2]:
        return False
    box = rigid.bounding_box(body, motion)
    ends = _level(soil, box)
    return ends is not None and box[0][2] > ends[1][2] - INSIDE * 2.0 * body.surface.radius


def ground_of(body, motion, soil, gravity):
    """HeldGround under a body with the initial state `motion`; gravity (3,) [m/s²]."""
    collapsed, rotation = soil.grid.collapsed, motion.rotation
    size, across = 2.0 * _radius(body.surface, rotation, collapsed), [mirror for mirror in body.mirrors if not mirror.cut]
    thickness = np.prod(np.ptp(soil.grid.extent[collapsed], axis=1)) if collapsed.any() else None
    weight = copies(body.mirrors) * body.mass.mass * (float(np.linalg.norm(gravity)) or STANDARD_GRAVITY)
    sides = sides_of_contact(size, body.surface, rotation, collapsed)
    face = np.prod(sides) / 16 if thickness is None else thickness * sides[0] / 4
    stiffness, surface, flat, share, width = weight / (face * SINKS * sides[0]), body.surface, None, 1.0, EDGE * sides[0]
    depth = DEEPER * flat_overlap(surface, weight, stiffness)
    if collapsed.any():
        flat, width, depth = rotation[collapsed], IN_SLICE * width, 0.0
        surface = _thin(surface, flat, size)
        share = thickness / np.prod([np.ptp(surface.vertices @ axis) for axis in flat])
    samples = sample(surface, size / PLACES, width, CORNER * np.prod(sides), depth, flat, share / copies(across))
    low, high = _beyond_mirrors(_level(soil, rigid.bounding_box(body, motion)), body.mirrors, FAR * size)
    block = _block(low, high, collapsed, FAR * size)
    places = PlacesOverPlane(samples.near(np.eye(3), np.zeros(3), block, np.inf), high[2])
    faces = _faces(samples, surface) if body.parts else None
    points = _surface_points(samples, surface, places.places) if surface.curved.any() else None
    return HeldGround(Side(0, 1, places, block), stiffness, low, high, collapsed, size / PLACES, faces, points)


def _surface_points(samples, surface, places):
    """SurfacePoints of a body: its places on plane faces and edges, and points on its curved faces."""
    numbers = np.repeat(surface.curved, 4**samples.pieces.cuts)     # of places on faces; those on edges follow
    plane = places.number[~np.concatenate([numbers, np.zeros(len(samples.edges.point), bool)])[places.number]]
    beside = np.concatenate([np.zeros((len(numbers), 2, 3)), samples.beside])[plane]
    kept = np.isin(places.number, plane)
    normals = surface.corner_normals[surface.curved]
    cosine = np.einsum("tki,tki->tk", normals, np.roll(normals, -1, axis=1)).min(axis=1)
    point, normal = on_curves(samples, np.arccos(np.clip(cosine, -1.0, 1.0)), TURN)
    curved = np.concatenate([beside, np.stack([normal, np.zeros_like(normal)], axis=1)])
    return SurfacePoints(np.concatenate([places.point[kept], point]), curved)


def _faces(samples, surface):
    """(n, k) triangles of a `surface` at the place of each number: that which it is on, and all around edges and corners."""
    pieces, close = samples.pieces, ON_FACE * surface.radius + samples.pieces.bulge
    inner = np.repeat(np.arange(len(pieces.cuts)), 4**pieces.cuts)
    corners = surface.vertices[surface.triangles]
    lower, upper = corners.min(axis=1) - close, corners.max(axis=1) + close
    around = []
    for point in samples.edges.point:
        height = np.einsum("ti,ti->t", point - corners[:, 0], surface.normals)
        around.append(np.flatnonzero((np.abs(height) < close) & (point > lower).all(axis=1) & (point < upper).all(axis=1)))
    faces = np.full((len(inner) + len(around), max([1, *map(len, around)])), -1)
    faces[:len(inner), 0] = inner
    for row, found in zip(faces[len(inner):], around):
        row[:len(found)] = found
    return faces


def _thin(surface, axes, size):
    """A prism's surface, at most `size` [m] wide along unit vectors `axes` (k, 3), so that it has no more places than
    that."""
    vertices = surface.vertices
    for axis in axes:
        along = vertices @ axis
        vertices = vertices - max(0.0, 1.0 - size / np.ptp(along)) * along[:, None] * axis
    return build_surface(vertices, surface.triangles, surface.corner_normals, surface.curvature)


def _block(low, high, collapsed, far):
    """ContactSurface of the ground's top, and of a bottom `far` [m] below it, so that what goes deep in a long step is
    pushed up. It has no sides: what is beside it is out of its bounds. Along collapsed axes, about which bodies are at 0,
    it reaches `far`."""
    low, high = np.where(collapsed, -far, low), np.where(collapsed, far, high)
    low[2] = high[2] - far
    corners = [(x, y, z) for z in (low[2], high[2])
               for x, y in ((low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1]))]
    return build_surface(np.array(corners), np.array(SIDES))


def _level(soil, box):
    """(low, high) (3,) [m] of the level ground that is all of it, or that a profile has, under a bounding box (2, 3) [m];
    None where it is not level."""
    low, high = _ends(soil)
    if soil.heights is None:
        return low, high
    (x, y, z), top = soil.heights
    z = np.minimum(z, top)
    if y is not None and np.ptp(z) > 0.0:
        return None
    if y is None:
        first, last = np.searchsorted(x, box[0][0], side="right") - 1, np.searchsorted(x, box[1][0])
        under = z[max(first, 0):last + 1]
        if not len(under) or np.ptp(under) > 0.0:
            return None
        other = np.flatnonzero(z != under[0])
        before, after = other[other < max(first, 0)], other[other > first]
        low[0] = max(low[0], x[before[-1] + 1]) if len(before) else low[0]
        high[0] = min(high[0], x[after[0] - 1]) if len(after) else high[0]
    high[2] = np.min(z) if y is not None else under[0]
    return low, high


def _beyond_mirrors(ends, mirrors, far):
    """Ends of the ground, (low, high) (3,) [m], that goes on by `far` [m] beyond planes of symmetry."""
    low, high = (end.copy() for end in ends)
    for mirror in mirrors:
        axis = AXES[mirror.axis]
        side = low if abs(mirror.at - low[axis]) < abs(mirror.at - high[axis]) else high
        side[axis] += far if side is high else -far
    return low, high


def _ends(soil):
    """(low, high) (3,) [m] of all of the soil."""
    points = soil.constants
    return (np.array([minimum(lower) for lower in (points.position - points.half_width).T]),
            np.array([maximum(upper) for upper in (points.position + points.half_width).T]))


def _radius(surface, rotation, collapsed):
    """[m] of a ball around the section of a body."""
    return float(np.linalg.norm(surface.vertices @ rotation[~collapsed].T, axis=1).max())
