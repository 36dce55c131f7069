"""Bodies that are in the soil from the start: the soil that they take is removed, and what is left touches them.

The share of soil in a domain that a body cuts is summed over samples, by the signed distance d of each,

    f = ½ + d / Σ |N_i| w_i,  0 <= f <= 1          w (3,) widths of a sample; exact for a plane across it

What is left are one or two boxes along the axis i with the largest |N_i| l_i: one at each end, as long as the volume of the
soil on that side of the body. So boxes meet the body like the columns of a histogram, plates thinner than a domain have
soil on both sides, and volume and mass are those that are left. Less than SLIVER of a domain is removed too.

The ends of the boxes follow the body in steps. Contact points on faces that the cut has exposed therefore start at the
surface of the body itself, overlapping it by what gives the pressure of the soil that was there,

    y = foot - N δ      δ = max(0, -N·σ N) / (p_f E)

Equations: FORMULATION (54).
"""

from dataclasses import dataclass, replace

import numpy as np
from numba import njit

from hybrid.body.closest import NO_SIDE, closest
from hybrid.body.rigid import with_stiffness
from hybrid.contact.corners import Domains, distances, overlap
from hybrid.grid.blocks import cells_of
from hybrid.runtime.comm import anywhere, maximum, minimum, total
from hybrid.runtime.errors import SceneError
from hybrid.setup.contact import section
from hybrid.soil.points import at_rest
from hybrid.soil.split_merge import select
from hybrid.state import ContactHistory, Population

OVERLAP = 0.1       # half-widths of a point that a body may overlap the soil at the start; contact bears that
SAMPLES = {True: 16, False: 6}      # along each axis of a domain, in a slice and in space
SLIVER = 0.05       # of a domain: less soil than that makes no point
UNCUT = 1e-3        # of a domain: less than that is not cut out
ONE_SIDE = 0.15     # of the soil on one side of a body: less on the other side belongs to a slope or a corner
TINY = 1e-300       # in place of zero in a denominator
CHUNK = 1 << 16     # samples or contact points at a time
OUTSIDE = 1e-3      # of a half-width: distance from a face at which it is seen what covers it


@dataclass(frozen=True)
class Taken:
    """Soil that a body takes: volume [m³] of the body in it, volume and mass [m³, kg] of soil removed, numbers of points
    removed and of points cut."""

    name: str
    inside: float
    volume: float
    mass: float
    removed: int
    cut: int

    def __str__(self):
        return (f"{self.name} is in place: it takes {self.volume:.4g} m³ of soil ({self.mass:.4g} kg), where "
                f"{self.inside:.4g} m³ of it lie in the ground; {self.removed} points removed, {self.cut} cut")


@dataclass(frozen=True)
class Boxes:
    """Domains along the axes: parent (n,) numbers of the points that they come from, increasing; position, half (n, 3)
    [m]."""

    parent: np.ndarray
    position: np.ndarray
    half: np.ndarray

    @property
    def volume(self):
        """(n,) [m³]."""
        return np.prod(2 * self.half, axis=1)

    def __getitem__(self, ids):
        return Boxes(self.parent[ids], self.position[ids], self.half[ids])


def starts_inside(body, motion, points, soil):
    """Whether a body starts deeper in the soil than contact bears. Raises SceneError where soil cannot be cut."""
    domains = Domains.of(points, soil.constants.volume, soil.basis)
    depth, count = overlap(domains, soil.grid, motion, body.surface)
    limit = OVERLAP * soil.grid.smallest_cell if soil.basis != "gimp" else OVERLAP * minimum(points.half_width)
    if depth <= limit and not _between_corners(body, motion, points, soil, limit):
        return False
    reason = ("the soil is held and is not cut" if soil.held else
              'points of soil.basis = "mpm" have no domains to cut' if soil.basis != "gimp" else
              'contact at the corners of domains does not follow a cut (body.contact = "faces")'
              if body.places.at_corners else
              "points of a user's law cannot be cut" if not hasattr(soil.law, "with_rows") else "")
    if reason:
        raise SceneError(f"body {body.name!r} overlaps the soil at the start: {count} corners of the points' domains lie "
                         f"up to {depth:.3g} m inside the body, limit {limit:.3g} m, and {reason}; set body.rest_on to "
                         "the height of the soil's surface, or raise body.position")
    return True


