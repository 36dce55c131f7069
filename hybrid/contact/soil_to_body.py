"""Contact of points on the soil's surface with a body: which of them press, and their forces by `hybrid.contact.law`.

A point presses where it overlaps the surface by more than at its rest, or where its bond pulls. One that an edge of the body
has left behind is open. Vectors of a PointContact are in the axes of space, those of the law in the body frame.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hybrid.contact import held_facets
from hybrid.contact.closest_points import CLOSED, closest_points
from hybrid.contact.law import NOWHERE, ClosedPoints, ContactResponse, Coulomb, contact_law
from hybrid.runtime.comm import largest, total
from hybrid.state import ContactHistory

BESIDE = 0.1    # cosine between the normals of two faces, of which one looks at the other from there on


@dataclass(frozen=True)
class PointContact:
    """Points in contact at a trial state; m of them; vectors in the axes of space unless stated otherwise.

    active: (m,) indices into ContactPoints; gap: (m,) [m], negative; normal: (m, 3) outward from the body
    force: (m, 3) [N], minus the force on the contact point
    tangent: (m, 3, 3) [N/m] ∂force/∂x_c at fixed attitude; turning: (m, 3, 3) [N/m] of it -p G, by which the pressure
    turns with the surface; ramp: (m, 3, 3) [N/m] of it, by which shear on the ramp of adhesion follows the pressure
    arm: (m, 3) [m] from the body's centre; slip: (m,) bool
    anchor: (m, 3) [m] body frame, the anchor of the history once the state is accepted; side: (m, 3) N, body frame
    pressure: (m,) p [N]; triangle: (m,) of the closest point
    stored: (m,) energy of the springs [J]; lost: (m,) friction work of the step [J]
    rest: of all ContactPoints, as there, once the state is accepted; opened: (m,) bool, whether the bond breaks in the step
    """

    active: np.ndarray
    gap: np.ndarray
    normal: np.ndarray
    force: np.ndarray
    tangent: np.ndarray
    turning: np.ndarray
    ramp: np.ndarray
    arm: np.ndarray
    slip: np.ndarray
    anchor: np.ndarray
    side: np.ndarray
    pressure: np.ndarray
    triangle: np.ndarray
    stored: np.ndarray
    lost: np.ndarray
    rest: np.ndarray
    opened: np.ndarray

    def __len__(self):
        return len(self.active)

    @property
    def shear(self):
        """Force (m, 3) [N] along the surface."""
        return self.force - np.einsum("ci,ci->c", self.force, self.normal)[:, None] * self.normal

    @cached_property
    def resultant(self):
        """Force (3,) [N] and moment about the body's centre (3,) [N m] of the soil on the body, as (6,)."""
        return total(np.concatenate([self.force, np.cross(self.arm, self.force)], axis=1))

    @cached_property
    def friction(self):
        """(6,), the part of the resultant that acts along the surface."""
        shear = self.shear
        return total(np.concatenate([shear, np.cross(self.arm, shear)], axis=1))

    @property
    def energy(self):
        """Energy stored in the springs of all processes [J]."""
        return float(total(self.stored))

    @property
    def dissipated(self):
        """Friction work of the step in all processes [J]."""
        return float(total(self.lost))

    @property
    def largest_overlap(self):
        """Largest overlap [m], 0 without contact."""
        return largest(-self.gap)


def evaluate(points, position, centre, rotation, surface, friction, tangential):
    """PointContact of `points` at `position` (m, 3) [m] with a body at `centre` (3,) [m], `rotation` (3, 3).

    surface: ContactSurface; friction: μ; tangential: ε_T/ε_N.
    """
    y = (position - centre) @ rotation
    closest = closest_points(y, points, surface)
    left = _past_an_edge(points, closest, rotation, surface)
    closest.gap[left] = np.inf
    if points.facet is not None:
        held_facets.hold(closest, y, points.facet, surface)
    rest = np.minimum(np.maximum(points.rest, closest.gap), 0.0)    # a point that comes out will press as any other
    rest[left] = points.rest[left]
    active = np.flatnonzero(np.isfinite(closest.gap))
    just = np.where(points.rest[active] == 0.0, CLOSED * surface.radius, 0.0)
    pressed = points.stiffness[active] * ((closest.gap - points.rest)[active] - just) < 0.0
    limits = points.limits
    if len(limits.tension):
        bonded = limits.tension > 0.0
        pressed |= bonded[active]
        rest[bonded] = points.rest[bonded]
    active = active[pressed]
    closest = closest.select(active)
    origin = np.where(points.touching[active, None], points.anchor[active], points.start[active])
    closed = ClosedPoints(y[active], points.anchor[active], origin, points.stiffness[active],
                          points.rest[active], limits.select(active),
                          NOWHERE if points.sticking is None else points.sticking[active])
    found = ContactResponse.empty(len(active))
    contact_law(closed, closest, Coulomb(friction, tangential), surface.tree, found)
    most = closed.limits.tension if len(limits.tension) else 0.0
    pressure = np.maximum(closed.stiffness * (closed.rest - closest.gap), -most)
    turning, ramp = rotation @ found.turning @ rotation.T, rotation @ found.ramp @ rotation.T
    return PointContact(
        active, closest.gap, found.side @ rotation.T, found.force @ rotation.T, rotation @ found.tangent @ rotation.T,
        turning, ramp, position[active] - centre, found.slip, found.anchor, found.side,
        pressure, closest.triangle, found.energy, found.dissipated, rest, found.opened)


def _past_an_edge(points, closest, rotation, surface):
    """Numbers of contact points that touched a side of the body and are now closest to a plane face at a right angle to it,
    at which the face of the soil that they are on does not look: an edge of the body has left them behind."""
    touching = np.flatnonzero(points.touching & np.isfinite(closest.gap) & (points.outward is not None))
    if not len(touching):
        return touching
    triangle = closest.triangle[touching]
    normal = surface.normals[triangle]
    turned = np.einsum("ci,ci->c", normal, points.side[touching]) < BESIDE
    looks = -np.einsum("ci,ci->c", points.outward[touching], normal @ rotation.T) > BESIDE
    past = touching[turned & ~looks & ~surface.curved[triangle]]
    return past[points.limits.tension[past] == 0.0] if len(points.limits.tension) else past


def commit(points, position, contact):
    """ContactHistory after acceptance: every followed point at its `position` (m, 3) [m]."""
    touching = np.zeros(len(points), bool)
    anchor, side = np.zeros((len(points), 3)), np.zeros((len(points), 3))
    touching[contact.active] = True
    anchor[contact.active], side[contact.active] = contact.anchor, contact.side
    opened = None
    if len(points.limits.opened):
        opened = points.limits.opened.copy()
        opened[contact.active[contact.opened]] = True
    return ContactHistory(points.point, points.place, position, touching, anchor, side, contact.rest, opened)
