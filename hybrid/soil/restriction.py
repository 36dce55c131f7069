"""The soil that a few nodes feel, as a soil and a step of its own on the same grid."""

from dataclasses import replace

import numpy as np

from hybrid.grid.colouring import make_slabs
from hybrid.grid.numbering import node_number
from hybrid.laws.user import is_of_user
from hybrid.runtime.jit import njit
from hybrid.soil.basis import Basis
from hybrid.soil.split_merge import select
from hybrid.soil.workspace import SoilWorkspace
from hybrid.state import Population


def can_be_restricted(soil):
    """Whether the law of a Soil can be had for some of its points alone."""
    return not is_of_user(soil.law)


def restricted(soil, step, nodes, solver):
    """(Soil, SoilStep, numbers) of the points in whose support any of `nodes` (N,) bool lies: forces and tangents at these
    nodes are those of all points. solver: as of SoilWorkspace."""
    near = np.flatnonzero(_near(step.basis.first, step.basis.count, soil.grid.shape, nodes))
    few = select(Population(step.points, soil.constants, soil.law.rows), near)
    part = replace(soil, constants=few.constants, law=soil.law.with_rows(few.rows))
    basis = Basis(*(values[near] for values in step.basis))
    mean = step.mean and Basis(*(values[near] for values in step.mean))
    return part, replace(step, points=few.points, basis=basis, slabs=make_slabs(basis.first, soil.grid.shape), mean=mean,
                         workspace=SoilWorkspace(part, solver)), near


@njit(cache=True)
def _near(first, count, shape, nodes):
    """(n,) bool, points in whose support any of `nodes` lies."""
    near = np.zeros(len(first), np.bool_)
    for p in range(len(first)):
        for a in range(count[p, 0]):
            for b in range(count[p, 1]):
                for c in range(count[p, 2]):
                    near[p] |= nodes[node_number(shape, first[p, 0] + a, first[p, 1] + b, first[p, 2] + c)]
    return near