def _between_corners(body, motion, points, soil, limit):
    """Whether a body that no corner of a domain is inside of lies in the soil, as a plate thinner than domains does."""
    if soil.held or soil.basis != "gimp":
        return False
    surface, boxes = section(body, motion.rotation, soil.grid), _boxes(points)
    lowest = motion.position[2] - surface.extent(-motion.rotation[2])
    if lowest > maximum(points.position[:, 2] + points.half_width[:, 2]) - limit:
        return False
    near = _near(boxes, surface, motion, soil.grid.collapsed)
    return anywhere(_soil_shares(boxes[near], surface, motion, soil.grid.collapsed)[0] < 1.0 - SLIVER)


def put_in_place(soil, points, bodies, motions):
    """(Soil, Points, [ContactHistory] of each body, [Taken]) once the soil that `bodies`, with those that start inside
    alone, take is removed; bodies, motions: RigidBody and BodyState of all, None for a body that starts outside."""
    before, boxes, taken = _boxes(points), _boxes(points), []
    density = soil.constants.mass / soil.constants.volume
    for body, motion in zip(bodies, motions):
        if body is None:
            continue
        left, inside, cut = cut_out(boxes, section(body, motion.rotation, soil.grid), motion, soil.grid.collapsed)
        gone = (boxes.volume @ density[boxes.parent] - left.volume @ density[left.parent])
        taken.append(Taken(body.name, inside, float(total(boxes.volume) - total(left.volume)), gone,
                           len(np.setdiff1d(boxes.parent, left.parent)), cut))
        boxes = left
    if not len(boxes.parent):
        raise SceneError("the bodies take all of the soil; check body.position and the ends of the soil")
    soil, points = _cut_points(soil, points, boxes)
    stress = np.einsum("nii->ni", points.stress)
    histories = [ContactHistory.empty() if body is None else first_contact_points(
        with_stiffness(body, soil.law.young, soil.held), motion, soil, stress, before, boxes)
        for body, motion in zip(bodies, motions)]
    return soil, points, histories, taken


def _boxes(points):
    return Boxes(np.arange(len(points)), points.position, points.half_width)


def _cut_points(soil, points, boxes):
    """(Soil, Points at rest) of `boxes`, each with the density, the law and the stress of its point at its own height."""
    kept = select(Population(points, soil.constants, soil.law.rows), boxes.parent)
    share = boxes.volume / np.prod(2 * kept.constants.half_width, axis=1)
    constants = replace(kept.constants, position=boxes.position, half_width=boxes.half,
                        volume=kept.constants.volume * share, mass=kept.constants.mass * share)
    law, stress = soil.law.with_rows(kept.rows), np.einsum("nii->ni", kept.points.stress)
    if constants.geostatic_gradient is not None:
        rise = boxes.position[:, 2] - kept.points.position[:, 2]
        stress = stress + constants.geostatic_gradient * rise[:, None]
    new = at_rest(constants, stress, law.strain(stress))
    new.acceleration[:] = kept.points.acceleration
    return replace(soil, constants=constants, law=law), new


# ------------------------------------------------------------------ cutting


def cut_out(boxes, surface, motion, collapsed):
    """(Boxes left of `boxes` once the body is there, volume [m³] of the body in them, number of points cut).

    surface: ContactSurface of the body, in plane strain without its ends; motion: BodyState; collapsed: (3,) bool.
    """
    near = _near(boxes, surface, motion, collapsed)
    share, axes, ends = _soil_shares(boxes[near], surface, motion, collapsed)
    away = np.ones(len(boxes.parent), bool)
    changed = share < 1.0 - UNCUT
    away[near[changed]] = False
    cut, axes, ends = boxes[near[changed]], axes[changed], ends[changed]
    pieces, rest = [boxes[away]], np.arange(len(cut.parent))
    for turn in range(axes.shape[1]):       # the next axis where a box would have its centre in the body
        parts = [_ends(cut[rest], axes[rest, turn], ends[rest, turn], side) for side in (0, 1)]
        wrong = [_inside(part, surface, motion, collapsed) for part, _ in parts]
        again = np.unique(np.concatenate([ids[inside] for (_, ids), inside in zip(parts, wrong)]))
        last = turn == axes.shape[1] - 1
        pieces += [part[~inside if last else ~np.isin(ids, again)] for (part, ids), inside in zip(parts, wrong)]
        rest = rest[again]
    left = Boxes(*(np.concatenate([getattr(piece, name) for piece in pieces]) for name in ("parent", "position", "half")))
    left = left[np.argsort(left.parent, kind="stable")]
    return left, float(boxes[near].volume @ (1.0 - share)), len(np.intersect1d(cut.parent, left.parent))


