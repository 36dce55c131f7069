"""Bodies in flight, near nothing that they could touch: their scheme damps next to nothing.

What damps contact takes energy from smooth motion as well: with ρ∞ = 0 a bar that swings on a hinge by 90 degrees loses 14 %
of its height in a period of 43 steps, and 48 % in one of 22. In flight nothing has to be damped. A body has been near
nothing for AFTER increments before, so that impulses have been given to the end, and its motion is smooth
where the scheme changes (`hybrid.scheme.Scheme.carried`). An increment in which bodies in flight hit each other is done
again without. Bodies that joints connect fly together, as an impact on one of them goes through the joints. A pull line
is a stiff spring, and its body does not fly.
"""

from dataclasses import replace

import numpy as np

from hybrid.body.joints import connected
from hybrid.runtime.comm import anywhere

AFTER = 3       # increments


def with_schemes(model, bodies, pairs):
    """BodySteps of an increment, with the scheme for flight where they fly. pairs: PairsStep, None where bodies do not touch
    one another."""
    if model.scheme.in_flight is None or not bodies:
        return bodies
    near = connected({body.number for body in bodies if body.target is not None or anywhere([len(body.pair.points)])}
                     | _near_bodies(pairs, bodies[0].begin == 0.0), model.joints)
    return tuple(_with_scheme(body, model.scheme, body.number not in near) for body in bodies)


def hit(step, evaluation):
    """Numbers of the bodies of a Step that began it in flight and touch another one in an Evaluation, with all that joints
    connect to them."""
    if not step.pairs:
        return set()
    flying = {body.number for body in step.bodies if body.scheme is not step.model.scheme}
    touching = {number for one, sides in zip(step.pairs.near, evaluation.pairs.contacts)
                if any(len(side.active) for side in sides) for number in one.pair.numbers}
    return connected(flying & touching, step.model.joints)


def landed(model, state, numbers):
    """`state` from which the bodies of these `numbers` do not fly on."""
    return replace(state, bodies=[_carried(body, model.scheme, False) if number in numbers else body
                                  for number, body in enumerate(state.bodies)])


def _with_scheme(body, scheme, apart):
    """BodyStep of a body that is `apart` from all others and the soil, or is not."""
    used = scheme.in_flight if apart and body.state.apart >= AFTER else scheme
    return replace(body, state=_carried(body.state, scheme, apart), scheme=used)


def _carried(motion, scheme, apart):
    """BodyState for an increment in which the body is `apart`, or is not."""
    flies, flew = apart and motion.apart >= AFTER, motion.apart > AFTER
    if flies != flew and motion.algorithmic is not None:
        ends = (scheme.in_flight, scheme) if flies else (scheme, scheme.in_flight)
        second = np.concatenate([motion.acceleration, motion.spin_rate])
        motion = replace(motion, algorithmic=ends[0].carried(second, motion.algorithmic, ends[1]))
    return replace(motion, apart=min(motion.apart, AFTER) + 1 if apart else 0)


def _near_bodies(pairs, first):
    """Numbers of bodies that touch another one, or are predicted to; in the `first` increment of a run, in which bodies that
    rest on one another do not press yet, of those that are near another one."""
    return {number for one in (pairs.near if pairs else ()) for number in one.pair.numbers
            if any(side.closes or side.touching.any() or first and len(side.start) for side in one.sides)}
