"""What contact answers to forces that begin to act on bodies: FORMULATION (27c).

Forces that begin with a run or a stage are known at the start of its first increment (`hybrid.body.stage_start`). Contact
answers them at once, but its answer is known at the end of the increment only: its change from the start to the end counts
as if it had come at the start. Otherwise the forces would act alone there: a body laid on held ground would begin to fall,
and half a step of it would stay in its velocity.

Not so where bodies hit each other, or the soil, within the increment.
"""

from dataclasses import dataclass, replace

import numpy as np

from hybrid.body import stage_start
from hybrid.contact.body_to_body import PairContact
from hybrid.runtime.comm import total

HIT = 0.05      # of what pressure changes of the velocity along itself in an increment: bodies with more at its start hit


@dataclass(frozen=True)
class Touch:
    """Contact of two bodies, or of one and the soil, at trial poses.

    bodies: their numbers, None for the soil; pressure: [N] sum over its points; normal, friction: (2, 6) [N, N m] on each of
    them
    """

    bodies: tuple
    pressure: float
    normal: np.ndarray
    friction: np.ndarray


def count_from_start(step, evaluation, state, pushed):
    """`state` at the end of an increment, with its Evaluation, at whose start forces began to act on the bodies with numbers
    `pushed`, as if what contact answers, on those bodies and all that touch them, had come at the start as well."""
    if not pushed:
        return state
    bodies, changes = list(state.bodies), np.zeros((len(state.bodies), 6))
    after = _touches([terms.contact for terms in evaluation.bodies], evaluation.pairs)
    reached = _reached([one for one in after if None not in one.bodies], pushed)
    for old, new in zip(_at_start(step), after):
        if reached.intersection(new.bodies) and not _hits(step, new):
            for number, change in zip(new.bodies, new.normal + new.friction - old.normal - old.friction):
                if number is not None:
                    changes[number] += change
    for number in reached:
        bodies[number] = stage_start.count_from_start(
            step.bodies[number].body, bodies[number], changes[number], step.model.scheme, step.dt)
    return replace(state, bodies=bodies)


def _hits(step, touch):
    """Whether what touches has moved towards each other at the start of the increment, and pressure has stopped it."""
    power = answer = 0.0
    for number, normal in zip(touch.bodies, touch.normal):
        if number is not None:
            body, state = step.bodies[number].body, step.state.bodies[number]
            power -= normal @ np.concatenate([state.velocity, state.rotation @ state.spin])
            answer += normal @ stage_start.acceleration(body, state, normal)
    return power > HIT * step.dt * answer


def _reached(touches, numbers):
    """The `numbers` of bodies and those of all that touch them, also over others."""
    while True:
        more = {n for one in touches if one.pressure > 0.0 and numbers.intersection(one.bodies) for n in one.bodies}
        if more <= numbers:
            return numbers
        numbers = numbers | more


def _at_start(step):
    """Touches at the start of an increment."""
    displacement = step.at_rest().displacement
    contacts = [own.pair.evaluate(displacement, own.state.pose) for own in step.bodies]
    return _touches(contacts, step.pairs and step.pairs.evaluate(step.pairs.poses))


def _touches(contacts, pairs):
    """[Touch] of the PointContact of each body with the soil, then those of PairTerms."""
    found = []
    for number, contact in enumerate(contacts):
        normal, friction = contact.resultant - contact.friction, contact.friction
        found.append(Touch((number, None), float(total(contact.pressure)), np.array([normal, np.zeros(6)]),
                           np.array([friction, np.zeros(6)])))
    if pairs:
        found += [_of_pair(one.pair.numbers, sides) for one, sides in zip(pairs.step.near, pairs.contacts)]
    return found


def _of_pair(numbers, sides):
    """Touch of two bodies from the PairContact of the places of the first one and of those of the second."""
    first, second = sides       # the first body of a side is the one that has its places
    residual, friction = ((of(first).reshape(2, 6) + of(second).reshape(2, 6)[::-1]) for of in (
        PairContact.residual, PairContact.friction))
    return Touch(numbers, first.pressure + second.pressure, friction - residual, -friction)
