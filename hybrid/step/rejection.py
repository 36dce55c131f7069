"""Why an increment must not be accepted although its equations are solved: it is too long for its rotations, or for its
search for contact, to be right."""

from hybrid.soil.transfer import interpolate
from hybrid.step.search_reach import travel_ratio

LARGEST_ROTATION = 2.0  # [rad] of a body in a step; beyond π it equals a smaller rotation in the opposite direction
DEEP = 0.05     # of a cell: depth of a contact point in a body from which on it may have passed through it


def rejection(step, evaluation):
    """Why a converged increment must not be accepted; empty if it may be."""
    if reason := rotation_too_large(step, evaluation.unknowns):
        return reason
    ratio = search_radius_ratio(step, evaluation.unknowns)
    if ratio > 1:
        return f"soil and body moved {ratio:.1f} times farther than the contact search allows for"
    if reason := step.pairs and step.pairs.rejection(evaluation.pairs, step.bodies):
        return reason
    count = tunnelled(step, evaluation)
    return f"{count} contact points of the soil passed through a body" if count else ""


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


def tunnelled(step, evaluation):
    """Number of contact points that passed through a body in the step."""
    depth, displacement = DEEP * step.model.soil.grid.smallest_cell, evaluation.unknowns.displacement
    return sum(terms.step.pair.tunnelled(terms.contact, displacement, terms.pose, depth) for terms in evaluation.bodies)
