"""Contact of all bodies with the soil at once, as Newton's method (`hybrid.step.newton`) asks about it and steers it.

What it sets stays in the ContactPair of each body until it is taken back; the rest of a Step is frozen.
"""

from hybrid.runtime import comm


def share_interface(evaluation):
    """Let points of clay that touch in an Evaluation bear its adhesion (`ContactPair.share_interface`). Returns the largest
    change among the bodies."""
    return max((terms.step.pair.share_interface(terms.contact) for terms in evaluation.bodies), default=0.0)


def restore_interface(step):
    """Let the points bear what they did before `share_interface`."""
    for body in step.bodies:
        body.pair.restore_interface()


def hold_facets(evaluation):
    """Hold the contact points that touch to the facets that carry them at an Evaluation. Returns those facets, an array for
    each body."""
    return [terms.step.pair.hold_facets(terms.contact) for terms in evaluation.bodies]


def release_facets(step):
    """Let all contact points find their facets again."""
    for body in step.bodies:
        body.pair.release_facets()


def facet_error(evaluation):
    """Largest difference of overlaps [-] by facets that are held but not the nearest; 0 where none are held."""
    return max((terms.step.pair.facet_error(terms.contact, evaluation.unknowns.displacement, terms.pose)
                for terms in evaluation.bodies), default=0.0)


def has_convex_contact(evaluation):
    """Whether convex edges or curved faces of bodies press the soil at an Evaluation."""
    return any(comm.anywhere(contact.turning) for contact in evaluation.contacts)


def on_adhesion_ramp(step, evaluation):
    """Whether shear of contact points is on the ramp of adhesion at an Evaluation without inertia."""
    return not step.model.scheme.inertia and any(comm.anywhere(contact.ramp) for contact in evaluation.contacts)


def stiffness_ratio(step):
    """Stiffness of contact on the face of a cell over that of the cell [-]; 0 without contact or soil."""
    if step.soil is None:
        return 0.0
    cell = step.model.soil.law.young / step.model.soil.grid.smallest_cell
    return max((comm.largest(body.contact_pressure / cell) for body in step.model.bodies), default=0.0)
