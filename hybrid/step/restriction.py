"""An increment restricted to few nodes and the bodies, with all other nodes where a trial has them.

Where sand opens and closes beside a body, Newton's method goes to and fro: a few points change between no stiffness, their
elastic one and yielding from one iterate to the next, and the rest of the soil is assembled and solved for each time. Most
of the residual then lies in five to thirty nodes. So these are solved for by themselves, with the bodies, before the next
iteration of all: nonlinear elimination (Lanzkron, Rose & Wilkes, SIAM J. Sci. Comput. 17 (1996) 538-559; Cai & Li, SIAM J.
Sci. Comput. 33 (2011) 746-762). It changes the iterates, not the solution.
"""

from dataclasses import replace

import numpy as np

from hybrid.linalg.petsc import BlockSystem
from hybrid.linalg.stencil_pattern import make_pattern
from hybrid.soil import restriction

LARGE = 0.05    # share of the norm of the residual from which a node is solved for, and its neighbours with it
FEW = 0.2       # largest share of all unknowns that is worth it


def rough_nodes(step, evaluation):
    """(N,) bool, nodes with a large share of the residual and their neighbours; None where these are not few, where the soil
    does not yield, or cannot be restricted: it is shared with other processes, or has a user's law."""
    pattern, soil = step.pattern, step.model.soil
    if not pattern.size or not soil.law.plastic or not restriction.can_be_restricted(soil):
        return None
    size = np.zeros(pattern.free.shape)
    size[pattern.free] = evaluation.soil
    size = np.linalg.norm(size, axis=1)
    nodes = (size > LARGE * np.linalg.norm(size)).reshape(soil.grid.shape)
    for axis in range(3):
        along = nodes.swapaxes(0, axis)     # a view
        before = along.copy()
        along[1:] |= before[:-1]
        along[:-1] |= before[1:]
    nodes = nodes.ravel()
    return nodes if np.count_nonzero(pattern.free[nodes]) < FEW * pattern.size else None


def restricted(step, nodes, evaluation):
    """Step whose unknowns are those of `nodes` (N,) bool and of the bodies; trial values of `step` are those of this Step
    too. Of the contact points it has those that touch in an `evaluation` of `step` or that move with the nodes. Its system is
    to be destroyed after use."""
    model, solver = step.model, step.model.solver
    part, soil, near = restriction.restricted(model.soil, step.soil, nodes, solver)
    bodies = tuple(replace(body, contact_pressure=body.contact_pressure[near]) for body in model.bodies)
    pattern = make_pattern(nodes & step.pattern.free.any(axis=1), part.grid.fixed, part.grid.shape)
    system = BlockSystem(pattern.indptr, pattern.indices, step.system.body_unknowns, "direct", solver.linear_tolerance)
    begun = tuple(replace(terms.step, pair=terms.step.pair.near(nodes, terms.contact)) for terms in evaluation.bodies)
    return replace(step, model=replace(model, soil=part, bodies=bodies), soil=soil, pattern=pattern, system=system,
                   bodies=begun)
