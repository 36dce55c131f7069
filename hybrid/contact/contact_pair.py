"""One rigid body against the soil during a step: both passes of contact behind one door.

    first pass     corners of the points' domains against the body's triangles        soil_to_body.py   share 1 - s
    second pass    samples of the body against the exposed faces of the domains       body_to_soil.py   share s

Each pass alone is a quadrature of the same integral, ∫ p_f E g dA, over the soil's surface or the body's. With shares
that add up to one no contact is counted twice: a flat overlap costs p_f E per unit of area and depth whatever s is.
A pass without a share is not evaluated at all.

Augmented Lagrangian: after a converged solution the multipliers take over the pressures, λ <- max(0, λ - ε_N g), and
the step is solved again with the same tangent, until the forces of the overlaps left are small among those acting. The
forces, not the overlaps: where corners outnumber nodes not every corner can lie on a curved surface, and multipliers of
neighbours go on changing hands for long (a sphere in a block: hundreds of iterations). So the number of updates in a
step is limited, and multipliers go over to the next one.
"""

from dataclasses import dataclass, replace

import numpy as np

from hybrid.contact import assembly, body_to_soil, soil_to_body, tunnelling
from hybrid.contact.corners import find_corners
from hybrid.runtime.comm import total


@dataclass(frozen=True)
class Contact:
    """Contact of one body at a trial state. corners: friction.Touch; samples: probes.ProbeTouch, None without it."""

    corners: soil_to_body.CornerContact
    samples: body_to_soil.SampleContact | None

    @property
    def parts(self):
        return [part for part in (self.corners, self.samples) if part is not None]

    def __len__(self):
        return sum(len(part) for part in self.parts)

    @property
    def energy(self):
        """Stored in the springs [J]."""
        return sum(part.energy for part in self.parts)

    @property
    def dissipated(self):
        """Friction work of the step [J]."""
        return sum(part.dissipated for part in self.parts)

    @property
    def force(self):
        """Force (3,) [N] and moment about the body's centre (3,) [N m] of the soil on the body, as (6,)."""
        return sum(np.concatenate([total(p.force), total(np.cross(p.arm, p.force))]) for p in self.parts)

    @property
    def largest_overlap(self):
        """Largest overlap [m]."""
        return max((float(-part.gap.min()) for part in self.parts if len(part)), default=0.0)


class ContactPair:
    """A body, the corners near it and, with a second pass, its samples near the soil; frozen during a step but for the
    multipliers."""

    def __init__(self, body, state, history, points, half, grid, active, reach, expected):
        """half: (n, 3) [m] of the domains, zero in standard MPM; active, expected: as in corners.find_corners."""
        self.body, self._grid = body, grid
        first, second = (1 - body.second_pass) * body.contact_stiffness, body.second_pass * body.contact_pressure
        self.corners = find_corners(points.position, half, grid, active, state, body.surface, reach, first,
                                    history, expected, True if points.inactive is None else ~points.inactive)
        self.samples, self._width = None, None
        if body.second_pass:
            self._width = 2 * half[self.corners.id // 8].max(axis=1)
            self.samples = body_to_soil.find_samples(
                body.samples, points, grid, self.corners, state, reach, second,
                (history.sample, history.sample_anchor, history.sample_pressure), expected)

    def evaluate(self, displacement, pose):
        """Contact at nodal increments (N, 3) [m] (None: held soil) and a pose."""
        body, place = self.body, self.corners.moved(displacement)
        touch = soil_to_body.evaluate(self.corners, place, *pose, body.surface, body.friction, body.tangential)
        second = None
        if self.samples is not None:
            second = body_to_soil.evaluate(self.samples, place, *pose, body.friction, body.tangential)
        return Contact(touch, second)

    def springs(self, contact):
        """Stiffness [N/m] of all that touches, the root of the sum of squares."""
        held = [(self.corners, contact.corners), (self.samples, contact.samples)]
        return float(np.sqrt(sum(total(own.stiffness[touch.active] ** 2) for own, touch in held if touch is not None)))

    def add_residual(self, contact, force):
        """Add contact to nodal residuals (N, 3) [N], None when the soil is held; returns the body's residual (6,)."""
        out = assembly.add_residual(contact.corners, self.corners, force)
        if contact.samples is not None:
            out += body_to_soil.add_residual(contact.samples, self.samples, self.corners, force)
        return out

    def add_tangent(self, contact, pattern, values, uw, wu):
        """Add the tangent to the soil block and its coupling with the body's free components; returns K_ww (6, 6)."""
        free = self.body.free
        ww, Q = assembly.body_tangent(contact.corners)
        if pattern.size:
            assembly.add_tangent(contact.corners, self.corners, Q, pattern, values, free, uw, wu)
        if contact.samples is not None:
            ww += total(contact.samples.matrix[:, :6, :6])
            if pattern.size:
                body_to_soil.add_tangent(contact.samples, self.samples, self.corners, pattern, self._grid.shape, values, free,
                                   uw, wu)
        return ww

    def tunnelled(self, contact, displacement, pose, depth):
        """Number of corners that the step carried through the body, deeper than `depth` [m]. They tell it whichever
        pass carries the contact."""
        return tunnelling.count_tunnelled(
            self.corners, contact.corners, self.corners.moved(displacement), *pose, self.body.surface, depth,
            self._width)

    def augment(self, contact):
        """Let the multipliers take over the pressures."""
        for name, touch in (("corners", contact.corners), ("samples", contact.samples)):
            if touch is None:
                continue
            held = getattr(self, name)
            pressure = np.zeros(len(held))
            pressure[touch.active] = touch.pressure
            setattr(self, name, replace(held, pressure=pressure))

    def commit(self, contact, displacement):
        """ContactHistory after acceptance."""
        history = soil_to_body.commit(self.corners, self.corners.moved(displacement), contact.corners)
        if contact.samples is None:
            return history
        second = contact.samples
        return replace(history, sample=self.samples.id[second.active], sample_anchor=second.anchor,
                       sample_pressure=self.samples.pressure[second.active])
