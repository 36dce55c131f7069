"""Which contact points bear the interface of others between clay and a body.

The surface of the soil is made of steps. A few contact points at their tips touch a body: they bear the interface of
the faces around them, as far as these are part of the surface and no farther from the body than a domain is high. One
that parts from the body within the step bears nothing in it, and where soil flows along a body many of those that are
hardly pressed do; so the nearest ones share a face by the forces that press them. Clay that is sheared far parts into
layers, faces of each of which are exposed: where they cover the body more than once, all of them count for less.
"""

from dataclasses import replace

import numpy as np
from scipy.sparse import coo_matrix
from scipy.spatial import cKDTree

from hybrid.runtime.comm import gathered, offset

BEFORE = 0.5    # half-widths before a face, where the domain of a point that covers it lies
AROUND = 4.0    # widths of a domain up to which a contact point bears the interface of others
BEARERS = 4     # contact points without a bond among which a face shares its interface, by the forces that press them
TURN = 0.5      # largest difference of the normals there: beside a rounded edge the soil is away from the body
SPARE = 1.05    # layers that count as one: of a single one places are not spread evenly
TINY = 1e-30    # [m³], area times overlap, of a contact point that nothing presses


def carried_by_each(found, carried, domains, places, most, layers):
    """Function that gives the sums (m,) of the values (m,) of all contact points that each of them carries; carried: (m,)
    bool, those that another may carry, of this process or another one; most: number of points that share the value of one;
    layers: of Cover, None where it does not count in how many the points lie."""
    if places.at_corners:
        return lambda values: values
    order = own = ...
    if domains.number is not None:
        found, domains, order, own = _of_all_processes(found, domains)
    shares = _shares(found, gathered(carried)[order], domains, places, most, layers)
    return lambda values: (shares @ gathered(values)[order])[own]


def _of_all_processes(found, domains):
    """Contact points of all processes, by the numbers of their points, and the domains that they are on; their order among
    those of one process after the other; and which (m,) of them are those of this process."""
    point = found["point"]
    number, place = gathered(domains.number[point]), gathered(found["place"])
    order = np.lexsort((place, number))
    own = np.argsort(order)[offset(len(point)):][:len(point)]
    _, first, point_of_all = np.unique(number[order], return_index=True, return_inverse=True)
    position, half = (gathered(values[point])[order][first] for values in (domains.position, domains.half))
    found = {name: gathered(found[name])[order]
             for name in ("place", "position", "normal", "clearance", "touching", "pressed", "area")}
    return found | {"point": point_of_all}, replace(domains, position=position, half=half), order, own


def _shares(found, carried, domains, places, most, layers):
    """Sparse matrix (m, m): the share of the interface of each contact point, its column, that each bears, its row;
    carried: (m,) bool, those that another may carry; most, layers: as in `carried_by_each`."""
    m, half = len(carried), domains.half[found["point"]]
    height = 2 * np.einsum("ci,ci->c", np.abs(found["normal"]), half)
    touching = np.flatnonzero(found["touching"])
    near = np.flatnonzero((found["clearance"] < height) & carried & ~found["touching"])
    bearer, share, of = touching, np.ones(len(touching)), touching
    if len(touching) and len(near):
        near = near[_exposed(found, near, domains, places)]
        width = AROUND * 2 * half[touching][:, np.unique(places.axis)].max()     # not that of a slice in plane strain
        others = _divided(found, near, touching, width, min(most, len(touching)))
        bearer, share, of = (np.concatenate(pair) for pair in zip((bearer, share, of), others))
    if layers is not None and len(of):
        share = share / _excess(found, np.unique(of), layers)[of]
    alone = np.setdiff1d(np.arange(m), of)
    bearer, share, of = (np.concatenate(pair) for pair in ((bearer, alone), (share, np.ones(len(alone))), (of, alone)))
    return coo_matrix((share, (bearer, of)), shape=(m, m)).tocsr()


def _excess(found, chosen, layers):
    """(m,) factor, 1 or more, by which `chosen` contact points (k,) cover the surface of the body too often around each of
    them; layers: of Cover."""
    excess, normal = np.ones(len(found["point"])), found["normal"][chosen]
    closest_point = found["position"][chosen] - found["clearance"][chosen, None] * normal
    excess[chosen] = np.maximum(1.0, layers(closest_point, normal, found["area"][chosen]) / SPARE)
    return excess


def _divided(found, near, touching, width, count):
    """(bearers, shares, of which of `near`), each (k,): the `count` closest of `touching` points within a `width` [m] bear
    shares of a point in proportion to the forces that press them."""
    place = np.concatenate([found["position"], width / TURN * found["normal"]], axis=1)
    distance, index = cKDTree(place[touching]).query(place[near], k=count, distance_upper_bound=width)
    distance, index = distance.reshape(-1, count), index.reshape(-1, count)
    reached = np.isfinite(distance)
    bearer = touching[np.where(reached, index, 0)]
    force = np.where(reached, np.maximum(found["pressed"][bearer], TINY), 0.0)
    row, column = np.nonzero(reached)
    return bearer[row, column], force[row, column] / force.sum(axis=1)[row], near[row]


def _exposed(found, near, domains, places):
    """(k,) bool, whether no other domain lies before the faces on which contact points `near` (k,) are."""
    group = places.group_of(found["place"])
    faces, face = np.unique(found["point"][near] * len(places) + group[near], return_inverse=True)
    point, group = faces // len(places), faces % len(places)
    half = domains.half[point]
    before = domains.position[point] + (places.centre[group] + BEFORE * places.normal[group]) * half
    others = np.unique(found["point"])
    scale = domains.half[others].max(axis=0)
    _, index = cKDTree(domains.position[others] / scale).query(before / scale, k=min(3, len(others)), p=np.inf)
    other = others[index.reshape(len(point), -1)]
    within = (np.abs(before[:, None] - domains.position[other]) < domains.half[other]).all(axis=2)
    return ~(within & (other != point[:, None])).any(axis=1)[face]
