"""Contact of a body with level held ground, or a straight stretch of it, at places on the body instead of on the ground,
where it does not lie on a curved face.

    F = Σ k a f(y)      over places of the body's faces, edges and corners (`hybrid.contact.samples`), f the law of
                        `hybrid.contact.law` against the ground, a rigid block at rest

Points of the ground cannot see an edge or a corner that comes down between them, and take the normals of the faces beside
it: a cube that fell on its edge was pushed sideways and gained 30 % of its energy, the more the smaller the cells, and one
that was to slide on its edge without friction stuck. Against the ground's own plane the force is upright, and follows from
a potential. A curved face rolls on points of the ground more evenly than on places of its own
(`hybrid.contact.contact_pair`), so a body that lies on nothing else is left to these.

`GroundPair` does what ContactPair does (`hybrid.contact.pair`), as long as all of the body is over one stretch of the
ground: its ends, and what is beside it, are left to points of the ground too. Where several processes run, the first one
has all places.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hybrid.contact import assembly, body_to_body
from hybrid.contact.body_to_body import PairContact, Side
from hybrid.contact.law import Coulomb
from hybrid.contact.pair import Pair
from hybrid.contact.samples import BodyPlaces
from hybrid.contact.soil_to_body import PointContact
from hybrid.runtime import ranks
from hybrid.runtime.comm import total
from hybrid.state import ContactHistory

AT_REST = np.zeros(3), np.eye(3)    # pose of level ground
OF_BODY = -1                        # number of the soil point in the history of a place on the body
FLUSH = 1e-6        # of a stretch: a body that ends with it is over it
LOWEST = 1.6e-3                     # of the spacing: height over the lowest place up to which a body stands on others too
ROLLS = np.cos(np.radians(8.0))     # of a curved face that lies on the ground: between its normal there and downwards


@dataclass(frozen=True)
class PlacesOverPlane:
    """All places of a body, of which those near the plane z = top [m] of the ground's frame are found by their height."""

    places: BodyPlaces
    top: float
    first_edge: int = 0     # all press on the nearest side of the ground alone

    def near(self, turn, way, surface, reach):
        """Places at most `reach` [m] above the plane, those below it whatever their depth; arguments as in Samples.near."""
        height = self.places.point @ turn[2] + way[2] - self.top
        chosen = height <= reach
        return BodyPlaces(*(values[chosen] for values in self.places._replace(clearance=height)))


@dataclass(frozen=True, eq=False)
class Stretch:
    """A straight stretch of the ground, or all of it: side: places of a body, a, on the ground, b; low, high: (3,) [m] its
    ends in its own frame, whose z is upright on it; pose: (origin (3,) [m], rotation (3, 3)) of that frame in space; within:
    (2, 2) [m] its ends along x and y in space, where these are no rectangle in its frame."""

    side: Side
    low: np.ndarray
    high: np.ndarray
    pose: tuple = AT_REST
    within: np.ndarray | None = None

    def contains(self, place, collapsed):
        """Whether all places (V, 3) [m] are over it."""
        slack = FLUSH * (self.high - self.low)
        if self.within is not None:
            low, high = self.within + np.array([-slack[:2], slack[:2]])
            return bool(((place[:, :2] > low) & (place[:, :2] < high)).all())
        place = (place - self.pose[0]) @ self.pose[1]
        return bool(((place > self.low - slack) & (place < self.high + slack) | collapsed)[:, :2].all())


