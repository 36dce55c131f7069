"""An increment restricted to few nodes and the bodies, with all other nodes where a trial has them.

Where sand opens and closes beside a body, Newton's method goes to and fro: a few points change between no stiffness, their
elastic one and yielding from one iterate to the next, and the rest of the soil is assembled and solved for each time. Most
of the residual then lies in five to thirty nodes. So these are solved for by themselves, with the bodies, before the next
iteration of all: nonlinear elimination (Lanzkron, Rose & Wilkes, SIAM J. Sci. Comput. 17 (1996) 538-559; Cai & Li, SIAM J.
Sci. Comput. 33 (2011) 746-762). It changes the iterates, not the solution.
"""

from dataclasses import replace

import numpy as np

from hybrid.linalg.stencil_pattern import make_pattern
from hybrid.linalg.system_cache import CarriedTangent, direct_system
from hybrid.runtime import comm
from hybrid.soil import restriction

LARGE = 0.05    # share of the norm of the residual from which a node is solved for, and its neighbours with it
FEW = 0.2       # largest share of all unknowns that is worth it


def rough_nodes(step, evaluation):
    """(N,) bool, nodes with a large share of the residual and their neighbours; None where these are not few, where the soil
    does not yield, or has a user's law, which cannot be restricted."""
    pattern, soil, unknowns = step.pattern, step.model.soil, step.system.soil_unknowns
    if not unknowns or not soil.law.plastic or not restriction.can_be_restricted(soil):
        return None
    size = np.zeros(pattern.free.shape)
    size[pattern.free] = evaluation.soil
    whole = comm.norm(size[pattern.free][soil.grid.own_unknowns(pattern.free)])
    nodes = (np.linalg.norm(size, axis=1) > LARGE * whole).reshape(soil.grid.shape)
    for axis in range(3):
        along = nodes.swapaxes(0, axis)     # a view
        before = along.copy()
        along[1:] |= before[:-1]
        along[:-1] |= before[1:]
    nodes = soil.grid.from_owners(nodes.ravel())    # a copy may have neighbours that only its owner has
    return nodes if soil.grid.count_unknowns(pattern.free & nodes[:, None]) < FEW * unknowns else None


def restricted(step, nodes, evaluation):
    """Step whose unknowns are those of `nodes` (N,) bool and of the bodies; trial values of `step` are those of this Step
    too. Of the contact points it has those that touch in an `evaluation` of `step` or that move with the nodes. Its
    system is to be destroyed after use."""
    model, solver = step.model, step.model.solver
    part, soil, near = restriction.restricted(model.soil, step.soil, nodes, solver)
    bodies = tuple(replace(body, contact_pressure=body.contact_pressure[near]) for body in model.bodies)
    pattern = make_pattern(nodes & step.pattern.free.any(axis=1), part.grid.fixed, part.grid.shape)
    system = direct_system(pattern, part, step.system.body_unknowns, solver.linear_tolerance)
    begun = tuple(replace(terms.step, pair=terms.step.pair.near(nodes, terms.contact)) for terms in evaluation.bodies)
    return replace(step, model=replace(model, soil=part, bodies=bodies), soil=soil, pattern=pattern, system=system,
                   bodies=begun, carried=CarriedTangent())