def _ends(boxes, axis, ends, side):
    """(Boxes at the lower (side 0) or upper ends of `boxes` along `axis` (n,), of the shares `ends` (n, 2); their ids)."""
    merged = ends.min(axis=1) < ONE_SIDE * ends.max(axis=1)
    one = np.where(np.argmax(ends, axis=1) == side, ends.sum(axis=1), 0.0)
    part = np.where(merged, one, ends[:, side])
    ids = np.flatnonzero(part >= SLIVER)
    position, half, rows, i = boxes.position[ids].copy(), boxes.half[ids].copy(), np.arange(len(ids)), axis[ids]
    position[rows, i] += (2 * side - 1) * half[rows, i] * (1.0 - part[ids])
    half[rows, i] *= part[ids]
    return Boxes(boxes.parent[ids], position, half), ids


def _inside(boxes, surface, motion, collapsed):
    """(n,) bool, whether the centres of boxes are in the body."""
    return distances(_in_frame(boxes.position, motion, collapsed), surface)[0] < 0.0


def _in_frame(position, motion, collapsed):
    """Positions (n, 3) [m] in the frame of a body, along collapsed axes at its centre."""
    return (np.where(collapsed, motion.position, position) - motion.position) @ motion.rotation


def _near(boxes, surface, motion, collapsed):
    """Numbers of the boxes that the body may cut or contain."""
    size = np.linalg.norm(np.where(collapsed, 0.0, boxes.half), axis=1)
    y = _in_frame(boxes.position, motion, collapsed)
    ids = np.flatnonzero(((y > surface.lower - size[:, None]) & (y < surface.upper + size[:, None])).all(axis=1))
    return ids[distances(y[ids], surface)[0] < size[ids]]


def _soil_shares(boxes, surface, motion, collapsed):
    """Of each box: share (n,) of soil, axes (n, k) that are not collapsed, the one most normal to the body first, and
    shares (n, k, 2) of soil below and above the body along each of them."""
    deep, normal = distances(_in_frame(boxes.position, motion, collapsed), surface)
    across = np.where(collapsed, 0.0, boxes.half)
    axes = np.argsort(-np.abs(normal @ motion.rotation.T) * across - (across > 0) * 1e-300, axis=1, kind="stable")
    axes = axes[:, :3 - np.count_nonzero(collapsed)]
    inside = deep < -np.linalg.norm(across, axis=1)
    share, ends = np.where(inside, 0.0, 1.0), np.zeros((*axes.shape, 2))
    count = SAMPLES[bool(np.any(collapsed))]
    t = (2 * np.arange(count) + 1) / count - 1
    offset = np.stack([a.ravel() for a in np.meshgrid(*([0.0] if c else t for c in collapsed), indexing="ij")], axis=1)
    for ids in _chunks(np.flatnonzero(~inside), len(offset)):
        place = boxes.position[ids, None] + offset * boxes.half[ids, None]
        d, normal = distances(_in_frame(place.reshape(-1, 3), motion, collapsed), surface)
        width = np.repeat(2 * across[ids] / count, len(offset), axis=0)
        width = np.einsum("si,si->s", np.abs(normal @ motion.rotation.T), width)
        soil = np.clip(0.5 + d / np.maximum(width, TINY), 0.0, 1.0).reshape(len(ids), len(offset))
        share[ids] = soil.mean(axis=1)
        for turn, axis in enumerate(axes[ids].T):
            height = offset.T[axis]                         # (k, s) of each sample along the axis of its box
            middle = ((1.0 - soil) * height).sum(axis=1) / np.maximum((1.0 - soil).sum(axis=1), TINY)
            below = 0.5 * (1.0 + np.sign(np.round(middle[:, None] - height, 9)))
            ends[ids, turn] = np.stack([(soil * below).mean(axis=1), (soil * (1.0 - below)).mean(axis=1)], axis=1)
    return share, axes, ends