@dataclass(frozen=True)
class HeldGround:
    """Held ground under a body: stretches: tuple of Stretch; stiffness: k [N/m³]; collapsed: (3,) bool axes; spacing: [m] of
    the places; faces: (n, k) triangles of the body at the place of each number, -1 for none, None where no part of the
    surface is told apart; surface_points: SurfacePoints of a body with curved faces, else None."""

    stretches: tuple
    stiffness: float
    collapsed: np.ndarray
    spacing: float
    faces: np.ndarray | None = None
    surface_points: "SurfacePoints | None" = None

    def triangles(self, number, down, surface):
        """(m,) triangle at places of these numbers, of several the one that looks most along `down` (m, 3) in the body's
        frame."""
        faces = self.faces[number]
        looks = np.einsum("mki,mi->mk", surface.normals[faces], down)
        return np.take_along_axis(faces, np.where(faces < 0, -np.inf, looks).argmax(axis=1)[:, None], axis=1)[:, 0]

    def under(self, body, *poses):
        """The Stretch that all of a RigidBody is over at poses, where it does not lie on curved faces alone; else None."""
        for stretch in self.stretches:
            if all(stretch.contains(position + body.surface.vertices @ rotation.T, self.collapsed)
                   for position, rotation in poses):
                up = stretch.pose[1][:, 2]
                return stretch if all(self._rolls_not(up @ rotation) for _, rotation in poses) else None
        return None

    def _rolls_not(self, up):
        """Whether none of the lowest places is on a curved face that looks down, or one of them on no curved face at all;
        up: (3,) in the body's frame. The tip of a cone on its side, and a rim, are on curved faces."""
        if self.surface_points is None:
            return True
        height = self.surface_points.point @ up
        lowest = self.surface_points.curved[height <= height.min() + LOWEST * self.spacing]
        return not (lowest @ -up > ROLLS).any() or not lowest.any(axis=(1, 2)).all()


class SurfacePoints(NamedTuple):
    """Points (n, 3) [m] all over a body, on curved faces so many that normals of neighbours differ by a few degrees, and
    normals (n, 2, 3) of the curved faces there, 0 where there is none."""

    point: np.ndarray
    curved: np.ndarray


@dataclass(frozen=True)
class PlaceContact(PointContact):
    """The PointContact of places on a body; found: PairContact on the ground."""

    found: PairContact | None = None


class GroundPair(Pair):
    """A body and its places near a stretch of the ground."""

    def __init__(self, body, stretch, state, history, reach, expected):
        """body: RigidBody with its HeldGround; stretch: Stretch of it; state: BodyState; history: ContactHistory, whose
        `place` numbers places of the body and whose anchors are in space; reach: Reach; expected: pose to which the body is
        predicted to move."""
        ground, self._ground = body.ground, stretch.pose
        origin, turn = stretch.pose
        if len(history.point) and history.point[0] != OF_BODY:
            history = ContactHistory.empty()
        near = reach.farthest(state, body.radius) if ranks.rank() == 0 else -np.inf
        super().__init__(body, body_to_body.begin(
            stretch.side, (state.pose, stretch.pose), (expected, stretch.pose), near,
            (history.place, (history.anchor - origin) @ turn, history.rest),
            ground.stiffness, Coulomb(body.friction, body.tangential), ground.collapsed))

    def evaluate(self, displacement, pose):
        found = self.points.evaluate((pose, self._ground))
        m, normal = len(found.active), -found.normal
        side, triangle = normal @ pose[1], np.zeros(m, np.int64)
        if self.body.parts:
            triangle = self.body.ground.triangles(self.points.places.number[found.active], side, self.body.surface)
        return PlaceContact(
            active=found.active, gap=found.gap, normal=normal, force=-found.force, tangent=found.tangent,
            turning=np.zeros((m, 3, 3)), ramp=np.zeros((m, 3, 3)), arm=found.arm_a, slip=found.slip,
            anchor=np.zeros((m, 3)), side=side, pressure=np.einsum("mi,mi->m", found.force, normal), triangle=triangle,
            stored=np.array([found.energy]), lost=np.array([found.dissipated]),
            rest=np.zeros(m), opened=np.zeros(m, bool), found=found)

    def springs(self, contact):
        return float(np.sqrt(total([contact.found.springs**2])))

    def add_residual(self, contact, force):
        return assembly.add_residual(contact, None, None)

    def add_tangent(self, contact, pattern, values, uw, wu, kind=assembly.Tangent.CONSISTENT):
        return total([contact.found.stiffness()[:6, :6]])

    def tunnelled(self, contact, displacement, pose, depth):
        return int(total([self.points.passed(contact.found, (pose, self._ground), depth)]))

    def commit(self, contact, displacement):
        number, anchor, rest = self.points.history(contact.found)
        m, (origin, turn) = len(number), self._ground
        anchor = origin + anchor @ turn.T
        return ContactHistory(np.full(m, OF_BODY), number, anchor, np.ones(m, bool), anchor, np.zeros((m, 3)), rest)


def of_soil(history):
    """A ContactHistory of soil points as it is; of places on the body, none."""
    return ContactHistory.empty() if len(history.point) and history.point[0] == OF_BODY else history
