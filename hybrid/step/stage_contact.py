"""What contact answers to forces that begin to act on bodies where a stage begins: FORMULATION (27c).

Generalised alpha counts a force at the start of an increment with half of it. Forces that begin with a stage are known
there (`hybrid.body.stage_start`). What answers them is not: friction and adhesion answer at once, by as much as it takes or
they can, and are known at the end of the first increment; pressure of what cannot move falls at once by as much as the
forces unload it.

Pressure that begins with the forces does so late by half of an increment, and twice of it follows in the next one, with its
friction.
"""

from dataclasses import dataclass, replace

import numpy as np

from hybrid.body import stage_start
from hybrid.contact.body_to_body import PairContact
from hybrid.runtime.comm import anywhere, total

GONE = 0.05     # of the pressure at the start of a stage: less at the end of its first increment says nothing about friction


@dataclass(frozen=True)
class Touch:
    """Contact of two bodies, or of one and the soil, at trial poses.

    bodies: their numbers, None for the soil; pressure: [N] sum over its points; normal, friction: (2, 6) [N, N m] on each of
    them; slips: whether a point does
    """

    bodies: tuple
    pressure: float
    normal: np.ndarray
    friction: np.ndarray
    slips: bool

    def on(self, number):
        """Pressure (6,) [N, N m] on a body."""
        return self.normal[self.bodies.index(number)]

    def other(self, number):
        """What a body touches."""
        return self.bodies[1 - self.bodies.index(number)]


def begin_pressure(step, pushed):
    """The committed state of an increment at whose start forces `pushed` {number: (6,) [N, N m]} begin to act on bodies,
    with the pressure that they unload gone: of held ground, of held bodies, and of all that rest on these."""
    answers, _ = _unloaded(step, _at_start(step), pushed)
    bodies = [stage_start.accelerated(own.body, state, answer)
              for own, state, answer in zip(step.bodies, step.state.bodies, answers)]
    return replace(step.state, bodies=bodies)


def begin_friction(step, evaluation, state, pushed):
    """`state` at the end of an increment, with its Evaluation, at whose start forces `pushed` {number: (6,) [N, N m]} began
    to act on bodies, as if friction and adhesion of the pressure that acted then had answered them from then on
    (`stage_start.begin_friction`): on those bodies, and on all that touch them."""
    if not pushed:
        return state
    bodies, before = list(state.bodies), _at_start(step)
    after = _touches([terms.contact for terms in evaluation.bodies], evaluation.pairs)
    reached, changes = _reached([one for one in after if None not in one.bodies], set(pushed)), np.zeros((len(bodies), 6))
    for old, new, left in zip(before, after, _unloaded(step, before, pushed)[1]):
        if reached.intersection(old.bodies):
            _add(changes, old.bodies, _answer(old, new, left))
    for number in reached:
        bodies[number] = stage_start.begin_friction(step.bodies[number].body, bodies[number], changes[number])
    return replace(state, bodies=bodies)


def _answer(before, after, left):
    """Change (2, 6) [N, N m] of friction on the bodies of a Touch between the start and the end of an increment, with the
    pressure that is `left` of that at the start."""
    pressed = left * before.pressure
    if pressed > 0.0 and after.pressure <= GONE * pressed:      # thrown off for an increment: it slips on as it did
        return np.zeros((2, 6))
    share = pressed / after.pressure if pressed > 0.0 else 0.0
    return (share if after.slips else min(share, 1.0)) * after.friction - before.friction


def _unloaded(step, touches, pushed):
    """Forces (b, 6) [N, N m] that pressure at `touches` no longer gives to bodies as soon as forces `pushed` begin to act on
    them, and the share [-] left of the pressure at each: a force takes what it unloads, at most all, from what rests on
    something that cannot move, and so hands it down to that. Soil that deforms springs back in its own time."""
    answers, left = np.zeros((len(step.bodies), 6)), np.ones(len(touches))
    rest = {number: _resting(step, touches, number) for number in range(len(step.bodies))}
    for _ in step.bodies:       # a force is handed down from body to body
        handed = {}
        for number, change in pushed.items():
            under = [i for i, one in enumerate(touches) if number in one.bodies and one.other(number) in rest[number]
                     and one.on(number)[:3] @ change[:3] > 0.0]
            support = sum((left[i] * touches[i].on(number)[:3] for i in under), np.zeros(3))
            share = min(change[:3] @ support / (support @ support), 1.0) if support.any() else 0.0
            for i in under:
                fallen, other = -share * left[i] * touches[i].normal, touches[i].other(number)
                left[i] *= 1.0 - share
                _add(answers, touches[i].bodies, fallen)
                if share > 0.0 and other is not None:
                    handed[other] = handed.get(other, 0.0) + fallen[touches[i].bodies.index(other)]
        pushed = handed
    return answers, left


def _resting(step, touches, without):
    """What cannot move, held bodies and None for held ground, and all bodies that it bears over any number of others,
    `without` one of them."""
    held = {own.number for own in step.bodies if not own.free.any()} | ({None} if step.soil is None else set())
    ground = {one.bodies[0] for one in touches if one.bodies[1] is None and one.pressure > 0.0} if None in held else set()
    between = [one for one in touches if None not in one.bodies and without not in one.bodies]
    return _reached(between, (held | ground) - {without})


def _add(sums, bodies, parts):
    """Add the rows of `parts` (2, 6) to those of their `bodies`."""
    for number, part in zip(bodies, parts):
        if number is not None:
            sums[number] += part


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
    contacts = [own.pair.evaluate(displacement, own.committed_pose()) for own in step.bodies]
    return _touches(contacts, step.pairs and step.pairs.evaluate(step.pairs.poses))


def _touches(contacts, pairs):
    """[Touch] of the PointContact of each body with the soil, then those of PairTerms."""
    found = []
    for number, contact in enumerate(contacts):
        normal, friction = contact.resultant - contact.friction, contact.friction
        found.append(Touch((number, None), float(total(contact.pressure)), np.array([normal, np.zeros(6)]),
                           np.array([friction, np.zeros(6)]), anywhere(contact.slip)))
    if pairs:
        found += [_of_pair(one.pair.numbers, sides) for one, sides in zip(pairs.step.near, pairs.contacts)]
    return found


def _of_pair(numbers, sides):
    """Touch of two bodies from the PairContact of the places of the first one and of those of the second."""
    first, second = sides       # the first body of a side is the one that has its places
    residual, friction = ((of(first).reshape(2, 6) + of(second).reshape(2, 6)[::-1]) for of in (
        PairContact.residual, PairContact.friction))
    return Touch(numbers, first.pressure + second.pressure, friction - residual, -friction, first.slips or second.slips)
