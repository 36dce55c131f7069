"""Contact of a body of plane faces with level held ground, at places on the body instead of on the ground.

    F = Σ k a f(y)      over places of the body's faces, edges and corners (`hybrid.contact.samples`), f the law of
                        `hybrid.contact.soil_to_body` against the ground, a rigid block at rest

Points of the ground cannot see an edge or a corner that comes down between them, and take the normals of the faces beside
it: a cube that fell on its edge was pushed sideways and gained 30 % of its energy, the more the smaller the cells. Against
the ground's own plane the force is upright, and follows from a potential. A curved face rolls on points of the ground more
evenly than on places of its own (`hybrid.contact.contact_pair`).

`GroundPair` does what ContactPair does. Where several processes run, the first one has all places.
"""

from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from hybrid.contact import assembly, body_to_body
from hybrid.contact.body_to_body import PairContact, Side
from hybrid.contact.soil_to_body import Coulomb, PointContact
from hybrid.runtime import ranks
from hybrid.runtime.comm import count, total
from hybrid.state import ContactHistory

AT_REST = np.zeros(3), np.eye(3)    # pose of the ground


@dataclass(frozen=True)
class Ground:
    """Level held ground under a body: side: places of the body, a, on the ground, b; stiffness: k [N/m³]; edge_triangle:
    (e,) triangle of the body beside each of its places on edges; collapsed: (3,) bool axes; spacing: [m] of the places."""

    side: Side
    stiffness: float
    edge_triangle: np.ndarray
    collapsed: np.ndarray
    spacing: float

    def triangles(self, number):
        """(m,) triangle of the body of places with these numbers."""
        pieces = self.side.samples.pieces
        found, first = np.searchsorted(pieces.first, number, side="right") - 1, pieces.first[-1] + 4**pieces.cuts[-1]
        on_edge = number >= first
        found[on_edge] = self.edge_triangle[number[on_edge] - first]
        return found


@dataclass(frozen=True)
class PlaceContact(PointContact):
    """The PointContact of places on a body; found: PairContact on the ground."""

    found: PairContact | None = None


class GroundPair:
    """A body and its places near the ground, frozen during a step."""

    def __init__(self, body, state, history, reach, expected):
        """body: RigidBody with its Ground; state: BodyState; history: ContactHistory, whose `place` numbers places of the
        body and whose anchors are in space; reach: Reach; expected: pose to which the body is predicted to move."""
        ground = body.ground
        self.body, self._ground = body, ground
        near = reach.farthest(state, body.radius) if ranks.rank() == 0 else -np.inf
        self._step = body_to_body.begin(ground.side, (state.pose, AT_REST), (expected, AT_REST), near,
                                        (history.place, history.anchor, history.rest), ground.stiffness,
                                        Coulomb(body.friction, body.tangential), ground.collapsed)
        self._triangle = ground.triangles(self._step.places.number)

    def evaluate(self, displacement, pose):
        """PlaceContact at a pose; displacement: None, as the ground is held."""
        found = self._step.evaluate((pose, AT_REST))
        m, normal = len(found.active), -found.normal
        return PlaceContact(
            active=found.active, gap=found.gap, normal=normal, force=-found.force, tangent=found.tangent,
            turning=np.zeros((m, 3, 3)), arm=found.arm_a, slip=found.slip, anchor=np.zeros((m, 3)), side=normal @ pose[1],
            pressure=np.einsum("mi,mi->m", found.force, normal), triangle=self._triangle[found.active],
            weights=np.zeros((m, 3)), energy=float(total([found.energy])), dissipated=float(total([found.dissipated])),
            rest=np.zeros(m), opened=np.zeros(m, bool), found=found)

    def springs(self, contact):
        """As in ContactPair."""
        return float(np.sqrt(total([contact.found.springs**2])))

    def add_residual(self, contact, force):
        """The body's residual (6,) [N, N m about its centre]."""
        return assembly.add_residual(contact, None, None)

    def add_tangent(self, contact, pattern, values, uw, wu, softening=True):
        """K_ww (6, 6)."""
        return total([contact.found.stiffness()[:6, :6]])

    def tunnelled(self, contact, displacement, pose, depth):
        """Number of places that the step carried through the ground."""
        return self._step.passed(contact.found, (pose, AT_REST), depth)

    def parted(self, contact):
        """As in ContactPair."""
        touching = self._step.touching.copy()
        before = count(touching)
        touching[contact.active] = False
        return before, count(touching)

    @contextmanager
    def bilateral(self):
        """Nothing changes: the ground under a body that lifts off is no soil that could follow it."""
        yield

    @contextmanager
    def sticking(self, chosen):
        """Context in which the shear of `chosen`, an index of places, has no limit."""
        step, mask = self._step, np.zeros(len(self._triangle), bool)
        mask[chosen] = True
        self._step = replace(step, sticking=mask)
        try:
            yield
        finally:
            self._step = step

    def share_interface(self, contact):
        """There is no interface to share."""
        return 0.0

    def restore_interface(self):
        """As `share_interface`."""

    def hold_facets(self, contact):
        """A place has no choice of facets."""
        return np.full(len(self._triangle), -1)

    def release_facets(self):
        """As `hold_facets`."""

    def facet_error(self, contact, displacement, pose):
        """As `hold_facets`."""
        return 0.0

    def commit(self, contact, displacement):
        """ContactHistory after acceptance."""
        number, anchor, rest = self._step.history(contact.found)
        m = len(number)
        return ContactHistory(np.zeros(m, np.int64), number, anchor, np.ones(m, bool), anchor, np.zeros((m, 3)), rest)
