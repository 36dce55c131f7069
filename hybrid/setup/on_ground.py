"""Straight held ground under bodies with edges: which are in contact with it at places of their own, and how stiff.

    k = F / (d d'/16 δ)     F the weight of the body, d and d' its sides (`hybrid.setup.foot`), δ = d/80 000

in plane strain F / (b d/4 δ), b the thickness of the slice: on a face of a quarter of the sides it overlaps by δ. Edges
count with a width, and corners with an area, with which they alone carry F at an overlap of 8 δ, less in space, where
corners stand beside an edge; curved edges, a short arc of which touches, with more. In space they press from an overlap on
that is DEEPER times that of a face of a fifth of the surface, so that such a face carries alone when it lies flat. Where
bodies meet, overlaps are ten times as large (`hybrid.setup.body_contact`): a block of 0.2 x 0.6 m that slides with 0.9 of
the friction at which it tips then does tip, as what it rests on swings when friction sets in.
With a given penalty, p_f E for each area of the ground, points of the ground are in contact, exactly so.

Equations: FORMULATION (60).
"""

import numpy as np

from hybrid.body import rigid
from hybrid.body.surface import build_surface
from hybrid.body.symmetry import AXES, copies
from hybrid.contact.body_to_body import Side
from hybrid.contact.on_ground import AT_REST, HeldGround, PlacesOverPlane, Stretch, SurfacePoints
from hybrid.contact.samples import flat_overlap, on_curves, sample
from hybrid.scene.defaults import STANDARD_GRAVITY
from hybrid.setup.foot import sides_of_contact
from hybrid.setup.ground import depth_in_ground
from hybrid.soil.points import extent

PLACES = 16         # in the size of a body
SINKS = 1.25e-5     # of the least side: overlap under F
EDGE, CORNER = 1 / 64, 1 / 128      # of the least side: width of edges; of the sides' product: area of corners
DEEPER = 4.0        # times the overlap of faces that lie flat: overlap from which on edges and corners press
IN_SLICE = 6.0      # times that width in plane strain, where no corners stand beside an edge
SMOOTH = 0.25       # of that overlap: what a curved edge rises by between its places
FAR = 1e3           # sizes that the ground goes down, and along a collapsed axis
ON_FACE = 1e-6      # of the radius, between a place and the face that it is on
INSIDE = 2e-3       # of the size: what begins deeper in the ground, or beside it, is left to points of the ground
TURN = np.radians(6.0)          # between normals of neighbours in SurfacePoints
STRAIGHT = 1e-9     # [rad] by which a profile bends at a point on a straight stretch
PLANE = 1e-5        # of the rise of heights on a grid, by which they differ from a plane
SIDES = (0, 2, 1), (0, 3, 2), (4, 5, 6), (4, 6, 7)      # triangles of bottom and top of a block, by its corners


def is_made_for(described, body, motion, soil):
    """Whether a body touches the held ground at places of its own where it stands on them: one that is not curved all over,
    above ground with straight stretches, with a penalty that is left out. motion: BodyState at the start."""
    plain = soil.held and described.penalty is None and described.contact != "corners"
    if not plain or body.interface or body.surface.turning.all() or soil.grid.collapsed[2]:
        return False
    if not _stretches(soil, body, motion):
        return False
    deepest = INSIDE * 2.0 * body.surface.radius
    if soil.heights is None:
        return rigid.bounding_box(body, motion)[0][2] > _ends(soil)[1][2] - deepest
    return depth_in_ground(*soil.heights, body, motion, soil.grid.collapsed) < deepest


