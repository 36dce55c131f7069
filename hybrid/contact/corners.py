"""Places on the points' domains that may touch a body during a step: corners of the domains or quadrature points of their
faces (`hybrid.contact.places`), called contact points.

A contact point starts at its place on the domain, x_p + o l. From the step in which it comes within `reach` of the body
it is a material point of its own, carried by the grid,

    x_c <- x_c + Σ_v N_v(x_c) Δu_v          N_v hat functions of its cell

until it leaves the reach. If it were placed on the domain anew in each step, it would move into the body where the soil
is compressed (a domain follows the average strain of its point, the contact point the larger strain next to the body)
and would add energy to the springs, as much as the plastic work under a settling anchor.

A place may be found inside the body: one that looked away until then. Its spring starts without force, at the gap g_0 that
it has then: else energy would come from nothing.

In plane strain a body is the prism over its section through its centre of mass: contact points lie in the plane of that
section, and forces are those on the thickness of the slice.

Equations: FORMULATION (39).
"""

import math
from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np
from numba import njit

from hybrid.body.closest import NO_SIDE, closest
from hybrid.contact import places as rules
from hybrid.contact.first_contact import predicted_contact_points
from hybrid.contact.interface import ATTACHED, NONE, PlaceLimits, lie_before, place_limits
from hybrid.runtime.comm import anywhere, largest, total
from hybrid.soil.basis import find_cell, hat

CORNERS = rules.corners()


@dataclass(frozen=True)
class Corners:
    """Contact points near one body, frozen during a step; m of them.

    point, place: (m,) increasing, the soil point and the number of the place on its domain
    position: (m, 3) [m] at the start of the step; start: (m, 3) the same in the body frame
    node, weight: (m, 8) grid nodes and hat functions there
    stiffness: (m,) ε_N [N/m]; touching: (m,) bool, in contact at the start of the step
    anchor: (m, 3) [m] body frame, of the tangential spring: history while touching, else the predicted first-contact
        point (contact/first_contact.py); side: (m, 3) body frame, outward normal where the point touches or is
        predicted to touch, 0 if unknown
    rest: (m,) [m] gap g_0 <= 0 at which the spring has no force
    clearance: (m,) [m] signed distance from the surface at the start: an open point that moves less than this cannot
        touch, so most points are not projected
    limits: PlaceLimits of the interface, empty where friction alone acts
    facet: (m,) triangle that a point is held to, -1 for those that find theirs; None where none is held
    """

    point: np.ndarray
    place: np.ndarray
    position: np.ndarray
    start: np.ndarray
    node: np.ndarray
    weight: np.ndarray
    stiffness: np.ndarray
    touching: np.ndarray
    anchor: np.ndarray
    side: np.ndarray
    rest: np.ndarray
    clearance: np.ndarray
    limits: PlaceLimits = NONE
    facet: np.ndarray | None = None

    def __len__(self):
        return len(self.point)

    def select(self, chosen):
        """The contact points of a mask (m,) bool."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return Corners(**{name: value if value is None else value.select(chosen) if name == "limits" else value[chosen]
                          for name, value in values.items()})

    def moved(self, displacement):
        """Positions (m, 3) [m] after nodal increments (N, 3) [m]."""
        if displacement is None:
            return self.position
        return self.position + np.einsum("ca,cai->ci", self.weight, displacement[self.node])


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
    included: (n,) bool, points that are not deactivated."""

    position: np.ndarray
    half: np.ndarray
    volume: np.ndarray
    included: np.ndarray

    @classmethod
    def of(cls, points, volume, basis):
        """Domains of `points` of initial `volume` (n,) [m³] with a `basis` "gimp" or "mpm"."""
        half = points.half_width if basis == "gimp" else np.zeros_like(points.half_width)
        included = np.ones(len(points), bool) if points.inactive is None else ~points.inactive
        return cls(points.position, half, volume, included)


