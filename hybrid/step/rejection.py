"""Why an increment must not be accepted although its equations are solved: it is too long for its rotations, for its search
for contact, or for friction that reverses in it, to be right.

Friction has one direction in an increment, that of the displacement. Where a body turns round, its velocity would be off by
up to twice of what friction takes in the increment, for good: such increments are cut until they are short.
"""

from hybrid.runtime import comm
from hybrid.soil.transfer import interpolate
from hybrid.step.contact_resultants import gain, power, resultants_at_end, resultants_at_start
from hybrid.step.search_reach import travel_ratio

LARGEST_ROTATION = 2.0  # [rad] of a body in a step; beyond π it equals a smaller rotation in the opposite direction
# Of the velocity that all of friction changes in an increment: with more along friction, at the start or end, it reverses,
# as it has at one of them at least half of that
REVERSED = 0.3
FRICTION, SLIDES = 0.1, 0.95  # of what friction can bear: less hardly counts; what has less at both ends swings in stick
DEEP = 0.05     # of a cell: depth of a contact point in a body from which on it may have passed through it


def rejection(step, evaluation, short=False):
    """Why a converged increment must not be accepted; empty if it may be. short: whether friction may reverse in it."""
    if reason := rotation_too_large(step, evaluation.unknowns):
        return reason
    ratio = search_radius_ratio(step, evaluation.unknowns)
    if ratio > 1:
        return f"soil and body moved {ratio:.1f} times farther than the contact search allows for"
    if reason := step.pairs and step.pairs.rejection(evaluation.pairs, step.bodies):
        return reason
    count = tunnelled(step, evaluation)
    if count:
        return f"{count} contact points of the soil passed through a body"
    return "" if short else friction_reverses(step, evaluation)


def rotation_too_large(step, unknowns=None):
    """Why a body rotates too far in the step, by its committed spin or by trial unknowns; empty if none does."""
    for own in step.bodies:
        angle = own.rotation_angle(unknowns)
        if angle > LARGEST_ROTATION:
            return f"{own.body.name} rotates by {angle:.3g} rad in {step.dt:.3g} s, limit {LARGEST_ROTATION:g} rad"
    return ""


def search_radius_ratio(step, unknowns):
    """Largest path of soil and body towards each other that was not predicted, over the margin of the search."""
    grid, moved = step.model.soil.grid, None
    if step.soil is not None and step.bodies:   # of points: a node with little mass may move far without effect
        moved = interpolate(step.soil.basis, grid.shape, unknowns.displacement)
    return max((travel_ratio(own.body, own.state, own.pose(unknowns), own.predicted_pose(), own.reach.margin, grid,
                             step.state.points, moved) for own in step.bodies), default=0.0)


def friction_reverses(step, evaluation):
    """Why friction between bodies, or on held ground, has not the direction of sliding at the start or at the end of the
    increment; empty if it has, on soil that deforms, which slides along, and by schemes in which contact rings."""
    if not step.model.scheme.damps or step.soil is not None and not step.pairs:
        return ""
    if not step.pairs and not any(comm.anywhere(terms.contact.pressure) for terms in evaluation.bodies):
        return ""
    ends, before = None, None
    for index, contact in enumerate(resultants_at_end(step, evaluation)):
        if contact.share > FRICTION and (step.soil is None or None not in contact.bodies):
            ends = ends or (step.state.bodies, [terms.accept() for terms in evaluation.bodies])
            pushed = max(power(contact, contact.friction, states) for states in ends)
            if contact.share * pushed > REVERSED * step.dt * gain(contact, contact.friction, step):
                before = before or resultants_at_start(step)
                if max(contact.share, before[index].share) > SLIDES:
                    names = " and ".join(step.bodies[number].body.name for number, _ in contact.sides)
                    return f"friction of {names} reverses in {step.dt:.3g} s"
    return ""


def tunnelled(step, evaluation):
    """Number of contact points that passed through a body in the step."""
    depth, displacement = DEEP * step.model.soil.grid.smallest_cell, evaluation.unknowns.displacement
    return sum(terms.step.pair.tunnelled(terms.contact, displacement, terms.pose, depth) for terms in evaluation.bodies)
