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

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np

from hybrid.contact.first_contact import predicted_contact_points
from hybrid.contact.interface import ATTACHED, EVERYWHERE, NONE, PlaceLimits, lie_before, on_faces, place_limits
from hybrid.contact.search import gaps_in_space, new_points
from hybrid.runtime.comm import anywhere
from hybrid.runtime.jit import njit
from hybrid.soil.basis import find_cell, hat

# Half-widths of its domain that an open point is behind its face: farther behind it is placed afresh where soil has turned
SUNK = 0.1


class SoilSurface(NamedTuple):
    """Soil that bodies may touch in an increment: Domains of its points, their Grid, and `active` (N,) bool, the nodes that
    carry mass."""

    domains: object
    grid: object
    active: np.ndarray


@dataclass(frozen=True)
class ContactPoints:
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
    limits: PlaceLimits of the interface, empty where friction alone acts; shared: function of interface.place_limits
    outward: (m, 3) normals of the soil's faces that the points are on, in space; None where these are not known
    facet: (m,) triangle that a point is held to, -1 for those that find theirs; None where none is held
    sticking: (m,) bool, points whose shear has no limit (`hybrid.contact.reversals`); None where there are none
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
    shared: Callable | None = None
    outward: np.ndarray | None = None
    facet: np.ndarray | None = None
    sticking: np.ndarray | None = None

    def __len__(self):
        return len(self.point)

    def select(self, chosen):
        """The contact points of a mask (m,) bool."""
        values = {field.name: getattr(self, field.name) for field in fields(self)} | {"shared": None}
        return ContactPoints(**{
            name: value if value is None else value.select(chosen) if name == "limits" else value[chosen]
            for name, value in values.items()})

    def moved(self, displacement):
        """Positions (m, 3) [m] after nodal increments (N, 3) [m]."""
        if displacement is None:
            return self.position
        position = self.position.copy()
        _move(self.node, self.weight, displacement, position)
        return position


def find_contact_points(soil, body, state, history, reach, expected, limits=None, begins=False):
    """ContactPoints within `reach` (Reach) of the surface of a RigidBody.

    soil: SoilSurface; state: BodyState; history: ContactHistory; expected: nodal increments (N, 3) [m] (None: held soil)
    and pose of the body from which the step starts to iterate; limits: PointLimits of an interface of clay
    (`hybrid.contact.interface`); begins: whether the run does, in which points close to the body are bonded to it.
    """
    domains, grid, active = soil
    places, surface = body.places, body.surface
    found = _within_reach(domains, places, grid.collapsed, state, surface, reach, history, begins)
    assert grid.nodes is None or grid.layers_for(found["position"]) <= grid.layers, "contact in cells of another process"
    if begins and limits is not None and limits.tension > 0.0:
        _bond(found, domains, state, surface, limits.sharp)
    node, weight = _interpolation(found["position"], grid.axes, active)
    use = np.flatnonzero(weight.any(axis=1))
    use = use[np.lexsort((found["place"][use], found["point"][use]))]
    found = {name: values[use] for name, values in found.items()}
    point, place = found["point"], found["place"]
    normal = found["normal"]
    area = places.area(place, domains.half[point],
                       domains.volume[point]) * domains.projected_share(places, point, place, normal)
    if not domains.half.any():
        area = area / 2         # all eight corners of a point coincide: they share its stiffness
    start = (found["position"] - state.position) @ state.rotation
    extent = np.where(grid.collapsed[:, None], EVERYWHERE, grid.extent)
    found["limits"], found["shared"] = place_limits(limits, found, area, domains, places, state, surface, extent)
    del found["normal"], found["opened"]
    if domains.ground is None and not places.at_corners:
        found["outward"] = places.normal[places.group_of(place)]
    stiffness = body.contact_pressure[point] * area
    if body.soft_edges is not None:
        stiffness *= body.soft_edges.shares(start)
    points = ContactPoints(start=start, node=node[use], weight=weight[use], stiffness=stiffness, **found)
    is_open = ~points.touching
    points.anchor[is_open], points.side[is_open] = predicted_contact_points(
        points.position[is_open], points.moved(expected[0])[is_open], state, expected[1], surface,
        points.clearance[is_open])
    return points


