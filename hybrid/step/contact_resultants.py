"""Resultants of contact in an evaluation: of each body and the soil, and of each pair of bodies."""

from dataclasses import dataclass

import numpy as np

from hybrid.body import stage_start
from hybrid.contact.body_to_body import PairContact
from hybrid.runtime.comm import total


@dataclass(frozen=True)
class ContactResultants:
    """Resultants of the contact of two bodies, or of one and the soil, at trial poses.

    bodies: their numbers, None for the soil; mu: coefficient of friction; pressure: [N] sum over its points; normal,
    friction: (2, 6) [N, N m] on each of them
    """

    bodies: tuple
    mu: float
    pressure: float
    normal: np.ndarray
    friction: np.ndarray

    @property
    def share(self):
        """Friction over what it can bear, 0 where that is nothing."""
        most = self.mu * self.pressure if self.pressure > 0.0 else 0.0
        return float(np.linalg.norm(self.friction[0, :3])) / most if most > 0.0 else 0.0

    @property
    def sides(self):
        """(number of a body, its row of the resultants), without the soil."""
        return [(number, row) for row, number in enumerate(self.bodies) if number is not None]


def resultants_at_start(step):
    """[ContactResultants] at the start of an increment: of each body and the soil, then of each pair near enough."""
    displacement = step.at_rest().displacement
    contacts = [own.pair.evaluate(displacement, own.state.pose) for own in step.bodies]
    return _resultants(step, contacts, step.pairs and step.pairs.evaluate(step.pairs.poses))


def resultants_at_end(step, evaluation):
    """The same at the end of an increment, in its Evaluation."""
    return _resultants(step, [terms.contact for terms in evaluation.bodies], evaluation.pairs)


def _resultants(step, contacts, pairs):
    """Of the PointContact of each body with the soil, then those of PairTerms, None without pairs."""
    found = []
    for number, contact in enumerate(contacts):
        normal, friction = contact.resultant - contact.friction, contact.friction
        found.append(ContactResultants(
            (number, None), step.bodies[number].body.friction, float(total(contact.pressure)),
            np.array([normal, np.zeros(6)]), np.array([friction, np.zeros(6)])))
    if pairs:
        found += [_of_pair(one.pair, sides) for one, sides in zip(pairs.step.near, pairs.contacts)]
    return found


def _of_pair(pair, sides):
    """ContactResultants of two bodies from the PairContact of the places of the first one and of those of the second."""
    first, second = sides       # the first body of a side is the one that has its places
    residual, friction = ((of(first).reshape(2, 6) + of(second).reshape(2, 6)[::-1]) for of in (
        PairContact.residual, PairContact.friction))
    return ContactResultants(pair.numbers, pair.law.mu, first.pressure + second.pressure, friction - residual, -friction)


def power(contact, forces, states):
    """[W] of `forces` (2, 6) [N, N m] on the bodies in `contact`, a ContactResultants, with BodyState `states`; the soil is
    at rest."""
    return sum(float(forces[row] @ states[n].spatial_rates) for n, row in contact.sides)


def gain(contact, forces, step):
    """[W/s] of power that `forces` (2, 6) [N, N m] on the bodies in `contact`, a ContactResultants, gain as they accelerate
    these."""
    gained = 0.0
    for n, row in contact.sides:
        own = step.bodies[n]
        force, moment = np.split(stage_start.acceleration(own.body, own.state, forces[row]), 2)
        gained += float(forces[row] @ np.concatenate([force, own.state.rotation @ moment]))
    return gained
