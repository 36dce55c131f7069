"""Search of the places on the points' domains that are near a body: from domains to groups of places to places.

A body is searched in its own frame. In plane strain it is the prism over its section through its centre of mass, so
positions are those in the plane of that section.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hybrid.body.closest import closest
from hybrid.body.facet_tree import LANES, NO_SIDE, tree_of_parts
from hybrid.contact import places
from hybrid.runtime.comm import largest, total
from hybrid.runtime.jit import njit, prange
from hybrid.soil.given_ground import GivenGround

TURNED = np.radians(45.0)     # of soil, from which on its faces are others than at the start


class Reach(NamedTuple):
    """Distance from a body within which contact points are followed: margin [m] around the surface, and the path of the
    surface towards them in a step of dt [s]."""

    margin: float
    dt: float

    def farthest(self, body, radius):
        """[m] for any point around a `body` (BodyState) of `radius` [m]."""
        return self.margin + self.dt * (np.linalg.norm(body.velocity) + np.linalg.norm(body.spin) * radius)

    def at(self, position, normal, body):
        """(m,) [m] at positions (m, 3) [m] to which a surface with outward normals (m, 3) is closest."""
        velocity = body.velocity + np.cross(body.rotation @ body.spin, position - body.position)
        return self.margin + self.dt * np.maximum(0.0, np.einsum("mi,mi->m", velocity, normal))


@dataclass(frozen=True)
class Domains:
    """Domains of the soil's points: position, half (n, 3) [m], zero in standard MPM; volume: (n,) initial [m³];
    included: (n,) bool, points that are not deactivated; number: (n,) of the points in the run, None where one process has
    them all; ground: GivenGround that places follow, None where they are on the domains; deformation: (n, 3, 3) gradient F
    of the points, None where they have not turned."""

    position: np.ndarray
    half: np.ndarray
    volume: np.ndarray
    included: np.ndarray
    number: np.ndarray | None = None
    ground: GivenGround | None = None
    deformation: np.ndarray | None = None

    @classmethod
    def of(cls, points, constants, basis, ground=None):
        """Domains of `points` with their PointConstants, a `basis` "gimp" or "mpm", and the GivenGround."""
        half = points.half_width if basis == "gimp" else np.zeros_like(points.half_width)
        return cls(points.position, half, constants.volume, points.active, constants.number, ground,
                   points.deformation)

    def projected_share(self, places, point, number, normal):
        """Area (m,) [-] projected along normals (m, 3) of a body over that of the faces that `places` are on; point,
        number: (m,) of each."""
        usual = places.projected_share(number, normal)
        if self.ground is None or places.at_corners:
            return usual
        return self.ground.projected_share(point, places.up(number), places.flat[number], normal, usual)

    def turned(self, point):
        """Whether points (m,) have turned by more than TURNED since the start, by the rotation R of F = R U."""
        if self.deformation is None:
            return np.zeros(len(point), bool)
        left, _, right = np.linalg.svd(self.deformation[point])
        return np.einsum("mij,mji->m", left, right) < 1.0 + 2.0 * np.cos(TURNED)

    def sunk(self, point, number, position, places):
        """Distance (m,), in half-widths, of positions (m, 3) [m] of places of these numbers behind their faces, less that by
        which they may be moved to the ground; 0 of corners, which are on no face."""
        normal = places.normal[places.group_of(number)]
        half = np.maximum((self.half[point] * np.abs(normal)).sum(axis=1), 1e-300)
        behind = half - ((position - self.position[point]) * normal).sum(axis=1) - self.shift(point, places) * normal[:, 2]
        return np.zeros(len(point)) if places.at_corners else behind / half

    def shift(self, point, places):
        """Distance [m], (m,) or 0, by which places of points are moved to the ground at most."""
        return 0.0 if self.ground is None or places.at_corners else self.ground.shift[point]


def distances(y, surface, reach=np.inf):
    """Signed distances (m,) [m] of positions y (m, 3) in the body frame from the surface, inf beyond `reach` [m]; outside
    lower bounds of what a point has to move to touch it. And the outward normals there (m, 3)."""
    out, normal = gaps_and_normals(y, surface, reach)
    return np.where(out > 0.0, out / surface.tree.patches.steepness, out), normal


def gaps_and_normals(y, surface, reach=np.inf):
    """Gaps (m,) [m] between positions y (m, 3) in the body frame and the surface as contact sees them, inf beyond `reach`
    [m], and the outward normals there (m, 3)."""
    out, normal = np.empty(len(y)), np.zeros((len(y), 3))
    _distances(np.ascontiguousarray(y), reach, *surface.tree.parts, out, normal)
    return out, normal


def new_points(domains, places, collapsed, body, surface, reach, known):
    """Contact points within reach other than those `known` (k,) from the history, {name: values}.

    The search narrows from domains near the body's bounding box to those within reach, to groups of their places (on a
    face of a domain), then to the places themselves. Places that do not look at the body have no stiffness and are left out.
    """
    farthest = reach.farthest(body, surface.radius)
    point = _near(domains, collapsed, body, surface, farthest, places)
    around = farthest + np.linalg.norm(np.where(collapsed, 0.0, domains.half[point]), axis=1) + domains.shift(point, places)
    point = point[gaps_in_space(domains.position[point], collapsed, body, surface, around.max(initial=0.0))[2] <= around]
    groups, each = places.offset.shape[:2]
    point, group = np.repeat(point, groups), np.tile(np.arange(groups), len(point))
    half = np.where(collapsed, 0.0, domains.half[point])
    middle = domains.position[point] + places.centre[group] * half
    size = np.linalg.norm(places.extent[group] * half, axis=1) + domains.shift(point, places)
    middle, normal, distance = gaps_in_space(middle, collapsed, body, surface, farthest + size.max(initial=0.0))
    close = np.flatnonzero((distance <= reach.at(middle, normal, body) + size)
                           & places.group_may_face(group, normal))
    point, number = np.repeat(point[close], each), (each * group[close, None] + np.arange(each)).ravel()
    fresh = ~np.isin(point * len(places) + number, known)   # the grid has carried the others away from their domain
    point, number = point[fresh], number[fresh]
    position = domains.position[point] + places.flat[number] * domains.half[point]
    if domains.ground is not None and not places.at_corners:
        way, kept = domains.ground.moved(point, places.up(number), places.flat[number])
        position[:, 2] += way
        point, number, position = point[kept], number[kept], position[kept]
    position, normal, distance = gaps_in_space(position, collapsed, body, surface, farthest)
    within = distance <= reach.at(position, normal, body)
    stay = np.flatnonzero(within & (domains.projected_share(places, point, number, normal) > 0.0))
    return {"point": point[stay], "place": number[stay], "position": position[stay], "clearance": distance[stay],
            "normal": normal[stay], "rest": np.minimum(distance[stay], 0.0)}


def _near(domains, collapsed, body, surface, reach, places=None):
    """Numbers (k,) of the domains whose bounding sphere is within `reach` [m] of the body's bounding box."""
    near, half = np.zeros(len(domains.position), np.bool_), np.where(collapsed, 0.0, domains.half)
    if places is not None:
        half[:, 2] += domains.shift(slice(None), places)
    _mark(_in_section(domains.position, collapsed, body), half, body.position,
          body.rotation, surface.lower - reach, surface.upper + reach, near)
    return np.flatnonzero(near & domains.included)