def find_corners(domains, pressure, places, grid, active, body, surface, reach, history, expected, limits=None):
    """Contact points within `reach` (Reach) of the surface of `body` (a BodyState).

    domains: Domains; pressure: (n,) p_f E [N/m³] of its contact with each; places: Places; active: (N,) bool, nodes that
    carry mass; history: ContactHistory; expected: nodal increments (N, 3) [m] (None: held soil) and pose of the body
    from which the step starts to iterate; limits: PointLimits of an interface of clay (`hybrid.contact.interface`).
    """
    found = _within_reach(domains, places, grid.collapsed, body, surface, reach, history)
    if limits is not None:
        begins = limits.tension > 0.0 and not anywhere([len(history.point)])
        found["before"] = _before_body(found, domains, body, surface, begins)
    node, weight = _interpolation(found["position"], grid.axes, active)
    use = np.flatnonzero(weight.any(axis=1))
    use = use[np.lexsort((found["place"][use], found["point"][use]))]
    found = {name: values[use] for name, values in found.items()}
    point, place = found["point"], found["place"]
    normal = found["normal"]
    area = places.area(place, domains.half[point], domains.volume[point]) * places.facing(place, normal)
    if not domains.half.any():
        area = area / 2         # all eight corners of a point coincide: they share its stiffness
    start = (found["position"] - body.position) @ body.rotation
    found["limits"] = place_limits(limits, found, area, domains, places, found.pop("before", None))
    del found["normal"], found["opened"]
    corners = Corners(start=start, node=node[use], weight=weight[use], stiffness=pressure[point] * area, **found)
    is_open = ~corners.touching
    corners.anchor[is_open], corners.side[is_open] = predicted_contact_points(
        corners.position[is_open], corners.moved(expected[0])[is_open], body, expected[1], surface,
        corners.clearance[is_open])
    return corners


def _within_reach(domains, places, collapsed, body, surface, reach, history):
    """Contact points within reach, {name: values}: those of the history, carried by the grid, and new ones."""
    _, normal, distance = _gaps_in_space(history.position, collapsed, body, surface, np.inf)
    within = np.abs(distance) <= reach.at(history.position, normal, body)
    followed = (within | history.touching | history.opened) & domains.included[history.point]
    new = _new_points(domains, places, collapsed, body, surface, reach, history.point * len(places) + history.place)
    if not anywhere([len(history.point)]):      # the run begins, maybe with an overlap that is meant
        del new["rest"]
    old = {name: getattr(history, name)[followed]
           for name in ("point", "place", "position", "touching", "anchor", "side", "rest", "opened")}
    known = old["side"].any(axis=1)[:, None]    # near a rim another side of the body may be closer by now
    old |= {"clearance": distance[followed], "normal": np.where(known, old["side"] @ body.rotation.T, normal[followed])}
    return {name: np.concatenate([values, new.get(name, np.zeros((len(new["point"]), *values.shape[1:]), values.dtype))])
            for name, values in old.items()}


def _before_body(found, domains, body, surface, begins):
    """(m,) bool, whether contact points `found` {name: values} lie before the body's surface, not beside its edges. Where a
    run `begins`, those close to it are bonded: their springs start without force."""
    y, normal = (found["position"] - body.position) @ body.rotation, found["normal"] @ body.rotation
    before = lie_before(y, normal, surface.tree)
    if begins:
        close = before & (np.abs(found["clearance"]) <= ATTACHED * domains.half[found["point"]].min(axis=1))
        found["touching"] |= close
        found["rest"] = np.where(close, np.maximum(found["clearance"], 0.0), found["rest"])
        found["side"][close], found["anchor"][close] = normal[close], y[close]
    return before


def distances(y, surface, reach=np.inf):
    """Signed distances (m,) [m] of positions y (m, 3) in the body frame from the surface, inf beyond `reach` [m]; outside
    lower bounds of what a point has to move to touch it. And the outward normals there (m, 3)."""
    out, normal = np.empty(len(y)), np.zeros((len(y), 3))
    _distances(np.ascontiguousarray(y), reach, surface.tree, out, normal)
    return np.where(out > 0.0, out / surface.tree.patches.steepness, out), normal


