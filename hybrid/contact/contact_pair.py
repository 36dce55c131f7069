"""Contact of one rigid body with the soil during a step: both passes together.

    first pass     corners of the points' domains against the body's triangles        soil_to_body.py   share 1 - s
    second pass    samples of the body against the exposed faces of the domains       body_to_soil.py   share s

Each pass alone is a quadrature of the same integral, ∫ p_f E g dA, over the soil's surface or the body's. The shares
add up to one, so no contact is counted twice: a flat overlap has a pressure of p_f E per unit of depth whatever s is.
A pass without a share is not evaluated.

Augmented Lagrangian: after a converged solution the multipliers are updated to the pressures, λ <- max(0, λ - ε_N g),
and the step is solved again with the same tangent, until the forces of the remaining overlaps are small among those
acting. The criterion is not the overlaps: where there are more corners than nodes, not every corner can lie on a curved
surface, and neighbouring corners exchange multipliers over many updates (a sphere in a block: hundreds). So the number
of updates in a step is limited, and the next step starts from the multipliers reached.

Equations: FORMULATION (46).
"""

from dataclasses import dataclass, replace

import numpy as np

from hybrid.contact import assembly, body_to_soil, held_facets, soil_to_body, tunnelling
from hybrid.contact.corners import find_corners
from hybrid.runtime.comm import maximum, total


@dataclass(frozen=True)
class Contact:
    """Contact of one body at a trial state; samples: None without a second pass."""

    corners: soil_to_body.CornerContact
    samples: body_to_soil.SampleContact | None

    @property
    def passes(self):
        return [contact for contact in (self.corners, self.samples) if contact is not None]

    def __len__(self):
        return sum(len(contact) for contact in self.passes)

    @property
    def energy(self):
        """Energy [J] stored in the springs."""
        return sum(contact.energy for contact in self.passes)

    @property
    def dissipated(self):
        """Friction work [J] of the step."""
        return sum(contact.dissipated for contact in self.passes)

    @property
    def force(self):
        """Force (3,) [N] and moment about the body's centre (3,) [N m] of the soil on the body, as (6,)."""
        return sum(np.concatenate([total(contact.force), total(np.cross(contact.arm, contact.force))])
                   for contact in self.passes)

    def switched(self, other):
        """Whether corners are carried by facets that face elsewhere in the `other` Contact of the step."""
        return held_facets.switched(self.corners, other.corners)

    @property
    def largest_overlap(self):
        """Largest overlap [m], 0 without contact."""
        return maximum(np.concatenate([-contact.gap for contact in self.passes]))


class ContactPair:
    """A body, the corners near it and, with a second pass, its samples near the soil. Frozen during a step except for
    the multipliers."""

    def __init__(self, body, state, history, points, half, grid, active, reach, expected):
        """body: RigidBody; state: BodyState; history: ContactHistory; points: soil points; half: (n, 3) [m] of their
        domains, zero in standard MPM; active, reach, expected: as in corners.find_corners."""
        self.body, self._grid = body, grid
        included = True if points.inactive is None else ~points.inactive
        first, second = (1 - body.second_pass) * body.contact_stiffness, body.second_pass * body.contact_pressure
        self.corners = find_corners(points.position, half, grid, active, state, body.surface, reach, first,
                                    history, expected, included)
        self.samples, self._width = None, None
        if body.second_pass:
            self._width = 2 * half[self.corners.id // 8].max(axis=1)
            self.samples = body_to_soil.find_samples(
                body.samples, points, grid, self.corners, state, reach, second,
                (history.sample, history.sample_anchor, history.sample_pressure), expected)

    def evaluate(self, displacement, pose):
        """Contact at nodal increments (N, 3) [m] (None: held soil) and a pose."""
        body, position = self.body, self.corners.moved(displacement)
        first = soil_to_body.evaluate(self.corners, position, *pose, body.surface, body.friction, body.tangential)
        second = None
        if self.samples is not None:
            second = body_to_soil.evaluate(self.samples, position, *pose, body.friction, body.tangential)
        return Contact(first, second)

    def springs(self, contact):
        """Root of the sum of squares [N/m] of the stiffnesses of all springs in contact."""
        passes = [(self.corners, contact.corners), (self.samples, contact.samples)]
        return float(np.sqrt(sum(total(own.stiffness[part.active] ** 2) for own, part in passes if part is not None)))

    def add_residual(self, contact, force):
        """Add contact to nodal residuals (N, 3) [N], None when the soil is held; returns the body's residual (6,)
        [N, N m about its centre]."""
        out = assembly.add_residual(contact.corners, self.corners, force)
        if contact.samples is not None:
            out += body_to_soil.add_residual(contact.samples, self.samples, self.corners, force)
        return out

    def add_tangent(self, contact, pattern, values, uw, wu):
        """Add the tangent to the soil block `values` and to its coupling with the body's m free components, uw (n, m)
        and wu (m, n); returns K_ww (6, 6)."""
        free = self.body.free
        ww, Q = assembly.body_tangent(contact.corners)
        if pattern.size:
            assembly.add_tangent(contact.corners, self.corners, Q, pattern, values, free, uw, wu)
        if contact.samples is not None:
            ww += total(contact.samples.matrix[:, :6, :6])
            if pattern.size:
                body_to_soil.add_tangent(contact.samples, self.samples, self.corners, pattern, self._grid.shape, values,
                                         free, uw, wu)
        return ww

    def tunnelled(self, contact, displacement, pose, depth):
        """Number of corners that the step carried through the body, or deeper than `depth` [m] into it on their way:
        checked on the corners whichever pass carries the contact."""
        return tunnelling.count_tunnelled(
            self.corners, contact.corners, self.corners.moved(displacement), *pose, self.body.surface, depth,
            self._width)

    def augment(self, contact):
        """Update the multipliers to the pressures of `contact`."""
        self.corners = _with_pressure(self.corners, contact.corners)
        if contact.samples is not None:
            self.samples = _with_pressure(self.samples, contact.samples)

    def hold_facets(self, contact):
        """Hold the corners that touch to the facets that carry them in `contact`."""
        self.corners = replace(self.corners, facet=held_facets.facets(self.corners, contact.corners, self.body.surface))

    def release_facets(self):
        """Let every corner find its facet again."""
        self.corners = replace(self.corners, facet=None)

    def facet_error(self, contact, displacement, pose):
        """Largest difference [-] between the overlaps with the held facets and with the surface, 0 without any held."""
        if self.corners.facet is None:
            return 0.0
        return held_facets.facet_error(
            self.corners, contact.corners, self.corners.moved(displacement), *pose, self.body.surface)

    def commit(self, contact, displacement):
        """ContactHistory after acceptance."""
        history = soil_to_body.commit(self.corners, self.corners.moved(displacement), contact.corners)
        if contact.samples is None:
            return history
        second = contact.samples
        return replace(history, sample=self.samples.id[second.active], sample_anchor=second.anchor,
                       sample_pressure=self.samples.pressure[second.active])


def _with_pressure(springs, contact):
    """Corners or SampleSet with the pressures [N] of those in contact as multipliers, 0 for the others."""
    pressure = np.zeros(len(springs))
    pressure[contact.active] = contact.pressure
    return replace(springs, pressure=pressure)