def gaps_in_space(position, collapsed, body, surface, reach):
    """Positions (m, 3) [m] in the plane of the body's section, normals of the body there (m, 3) in space, and signed
    distances (m,) [m], inf beyond `reach`."""
    position = _in_section(position, collapsed, body)
    distance, normal = distances((position - body.position) @ body.rotation, surface, reach)
    return position, normal @ body.rotation.T, distance


def _in_section(position, collapsed, body):
    """Positions (m, 3) [m] moved along the collapsed axes to the body's centre of mass."""
    return np.where(collapsed, body.position, position) if np.any(collapsed) else position


def overlap(domains, grid, body, surface):
    """Largest overlap [m] of a domain's corner with a body at its committed pose, and the number of corners inside."""
    near = _near(domains, grid.collapsed, body, surface, 0.0)
    position = domains.position[near, None] + places.corners().flat * domains.half[near, None]
    if domains.ground is not None:
        position = domains.ground.lowered(near, position)
    y = (_in_section(position.reshape(-1, 3), grid.collapsed, body) - body.position) @ body.rotation
    distance, _ = distances(y[((y > surface.lower) & (y < surface.upper)).all(axis=1)], surface)
    return largest(-distance), int(total(distance < 0.0))


@njit(cache=True)
def _mark(position, half, centre, rotation, lower, upper, near):
    """Mark the domains (n,) whose bounding sphere touches the box from `lower` to `upper` (3,) [m] of the body frame."""
    for p in range(len(position)):
        x0, x1, x2 = position[p, 0] - centre[0], position[p, 1] - centre[1], position[p, 2] - centre[2]
        size = math.sqrt(half[p, 0] ** 2 + half[p, 1] ** 2 + half[p, 2] ** 2)
        inside = True
        for i in range(3):
            y = rotation[0, i] * x0 + rotation[1, i] * x1 + rotation[2, i] * x2
            inside = inside and lower[i] - size <= y <= upper[i] + size
        near[p] = inside


@njit(cache=True, parallel=True)
def _distances(y, reach, arrays, patches, out, normal):
    for lane in prange(LANES):
        tree = tree_of_parts(arrays, patches)
        for n in range(lane, len(y), LANES):
            triangle, feature, _, _, out[n] = closest((y[n, 0], y[n, 1], y[n, 2]), reach, tree, NO_SIDE)
            if triangle >= 0:
                for i in range(3):
                    normal[n, i] = tree.normals[triangle, feature, i]
