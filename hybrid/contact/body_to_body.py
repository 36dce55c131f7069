"""Contact of two rigid bodies: the law of `hybrid.contact.law` at places on the surface of each.

    F = ½ Σ k a f(y)  over places x = c_a + R_a X of body a, and the other way round
    y = R_bᵀ (x - c_b)  in the frame of body b

X never changes in the frame of its body, and the anchor of the tangential spring never changes in that of the other one: the
springs are objective. Force and moment on both bodies act at the same place, so that they cancel to round-off. With D =
∂F/∂x at fixed attitude, r_a = x - c_a, r_b = x - c_b and q = (δc_a, δφ_a, δc_b, δφ_b),

    δF = Q q,  Q = [D, -D r̃_a, -D, D r̃_b - F̃]
    K = [ Q;  r̃_a Q;  -Q;  -r̃_b Q ] + [ 0;  F̃ P_a;  0;  F̃ P_b ]      P_a q = r̃_a δφ_a,  P_b q = δc_a - r̃_a δφ_a - δc_b

A place presses only on a side of the other body that looks at it (`hybrid.body.closest.closest_facing`): no history is
needed to tell one side of a thin plate from the other, nor the face of a box from its flank.

Equations: FORMULATION (60) to (62).
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from hybrid.body.attitude import skews
from hybrid.body.closest import closest_facing
from hybrid.body.facet_tree import LANES, outside_bounds, tree_of_parts
from hybrid.body.surface import ContactSurface
from hybrid.contact import closest_points
from hybrid.contact.interface import NONE
from hybrid.contact.law import NOWHERE, ClosedPoints, ContactResponse, Coulomb, contact_law
from hybrid.contact.relative_path import FACING, predict, relative_path
from hybrid.contact.samples import BodyPlaces, Samples
from hybrid.contact.tunnelling import FINEST, FRACTIONS, pierced
from hybrid.runtime.jit import njit, prange

DEEPER = 1.1    # times its way in an increment beyond its distance, by which the overlap of a place may grow in it


@dataclass(frozen=True)
class Side:
    """One body's places against the surface of the other one: numbers a and b of the bodies in the model; beyond: [m] that
    places on faces may be behind a side that is not the nearest one (`closest_facing`)."""

    a: int
    b: int
    samples: Samples
    surface: ContactSurface
    beyond: float = 0.0

    def beyond_of(self, places):
        """(m,) [m] of BodyPlaces; 0 of those on edges."""
        return np.where(places.number < self.samples.first_edge, self.beyond, 0.0)


class PairContact(NamedTuple):
    """Places of one side in contact at trial poses, m of them, vectors in space: active (m,) among its BodyPlaces; force
    (m, 3) [N], minus that on body a; tangent (m, 3, 3) [N/m]; arms (m, 3) [m] from the centres of a and b; gap (m,) [m];
    normal (m, 3) of body b; energy, dissipated [J]; springs [N/m]; slip (m,). Once the state is accepted, the history has
    those in contact and those that have less overlap than they began with: kept (k,) among the BodyPlaces, anchor (k, 3)
    [m] in the frame of b, rest (k,) [m]."""

    active: np.ndarray
    force: np.ndarray
    tangent: np.ndarray
    arm_a: np.ndarray
    arm_b: np.ndarray
    gap: np.ndarray
    normal: np.ndarray
    energy: float
    dissipated: float
    springs: float
    slip: np.ndarray
    kept: np.ndarray
    anchor: np.ndarray
    rest: np.ndarray

    def residual(self):
        """(12,) [N, N m] on both bodies, about their centres."""
        return self._on_both(self.force)

    @property
    def shear(self):
        """Part (m, 3) [N] of the force along the surface."""
        return self.force - np.einsum("mi,mi->m", self.force, self.normal)[:, None] * self.normal

    @property
    def pressure(self):
        """Sum [N] of all forces across the surface."""
        return float(np.linalg.norm(self.force - self.shear, axis=1).sum())

    def friction(self):
        """(12,), the part of the residual that acts along the surface."""
        return self._on_both(self.shear)

    def _on_both(self, force):
        total = force.sum(axis=0)
        return np.concatenate([total, np.cross(self.arm_a, force).sum(axis=0),
                               -total, -np.cross(self.arm_b, force).sum(axis=0)])

    def stiffness(self):
        """K (12, 12) of the residual by (δc_a, δφ_a, δc_b, δφ_b)."""
        D, F, a, b = self.tangent, skews(self.force), skews(self.arm_a), skews(self.arm_b)
        Q = np.concatenate([D, -D @ a, -D, D @ b - F], axis=2)
        out = np.empty((12, 12))
        out[:3] = Q.sum(axis=0)
        out[3:6] = (a @ Q).sum(axis=0)
        out[6:9] = -out[:3]
        out[9:] = -(b @ Q).sum(axis=0)
        turning = (F @ a).sum(axis=0)
        out[3:6, 3:6] += turning
        out[9:, :3] += F.sum(axis=0)
        out[9:, 3:6] -= turning
        out[9:, 6:9] -= F.sum(axis=0)
        return out


NO_CONTACT = PairContact(
    np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros((0, 3, 3)), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0),
    np.zeros((0, 3)), 0.0, 0.0, 0.0, np.zeros(0, bool), np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros(0))


def relative(pose_a, pose_b, collapsed):
    """(turn (3, 3), way (3,) [m]): a point X of body a is at turn X + way in the frame of body b; collapsed: (3,) bool, axes
    along which the centres count as being at one place."""
    way = np.where(collapsed, 0.0, pose_a[0] - pose_b[0])
    return pose_b[1].T @ pose_a[1], pose_b[1].T @ way


@dataclass(frozen=True)
class SideStep:
    """Places of a Side near the other body, frozen during an increment.

    start: (m, 3) [m] in the frame of body b; touching: (m,) bool at the start; anchor: (m, 3) [m] of the history, else
    where the place is predicted to touch first; rest: (m,) [m] gap without force; stiffness: (m,) [N/m]; overlap: (m,) [m]
    at the start, of places on faces that do not touch the largest one of those that do; sticking: (m,) bool as in
    ContactPoints, None for none; closes: whether one that does not touch is predicted to
    """

    side: Side
    places: BodyPlaces
    start: np.ndarray
    touching: np.ndarray
    anchor: np.ndarray
    rest: np.ndarray
    stiffness: np.ndarray
    overlap: np.ndarray
    law: Coulomb
    collapsed: np.ndarray
    sticking: np.ndarray | None = None
    closes: bool = False

    def __len__(self):
        return len(self.start)

    def evaluate(self, poses):
        """PairContact at poses of all bodies."""
        if not len(self):
            return NO_CONTACT
        pose_a, pose_b = poses[self.side.a], poses[self.side.b]
        turn, way = relative(pose_a, pose_b, self.collapsed)
        y, outward, surface = self.places.point @ turn.T + way, self.places.normal @ turn.T, self.side.surface
        points = closest_points.ClosestPoints.empty(len(y))
        _project(y, outward, self.side.beyond_of(self.places), self.start, self.places.clearance, surface.radius,
                 *surface.tree.parts, points)
        touches, free = self.stiffness * (self.rest - points.gap) > 0.0, -self.places.depth
        # one that comes to look at a side deep in which it is, or loses sight of one, would gain energy from nothing
        moved = np.linalg.norm(y - self.start, axis=1)
        most = self.overlap + DEEPER * np.maximum(moved - np.maximum(self.places.clearance, 0.0), 0.0)
        steady = touches & (self.rest - points.gap > most)
        pressed = np.where(steady, points.gap + most, self.rest)
        rest = np.minimum(np.maximum(pressed, points.gap + free), free)
        active, kept = np.flatnonzero(touches), np.flatnonzero(touches | (rest < free))
        points = points.select(active)
        origin = np.where(self.touching[active, None], self.anchor[active], self.start[active])
        sticking = NOWHERE if self.sticking is None else self.sticking[active]
        closed = ClosedPoints(
            y[active], self.anchor[active], origin, self.stiffness[active], pressed[active], NONE, sticking, steady[active])
        found = ContactResponse.empty(len(active))
        contact_law(closed, points, self.law, surface.tree, found)
        R = pose_b[1]
        arm_b = y[active] @ R.T
        arm_a = self.places.point[active] @ pose_a[1].T
        anchor = y[kept]
        anchor[touches[kept]] = found.anchor
        return PairContact(
            active, found.force @ R.T, R @ found.tangent @ R.T, arm_a, arm_b, points.gap, found.side @ R.T,
            float(found.energy.sum()), float(found.dissipated.sum()), float(np.sqrt(np.sum(closed.stiffness**2))),
            found.slip, kept, anchor, rest[kept])

    def holding(self, chosen):
        """The same with `chosen` places in stick."""
        sticking = np.zeros(len(self), bool)
        sticking[chosen] = True
        return replace(self, sticking=sticking)

    def history(self, contact):
        """(number, anchor, rest) of the places that the next increment has to know."""
        return self.places.number[contact.kept], contact.anchor, contact.rest

    def passed(self, contact, poses, depth):
        """Number of places that the increment carried through the other body, or deeper than `depth` [m] into it on their
        way."""
        is_open = ~self.touching
        is_open[contact.active] = False
        turn, way = relative(poses[self.side.a], poses[self.side.b], self.collapsed)
        path = self.places.point @ turn.T + way - self.start
        checked = np.flatnonzero(is_open & (np.linalg.norm(path, axis=1) > np.maximum(self.places.clearance, depth)))
        if not len(checked):
            return 0
        start, path, surface = self.start[checked], path[checked], self.side.surface
        outside = closest_points.gaps_within_bounds(start + path, surface) >= 0.0
        passed = pierced(start, path, FINEST * depth, surface.tree) & outside
        for fraction in FRACTIONS:
            passed |= (closest_points.gaps_within_bounds(start + fraction * path, surface) < -depth) & outside
        return int(np.count_nonzero(passed))


def begin(side, poses, predicted, reach, history, stiffness, law, collapsed):
    """SideStep from committed `poses` of all bodies and those `predicted` at the end of the increment.

    reach: [m] of the search; history: (number, anchor, rest) of places in contact; stiffness: k/2 [N/m³]."""
    turn, way = relative(poses[side.a], poses[side.b], collapsed)
    places = side.samples.near(turn, way, side.surface, reach)
    start, m = places.point @ turn.T + way, len(places.number)
    number, known, rests = history
    anchor, rest, touching = start.copy(), -places.depth, np.isin(places.number, number)
    overlap = np.zeros(m)
    order = np.argsort(number)
    at = order[np.searchsorted(number[order], places.number[touching])]
    anchor[touching], rest[touching] = known[at], np.minimum(rests[at], rest[touching])
    closes = False
    if m:
        path = relative_path(poses[side.a], poses[side.b], predicted[side.a], predicted[side.b], collapsed)
        closes = predict(places.point, places.normal, side.beyond_of(places), places.depth, touching, path,
                       side.surface.radius, side.surface.tree, anchor, rest, overlap)
    return SideStep(side, places, start, touching, anchor, rest, stiffness * places.area, overlap, law, collapsed,
                    closes=closes)


def mean_normal_speed(begun, rates, poses, normals):
    """Mean speed [m/s] with which places of both SideStep that touch approach the other body, 0 where none does, and the
    sum of their stiffness [N/m]. rates: {number of a body: (velocity, spin)} in space, or their derivatives in time;
    normals: (m, 3) of each side, None: those of the places."""
    pressing = [one.touching & (one.overlap > 0.0) for one in begun]
    springs = np.concatenate([one.stiffness[own] for one, own in zip(begun, pressing)])
    speeds = np.concatenate([_normal_speeds(one, rates[one.side.a], rates[one.side.b], poses, along)[own]
                             for one, own, along in zip(begun, pressing, normals)])
    return (float(speeds @ springs / springs.sum()) if len(springs) else 0.0), float(springs.sum())


def closing_speed(begun, rates_a, rates_b, poses, dt):
    """Largest speed [m/s] at which places of a SideStep approach the other body that may touch it within `dt` [s]. rates:
    (velocity, spin) in space of both bodies."""
    if not len(begun.start):
        return 0.0
    speed = _normal_speeds(begun, rates_a, rates_b, poses)
    return float(np.max(speed[speed * 2.0 * dt > begun.places.clearance], initial=0.0))


def pressed_normals(begun, poses):
    """(m, 3) of the places of a SideStep, of those that touch across the surface of the other body: the normal of an edge is
    inclined to it, and of an edge that slides it has a part along the motion."""
    normals, contact = begun.places.normal @ poses[begun.side.a][1].T, begun.evaluate(poses)
    normals[contact.active] = -contact.normal
    return normals


def _normal_speeds(begun, rates_a, rates_b, poses, normals=None):
    """(m,) [m/s] of the places of a SideStep along `normals` (m, 3), or their own, relative to the other body."""
    (c_a, R_a), (c_b, _) = poses[begun.side.a], poses[begun.side.b]
    arm_a = begun.places.point @ R_a.T
    arm_b = arm_a + np.where(begun.collapsed, 0.0, c_a - c_b)
    moving = rates_a[0] + np.cross(rates_a[1], arm_a) - rates_b[0] - np.cross(rates_b[1], arm_b)
    return np.einsum("mi,mi->m", moving, begun.places.normal @ R_a.T if normals is None else normals)


@njit(cache=True, parallel=True)
def _project(y, outward, beyond, start, clearance, radius, arrays, patches, points):
    """Fill `points` (ClosestPoints) for places now at y (m, 3); beyond: (m,) [m] as in `closest_facing`."""
    gap, triangle, feature, closest_point, weights = points
    for lane in prange(LANES):
        tree = tree_of_parts(arrays, patches)
        for n in range(lane, len(y), LANES):
            x0, x1, x2 = y[n, 0] - start[n, 0], y[n, 1] - start[n, 1], y[n, 2] - start[n, 2]
            away = x0 * x0 + x1 * x1 + x2 * x2 < max(clearance[n], 0.0) ** 2
            if away or outside_bounds(y[n, 0], y[n, 1], y[n, 2], radius, tree):
                gap[n] = np.inf
                continue
            normal = outward[n, 0], outward[n, 1], outward[n, 2]
            t, f, x, w, g = closest_facing((y[n, 0], y[n, 1], y[n, 2]), normal, FACING, beyond[n], tree)
            triangle[n], feature[n], gap[n] = t, f, g
            for i in range(3):
                closest_point[n, i], weights[n, i] = x[i], w[i]