def ground_of(body, motion, soil, gravity):
    """HeldGround under a body with the initial state `motion`; gravity (3,) [m/s²]."""
    collapsed, rotation, stretches = soil.grid.collapsed, motion.rotation, _stretches(soil, body, motion)
    size, across = 2.0 * _radius(body.surface, rotation, collapsed), [mirror for mirror in body.mirrors if not mirror.cut]
    thickness = np.prod(np.ptp(soil.grid.extent[collapsed], axis=1)) if collapsed.any() else None
    weight = copies(body.mirrors) * body.mass.mass * (float(np.linalg.norm(gravity)) or STANDARD_GRAVITY)
    sides = sides_of_contact(size, body.surface, _below(stretches, motion.position)[1].T @ rotation, collapsed)
    face = np.prod(sides) / 16 if thickness is None else thickness * sides[0] / 4
    stiffness, surface, flat, share, width = weight / (face * SINKS * sides[0]), body.surface, None, 1.0, EDGE * sides[0]
    depth = DEEPER * flat_overlap(surface, weight, stiffness)
    if collapsed.any():
        flat, width, depth = rotation[collapsed], IN_SLICE * width, 0.0
        surface = _thin(surface, flat, size)
        share = thickness / np.prod([np.ptp(surface.vertices @ axis) for axis in flat])
    samples = sample(surface, size / PLACES, width, CORNER * np.prod(sides), depth, flat, share / copies(across),
                     SMOOTH * SINKS * sides[0])
    found, within = [], None
    if soil.heights is not None and soil.heights[0][1] is not None and not across and stretches[0][2] is not AT_REST:
        within = _table_ends(*soil.heights[0][:2], *_ends(soil))
    for low, high, pose in stretches:
        low, high = _beyond_mirrors((low, high), body.mirrors, FAR * size)
        block = _block(low, high, collapsed, FAR * size)
        places = samples.near(np.eye(3), np.zeros(3), block, np.inf)
        found.append(Stretch(Side(0, 1, PlacesOverPlane(places, high[2]), block), low, high, pose, within))
    faces = _faces(samples, surface) if body.parts else None
    points = _surface_points(samples, surface, places) if surface.turning.any() else None
    return HeldGround(tuple(found), stiffness, collapsed, size / PLACES, faces, points)


def _surface_points(samples, surface, places):
    """SurfacePoints of a body: its places on plane faces and edges, and points on its curved faces."""
    turning = surface.turning
    numbers = np.repeat(turning, 4**samples.pieces.cuts)     # of places on faces; those on edges follow
    plane = places.number[~np.concatenate([numbers, np.zeros(len(samples.edges.point), bool)])[places.number]]
    beside = np.concatenate([np.zeros((len(numbers), 2, 3)), samples.beside])[plane]
    kept = np.isin(places.number, plane)
    normals = surface.corner_normals[turning]
    cosine = np.einsum("tki,tki->tk", normals, np.roll(normals, -1, axis=1)).min(axis=1)
    point, normal = on_curves(samples, np.flatnonzero(turning), np.arccos(np.clip(cosine, -1.0, 1.0)), TURN)
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


def _stretches(soil, body, motion):
    """[(low, high (3,) [m], pose)] of the straight stretches of the ground that are as long as a body, by the ends of each
    in its own frame, as in Stretch: all of it where it is plane, else those of a profile. Where a plane of symmetry
    crosses a slope, it does not go on beyond it."""
    low, high = _ends(soil)
    if soil.heights is None:
        return [(low, high, AT_REST)]
    (x, y, z), top = soil.heights
    if y is not None:
        if np.ptp(np.minimum(z, top)) == 0.0:
            return [(low, np.array([*high[:2], min(z.min(), top)]), AT_REST)]
        return _slope(x, y, z, low, high, body.mirrors) if z.max() <= top else []
    mirrored, least = any(mirror.axis == "x" for mirror in body.mirrors), np.ptp(rigid.bounding_box(body, motion)[:, 0])
    found = []
    for (x0, z0), (x1, z1) in _straight(x, z, low[0], high[0]):
        if max(z0, z1) > top:
            z0, z1 = (top, top) if min(z0, z1) >= top else (z0, z1)
        level = z0 == z1
        if x1 - x0 < least or max(z0, z1) > top or mirrored and not level:
            continue
        if level:
            found.append((np.array([x0, *low[1:]]), np.array([x1, high[1], z0]), AT_REST))
            continue
        length = np.hypot(x1 - x0, z1 - z0)
        c, s = (x1 - x0) / length, (z1 - z0) / length
        pose = np.array([x0, 0.0, z0]), np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
        found.append((np.array([0.0, low[1], low[2] - high[2]]), np.array([length, high[1], 0.0]), pose))
    return found


