"""Bodies in flight, near nothing that they could touch: their scheme damps next to nothing.

What damps contact takes energy from smooth motion as well: with ρ∞ = 0 a bar that swings on a hinge by 90 degrees loses 14 %
of its height in a period of 43 steps, and 48 % in one of 22. In flight nothing has to be damped. A body has been near
nothing for AFTER increments before, so that impulses have been given to the end, and its motion is smooth
where the scheme changes (`hybrid.scheme.Scheme.carried`). Bodies that joints connect fly together, as an impact
on one of them goes through the joints. A pull line is a stiff spring, and its body does not fly.
"""

from dataclasses import replace

import numpy as np

from hybrid.runtime.comm import anywhere

AFTER = 3


def with_schemes(model, bodies, pairs):
    """BodySteps of an increment, with the scheme for flight where they fly. pairs: PairsStep, None where bodies do not touch
    one another."""
    if model.scheme.in_flight is None:
        return bodies
    near = joined_to(model, {body.number for body in bodies if body.target is not None or anywhere([len(body.pair.points)])}
                     | _near_bodies(pairs))
    return tuple(_with_scheme(body, model.scheme, body.number not in near) for body in bodies)


def _with_scheme(body, scheme, apart):
    """BodyStep of a body that is `apart` from all others and the soil, or is not."""
    before = body.state.apart
    flies, flew = apart and before >= AFTER, before > AFTER
    used = scheme.in_flight if flies else scheme
    motion = replace(body.state, apart=min(before, AFTER) + 1 if apart else 0)
    if flies != flew and motion.algorithmic is not None:
        second = np.concatenate([motion.acceleration, motion.spin_rate])
        motion = replace(motion, algorithmic=used.carried(
            second, motion.algorithmic, scheme.in_flight if flew else scheme))
    return replace(body, state=motion, scheme=used)


def _near_bodies(pairs):
    """Numbers of bodies with places that may touch another one."""
    return {number for one in (pairs.near if pairs else ()) if any(len(side.start) for side in one.sides)
            for number in one.pair.numbers}


def joined_to(model, numbers):
    """The `numbers` of bodies and those that joints connect to them, also over others."""
    while True:
        more = {n for joint in model.joints if numbers.intersection(joint.bodies) for n in joint.bodies if n is not None}
        if more <= numbers:
            return numbers
        numbers = numbers | more
