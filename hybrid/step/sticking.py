"""Contact points that are held in stick for an update of Newton's method: `hybrid.contact.reversals`, for all bodies of
a step."""

from contextlib import ExitStack

from hybrid.contact.reversals import NONE, reversed_slip
from hybrid.runtime import comm


def turned_round(before, after, held=None):
    """Contact points of each body whose slip an update between two Evaluations turns round, None where there are none;
    held: those that were held in stick in it, None for none."""
    points = tuple(map(reversed_slip, before.contacts, after.contacts, held or [NONE] * len(after.contacts)))
    return points if any(comm.anywhere([len(own)]) for own in points) else None


def held_in_stick(step, evaluation, points):
    """Evaluation at the same unknowns in which `points` of each body stick, whatever their shear."""
    with ExitStack() as held:
        for terms, own in zip(evaluation.bodies, points):
            held.enter_context(terms.step.pair.sticking(own))
        return step.evaluate(evaluation.unknowns)