def _slope(x, y, z, low, high, mirrors):
    """The one stretch of ground with heights z (a, b) [m] that lie in a plane, from `low` to `high` (3,) [m]; none of
    others, nor where a plane of symmetry crosses the slope."""
    along, across = (z[-1, 0] - z[0, 0]) / (x[-1] - x[0]), (z[0, -1] - z[0, 0]) / (y[-1] - y[0])
    plane = z[0, 0] + along * (x - x[0])[:, None] + across * (y - y[0])
    crossed = any(abs(across if mirror.axis == "y" else along) * np.ptp(x) > PLANE * np.ptp(z) for mirror in mirrors)
    if crossed or np.abs(z - plane).max() > PLANE * np.ptp(z):
        return []
    first, last = _table_ends(x, y, low, high)
    up = np.array([-along, -across, 1.0]) / np.hypot(1.0, np.hypot(along, across))
    ahead = np.array([1.0, 0.0, along]) / np.hypot(1.0, along)
    rotation = np.column_stack([ahead, np.cross(up, ahead), up])
    origin = np.array([first[0], 0.0, z[0, 0] + along * (first[0] - x[0]) - across * y[0]])
    length = last[0] - first[0]
    corners = np.array([(a, b, along * a + across * b) for a in (0.0, length) for b in (first[1], last[1])])
    ends = [getattr(corners @ rotation, name)(axis=0)[:2] for name in ("min", "max")]
    return [(np.array([*ends[0], low[2] - high[2]]), np.array([*ends[1], 0.0]), (origin, rotation))]


def _table_ends(x, y, low, high):
    """(2, 2) [m] first and last x and y of heights on a grid between the ends of the soil."""
    return np.array([np.maximum([x[0], y[0]], low[:2]), np.minimum([x[-1], y[-1]], high[:2])])


def _straight(x, z, first, last):
    """Yields ((x, z), (x, z)) [m] of the ends of each straight stretch of a profile, level beyond its ends, from `first` to
    `last` [m]."""
    inside = (x > first) & (x < last)
    x, z = (np.concatenate([[a], values[inside], [b]]) for a, values, b in (
        (first, x, last), (np.interp(first, x, z), z, np.interp(last, x, z))))
    begin = 0
    for i in range(1, len(x)):
        bends = i == len(x) - 1 or abs((z[i + 1] - z[i]) * (x[i] - x[i - 1]) - (z[i] - z[i - 1]) * (x[i + 1] - x[i])) > (
            STRAIGHT * (x[i] - x[i - 1] + abs(z[i] - z[i - 1])) * (x[i + 1] - x[i] + abs(z[i + 1] - z[i])))
        if bends:
            if x[i] > x[begin]:
                yield (x[begin], z[begin]), (x[i], z[i])
            begin = i


def _below(stretches, position):
    """Pose of the stretch under a position (3,) [m], else of the first one."""
    for low, high, (origin, rotation) in stretches:
        if low[0] <= ((position - origin) @ rotation)[0] <= high[0]:
            return origin, rotation
    return stretches[0][2]


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
    return np.array([extent(soil.constants, axis) for axis in range(3)]).T


def _radius(surface, rotation, collapsed):
    """[m] of a ball around the section of a body."""
    return float(np.linalg.norm(surface.vertices @ rotation[~collapsed].T, axis=1).max())
