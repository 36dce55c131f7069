"""What contact answers to forces that begin to act on bodies: FORMULATION (27c).

Forces that begin with a run or a stage are known at the start of its first increment (`hybrid.body.stage_start`). Contact
answers them at once, but its answer is known at the end of the increment only: its change from the start to the end counts
as if it had come at the start. Otherwise the forces would act alone there: a body laid on held ground would begin to fall,
and half a step of it would stay in its velocity.

Not so what ends a motion within the increment: pressure where bodies hit each other, or the soil, and friction that stops
one. An impulse counts by the trapezoidal rule.
"""

from dataclasses import replace

import numpy as np

from hybrid.body import stage_start
from hybrid.step.contact_resultants import gain, power, resultants_at_end, resultants_at_start

HIT = 0.05      # of what a force changes of the velocity along itself in an increment: with more against it, that is ended


def count_from_start(step, evaluation, state, pushed):
    """`state` at the end of an increment, with its Evaluation, at whose start forces began to act on the bodies with numbers
    `pushed`, as if what contact answers, on those bodies and all that touch them, had come at the start as well."""
    if not pushed:
        return state
    bodies, changes = list(state.bodies), np.zeros((len(state.bodies), 6))
    after = resultants_at_end(step, evaluation)
    reached = _reached([one for one in after if None not in one.bodies], pushed)
    for old, new in zip(resultants_at_start(step), after):
        if reached.intersection(new.bodies):
            change = np.zeros((2, 6))
            if _ended(step, new, new.normal) <= HIT:
                change += new.normal - old.normal
            if not HIT < _ended(step, new, new.friction) <= 1.0:
                change += new.friction - old.friction
            for number, row in new.sides:
                changes[number] += change[row]
    for number in reached:
        bodies[number] = stage_start.count_from_start(
            step.bodies[number].body, bodies[number], changes[number], step.bodies[number].scheme, step.dt)
    return replace(state, bodies=bodies)


def _ended(step, contact, forces):
    """Velocity against `forces` (2, 6) [N, N m] at the start of the increment, over what they change of it, 0 without
    forces: above 1 it goes on, as that of a body that slides."""
    gained = step.dt * gain(contact, forces, step)
    return -power(contact, forces, step.state.bodies) / gained if gained > 0.0 else 0.0


def _reached(touching, numbers):
    """The `numbers` of bodies and those of all that touch them, also over others."""
    while True:
        more = {n for one in touching if one.pressure > 0.0 and numbers.intersection(one.bodies) for n in one.bodies}
        if more <= numbers:
            return numbers
        numbers = numbers | more
