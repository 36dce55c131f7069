"""Contact points that are held in stick for an update of Newton's method, for all bodies of a step: those of
`hybrid.contact.reversals`, and all of a body that slips on a plane with nothing to draw it along."""

from contextlib import ExitStack

import numpy as np

from hybrid.contact.reversals import NONE, reversed_slip
from hybrid.runtime import comm

LEVEL = 1e-3    # length of N x Σ N of contact points in one plane


def turned_round(before, after, held=None):
    """Contact points of each body whose slip an update between two Evaluations turns round, None where there are none;
    held: those that were held in stick in it, None for none."""
    points = tuple(map(reversed_slip, before.contacts, after.contacts, held or [NONE] * len(after.contacts)))
    return points if any(comm.anywhere([len(own)]) for own in points) else None


def drifting(step, evaluation):
    """Contact points to hold of each free body without inertia that slips on a plane on all of its points although nothing
    draws it along there; None where there are none.

    Shear of slip depends on the pressure alone, so that the tangent lets the body go along the plane: a bar lifted at one
    end, whose first guess slips on what is left of its base, by 80 m. It has an equilibrium only where some of its points
    stick: of those that slip against one another the stronger, whose shear goes with the sum.
    """
    model = step.model
    if model.scheme.inertia or model.joints or any(each.guide.component < 2 for each in model.guides):
        return None
    points = tuple(_stronger(terms.contact) if _drifts(terms) else NONE for terms in evaluation.bodies)
    return points if any(comm.anywhere([len(own)]) for own in points) else None


def _drifts(terms):
    """Whether all contact points of a body slip on one plane and neither a guide, a line nor another body draws it
    along: under a load that friction carries it has an equilibrium too."""
    body, contact = terms.step.body, terms.contact
    drawn = not body.free[:2].any() or body.drive[:2].any() or body.line is not None or terms.beside
    if drawn or not comm.anywhere(contact.slip) or comm.anywhere(~contact.slip):
        return False
    mean = comm.total(contact.normal)
    return comm.largest(np.linalg.norm(np.cross(contact.normal, mean), axis=1)) < LEVEL * np.linalg.norm(mean)


def _stronger(contact):
    """Index of the contact points whose shear goes with that of all."""
    return contact.active[contact.shear @ comm.total(contact.shear) > 0.0]


def held_in_stick(step, evaluation, points):
    """Evaluation at the same unknowns in which `points` of each body stick, whatever their shear."""
    with ExitStack() as held:
        for terms, own in zip(evaluation.bodies, points):
            held.enter_context(terms.step.pair.sticking(own))
        return step.evaluate(evaluation.unknowns)