def _chunks(ids, each):
    """Parts of `ids` with about CHUNK items in all, `each` of them for an id."""
    return np.array_split(ids, max(1, -(-len(ids) * each // CHUNK)))


# ------------------------------------------------------------------ contact points on the faces that the cut exposes


def first_contact_points(body, motion, soil, stress, before, boxes):
    """ContactHistory of the contact points on faces exposed by the cut, touching the body with the stress of the soil.

    stress: (n, 3) [Pa], principal, of the points of `boxes`; before: Boxes of the soil without the body.
    """
    collapsed, places = soil.grid.collapsed, body.places
    old, new = _Cells(before, soil.grid), _Cells(boxes, soil.grid)
    face = places.normal[np.arange(len(places)) // places.offset.shape[1]]
    found = []
    for ids in _chunks(_close(boxes, body, motion, collapsed), len(places)):
        point, number = np.repeat(ids, len(places)), np.tile(np.arange(len(places)), len(ids))
        place = boxes.position[point] + places.flat[number] * boxes.half[point]
        beyond = place + OUTSIDE * face[number] * boxes.half[point]
        exposed = np.flatnonzero(old.contain(beyond) & ~new.contain(beyond))
        point, number, y = point[exposed], number[exposed], _in_frame(place[exposed], motion, collapsed)
        distance, normal = distances(y, body.surface)
        reached = np.abs(distance) < 2 * np.linalg.norm(np.where(collapsed, 0.0, before.half[boxes.parent[point]]), axis=1)
        in_space = normal @ motion.rotation.T
        stay = np.flatnonzero((places.facing(number, in_space) > 0.0) & reached)
        foot = np.empty((len(stay), 3))
        _feet(np.ascontiguousarray(y[stay]), body.surface.tree, foot)
        point, number, in_space = point[stay], number[stay], in_space[stay]
        principal = stress[point]
        if soil.constants.geostatic_gradient is not None:
            rise = motion.position[2] + foot @ motion.rotation[2] - boxes.position[point, 2]
            principal = principal + soil.constants.geostatic_gradient[point] * rise[:, None]
        squeezed = np.maximum(0.0, -np.einsum("ci,ci->c", in_space**2, principal)) / body.contact_pressure[point]
        found.append((point, number, foot - squeezed[:, None] * normal[stay], normal[stay]))
    point, number, y, side = (np.concatenate(column) for column in zip(*found))
    order = np.lexsort((number, point))
    y, side = y[order], side[order]
    return ContactHistory(point[order], number[order], motion.position + y @ motion.rotation.T, np.ones(len(y), bool), y,
                          side, np.zeros(len(y)))


def _close(boxes, body, motion, collapsed):
    """Numbers of the boxes within two of their sizes from the surface that soil touches."""
    size = 2 * np.linalg.norm(np.where(collapsed, 0.0, boxes.half), axis=1)
    y, surface = _in_frame(boxes.position, motion, collapsed), body.surface
    ids = np.flatnonzero(((y > surface.lower - size[:, None]) & (y < surface.upper + size[:, None])).all(axis=1))
    return ids[np.abs(distances(y[ids], surface)[0]) < size[ids]]


class _Cells:
    """Boxes by the cells of a grid that they lie in, each in one."""

    def __init__(self, boxes, grid):
        self.boxes, self.axes, self.collapsed = boxes, grid.axes, grid.collapsed
        self.lower, self.upper = grid.extent.T
        self.counts = [max(1, len(nodes) - 1) for nodes in grid.axes]
        cell = np.ravel_multi_index(cells_of(boxes.position, grid.axes).T, self.counts)
        self.order = np.argsort(cell, kind="stable")
        self.first = np.searchsorted(cell[self.order], np.arange(np.prod(self.counts) + 1))

    def contain(self, place):
        """(m,) bool, whether places (m, 3) [m] are in a box."""
        out = np.zeros(len(place), np.bool_)
        inside = (((place > self.lower) & (place < self.upper)) | self.collapsed).all(axis=1)
        cell = np.ravel_multi_index(cells_of(np.clip(place, self.lower, self.upper), self.axes).T, self.counts)
        half = np.where(self.collapsed, np.inf, self.boxes.half)
        _contained(place, cell, self.first, self.order, self.boxes.position, half, out)
        return out & inside


@njit(cache=True)
def _contained(place, cell, first, order, position, half, out):
    for n in range(len(place)):
        for k in range(first[cell[n]], first[cell[n] + 1]):
            b = order[k]
            out[n] = out[n] or (abs(place[n, 0] - position[b, 0]) <= half[b, 0] and
                                abs(place[n, 1] - position[b, 1]) <= half[b, 1] and
                                abs(place[n, 2] - position[b, 2]) <= half[b, 2])


@njit(cache=True)
def _feet(y, tree, foot):
    """Fill the points (n, 3) of the surface closest to y (n, 3), body frame."""
    for n in range(len(y)):
        _, _, x, _, _ = closest((y[n, 0], y[n, 1], y[n, 2]), np.inf, tree, NO_SIDE)
        for i in range(3):
            foot[n, i] = x[i]