def _within_reach(domains, places, collapsed, body, surface, reach, history, begins):
    """Contact points within reach, {name: values}: those of the history, carried by the grid, and new ones. In soil that has
    turned, one that is open and has been carried far behind its face is placed afresh: faces keep the directions of
    space, so that where soil turns with a body those that come to look at it would be where they were before."""
    normal, distance = _of_history(history, collapsed, body, surface, reach.farthest(body, surface.radius))
    within = np.abs(distance) <= reach.at(history.position, normal, body)
    holds = history.touching | history.opened
    stays = holds | (domains.sunk(history.point, history.place, history.position, places) <= SUNK)
    stays[~stays] = ~domains.turned(history.point[~stays])
    followed = (within | holds) & stays & domains.included[history.point]
    known = (history.point * len(places) + history.place)[stays]
    new = new_points(domains, places, collapsed, body, surface, reach, known)
    if begins and not anywhere([len(history.point)]):       # not in place: an overlap is meant
        del new["rest"]
    old = {name: getattr(history, name)[followed]
           for name in ("point", "place", "position", "touching", "anchor", "side", "rest", "opened")}
    known = old["side"].any(axis=1)[:, None]    # near a rim another side of the body may be closer by now
    old |= {"clearance": distance[followed], "normal": np.where(known, old["side"] @ body.rotation.T, normal[followed])}
    return {name: np.concatenate([values, new.get(name, np.zeros((len(new["point"]), *values.shape[1:]), values.dtype))])
            for name, values in old.items()}


def _of_history(history, collapsed, body, surface, farthest):
    """Normals (m, 3) and signed distances (m,) [m] of the points of the history, inf where an open one is beyond
    `farthest`."""
    _, normal, distance = gaps_in_space(history.position, collapsed, body, surface, farthest)
    deep = np.flatnonzero((history.touching | history.opened) & np.isinf(distance))
    _, normal[deep], distance[deep] = gaps_in_space(history.position[deep], collapsed, body, surface, np.inf)
    return normal, distance


def _bond(found, domains, body, surface, sharp):
    """Bond contact points `found` {name: values} that lie before the faces of the body's surface, not beside its edges, and
    close to it: their springs start without force. Those that touch already stay as they are. sharp: of PointLimits."""
    y, normal = (found["position"] - body.position) @ body.rotation, found["normal"] @ body.rotation
    close = np.abs(found["clearance"]) <= ATTACHED * domains.half[found["point"]].min(axis=1)
    close &= lie_before(y, normal, surface.tree) & ~found["touching"]
    close[close] = on_faces(found["position"][close], found["normal"][close], body, surface, sharp)
    found["touching"] |= close
    found["rest"] = np.where(close, np.maximum(found["clearance"], 0.0), found["rest"])
    found["side"][close], found["anchor"][close] = normal[close], y[close]


def _interpolation(place, axes, active):
    """Nodes and hat functions (m, 8) at places (m, 3) [m].

    The weight of nodes without mass is distributed over the others in proportion, so that no force is lost; a point
    all of whose nodes are without mass has zero weights.
    """
    node, weight = np.zeros((len(place), 8), np.int64), np.zeros((len(place), 8))
    _hats(place, *axes, node, weight)
    weight[~active[node]] = 0.0
    sums = weight.sum(axis=1, keepdims=True)
    return node, np.divide(weight, sums, out=np.zeros_like(weight), where=sums > 0)


@njit(cache=True)
def _move(node, weight, displacement, position):
    for n in range(len(node)):
        for a in range(8):
            for i in range(3):
                position[n, i] += weight[n, a] * displacement[node[n, a], i]


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
