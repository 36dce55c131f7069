"""Contact points that are held in stick for an update of Newton's method, for all bodies of a step and for bodies that touch
one another: those of `hybrid.contact.reversals`, and all of a body that slips on a plane with nothing to draw it along."""

from contextlib import ExitStack
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from hybrid.contact.reversals import NONE, reversed_slip
from hybrid.runtime import comm

LEVEL = 1e-3    # length of N x Σ N of contact points in one plane
# Components of a motion along level ground: a base that is turned slips on all of its points about its middle
ALONG = [0, 1, 5]


class Held(NamedTuple):
    """Numbers of contact points: with the soil, an array for each body; of bodies with one another, one for each side of
    each pair near enough to touch."""

    bodies: tuple
    sides: tuple = ()


def reversing(before, after, held):
    """Held contact points whose slip an update between two Evaluations turns round, None where there are none; held: those
    that were held in stick in it, None for none."""
    found = []
    for old, new, earlier in ((before.contacts, after.contacts, held and held.bodies),
                              (_sides(before), _sides(after), held and held.sides)):
        found.append(tuple(map(reversed_slip, old, new, earlier or [NONE] * len(new))))
    bodies, sides = found
    return Held(bodies, sides) if any(comm.anywhere([len(own)]) for own in bodies) or any(map(len, sides)) else None


def _sides(evaluation):
    """PairContact of each side of the pairs near enough to touch."""
    return [side for sides in evaluation.pairs.contacts for side in sides] if evaluation.pairs else []


def drifting(step, evaluation):
    """Held contact points of each free body without inertia that slips on a plane on all of its points although nothing
    draws it along there; None where there are none.

    Shear of slip depends on the pressure alone, so that the tangent lets the body go along the plane: a bar lifted at one
    end, whose first guess slips on what is left of its base, by 80 m. It has an equilibrium only where some of its points
    stick: of those that slip against one another the stronger, whose shear goes with the sum.
    """
    model = step.model
    if model.scheme.inertia or model.joints or any(each.guide.component in ALONG for each in model.guides):
        return None
    points = tuple(_stronger(terms.contact) if _drifts(terms) else NONE for terms in evaluation.bodies)
    return Held(points) if any(comm.anywhere([len(own)]) for own in points) else None


def _drifts(terms):
    """Whether all contact points of a body slip on one plane and neither a guide, a line nor another body draws it
    along or turns it there: under a load that friction carries it has an equilibrium too."""
    body, contact = terms.step.body, terms.contact
    drawn = not body.free[:2].any() or body.drive[ALONG].any() or body.line is not None or terms.beside
    if drawn or not comm.anywhere(contact.slip) or comm.anywhere(~contact.slip):
        return False
    mean = comm.total(contact.normal)
    return comm.largest(np.linalg.norm(np.cross(contact.normal, mean), axis=1)) < LEVEL * np.linalg.norm(mean)


def _stronger(contact):
    """Index of the contact points whose shear goes with that of all."""
    return contact.active[contact.shear @ comm.total(contact.shear) > 0.0]


def held_in_stick(step, evaluation, points):
    """Evaluation at the same unknowns in which Held `points` stick, whatever their shear."""
    with ExitStack() as held:
        for terms, own in zip(evaluation.bodies, points.bodies):
            held.enter_context(terms.step.pair.sticking(own))
        if any(map(len, points.sides)):
            step = replace(step, pairs=step.pairs.sticking(points.sides))
        return step.evaluate(evaluation.unknowns)
