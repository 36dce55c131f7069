"""What a body has from those that joints connect it with, over any number of others: support and a scale of forces.

Without inertia a body that touches nothing gets the stiffness of a cell, with which its weight leads it back to the soil
(`hybrid.step.body_terms`). A mast welded to a footing touches nothing either, and would hold that footing back; and what
hangs on a rod would hardly move.
"""

FAINT = 1e-5    # share of the forces on other bodies of an assembly that a force is compared with at least


def supported_by_joints(joints, supported):
    """[bool] of all bodies, whether `joints`, at points, rods or taut lines, hold them, over any number of others, to one
    that is `supported`, or to the ground; supported: [bool] of all bodies."""
    return _most(joints, supported, True)


def least_forces(joints, forces):
    """[N] that the residual of each body is compared with at least, FAINT of the largest of the `forces` [N] on those that
    joints at points connect it with: without inertia one that nothing acts on would have no scale of its own."""
    return [FAINT * force for force in _most([joint for joint in joints if joint.at_point], forces, 0.0)]


def _most(joints, values, ground):
    """[largest] for each body, of the `values` of all that joints connect it with; ground: that of the ground."""
    found = list(values)
    for _ in joints:
        for a, b in (joint.bodies for joint in joints):
            most = max(found[a], ground if b is None else found[b])
            found[a] = most
            if b is not None:
                found[b] = most
    return found