def _new_points(domains, places, collapsed, body, surface, reach, known):
    """Contact points within reach other than those `known` (k,) from the history, {name: values}.

    The search narrows from domains near the body's bounding box to groups of places (faces of a domain) within reach,
    then to the places themselves. Places that do not look at the body have no stiffness and are left out.
    """
    farthest = reach.farthest(body, surface.radius)
    point = _near(domains, collapsed, body, surface, farthest)
    groups, each = places.offset.shape[:2]
    point, group = np.repeat(point, groups), np.tile(np.arange(groups), len(point))
    half = np.where(collapsed, 0.0, domains.half[point])
    middle = domains.position[point] + places.centre[group] * half
    size = np.linalg.norm(places.extent[group] * half, axis=1)
    middle, normal, distance = _gaps_in_space(middle, collapsed, body, surface, farthest + size.max(initial=0.0))
    close = np.flatnonzero((distance <= reach.at(middle, normal, body) + size)
                           & places.group_may_face(group, normal))
    point, number = np.repeat(point[close], each), (each * group[close, None] + np.arange(each)).ravel()
    fresh = ~np.isin(point * len(places) + number, known)   # the grid has carried the others away from their domain
    point, number = point[fresh], number[fresh]
    position = domains.position[point] + places.flat[number] * domains.half[point]
    position, normal, distance = _gaps_in_space(position, collapsed, body, surface, farthest)
    stay = np.flatnonzero((distance <= reach.at(position, normal, body)) & (places.facing(number, normal) > 0.0))
    return {"point": point[stay], "place": number[stay], "position": position[stay], "clearance": distance[stay],
            "normal": normal[stay], "rest": np.minimum(distance[stay], 0.0)}


def _near(domains, collapsed, body, surface, reach):
    """Numbers (k,) of the domains whose bounding sphere is within `reach` [m] of the body's bounding box."""
    near = np.zeros(len(domains.position), np.bool_)
    _mark(_in_section(domains.position, collapsed, body), np.where(collapsed, 0.0, domains.half), body.position,
          body.rotation, surface.lower - reach, surface.upper + reach, near)
    return np.flatnonzero(near & domains.included)


def _gaps_in_space(position, collapsed, body, surface, reach):
    """Positions (m, 3) [m] in the plane of the body's section, normals of the body there (m, 3) in space, and signed
    distances (m,) [m], inf beyond `reach`."""
    position = _in_section(position, collapsed, body)
    distance, normal = distances((position - body.position) @ body.rotation, surface, reach)
    return position, normal @ body.rotation.T, distance


def _in_section(position, collapsed, body):
    """Positions (m, 3) [m] moved along the collapsed axes to the body's centre of mass."""
    return np.where(collapsed, body.position, position) if np.any(collapsed) else position


def _interpolation(place, axes, active):
    """Nodes and hat functions (m, 8) at places (m, 3) [m].

    The weight of nodes without mass is distributed over the others in proportion, so that no force is lost; a corner
    all of whose nodes are without mass has zero weights.
    """
    node, weight = np.zeros((len(place), 8), np.int64), np.zeros((len(place), 8))
    _hats(place, *axes, node, weight)
    weight[~active[node]] = 0.0
    sums = weight.sum(axis=1, keepdims=True)
    return node, np.divide(weight, sums, out=np.zeros_like(weight), where=sums > 0)


def overlap(domains, grid, body, surface):
    """Largest overlap [m] of a domain's corner with a body at its committed pose, and the number of corners inside."""
    near = _near(domains, grid.collapsed, body, surface, 0.0)
    position = domains.position[near, None] + CORNERS.flat * domains.half[near, None]
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


@njit(cache=True)
def _distances(y, reach, tree, out, normal):
    for n in range(len(y)):
        triangle, feature, _, _, out[n] = closest((y[n, 0], y[n, 1], y[n, 2]), reach, tree, NO_SIDE)
        if triangle >= 0:
            for i in range(3):
                normal[n, i] = tree.normals[triangle, feature, i]


@njit(cache=True)
def _hats(place, x_axis, y_axis, z_axis, node, weight):
    first, second = np.empty(3, np.int64), np.empty(3)
    for n in range(len(place)):
        for axis in range(3):
            nodes = x_axis if axis == 0 else (y_axis if axis == 1 else z_axis)
            first[axis], second[axis] = 0, 0.0
            if len(nodes) > 1:
                first[axis] = find_cell(place[n, axis], nodes)
                second[axis] = min(hat(place[n, axis], first[axis] + 1, nodes), 1.0)
        for a in range(8):
            w, v = 1.0, 0
            for axis in range(3):
                upper = (a >> (2 - axis)) & 1
                w *= second[axis] if upper else 1.0 - second[axis]
                size = len(x_axis) if axis == 0 else (len(y_axis) if axis == 1 else len(z_axis))
                v = v * size + min(first[axis] + upper, size - 1)
            node[n, a], weight[n, a] = v, w
