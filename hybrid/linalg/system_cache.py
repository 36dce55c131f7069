"""Reuse of the sparsity pattern while the set of active nodes is unchanged, of the matrices while the set of nodes with
small support is unchanged too, and of the tangent in them while it serves."""

import math

import numpy as np

from hybrid.linalg.petsc import BlockSystem
from hybrid.linalg.precond_pattern import ReducedMatrix, reduced_entries
from hybrid.linalg.solver_choice import SolverChoice
from hybrid.linalg.stencil_pattern import make_pattern
from hybrid.runtime.comm import anywhere

COPIED = 5000       # unknowns up to which each process has the whole system that is to be factored
FAILURES = 2        # of carried tangents until none is carried any more


class CarriedTangent:
    """Whether the tangent that a system holds serves in the next increment, if it is as long: until FAILURES have not."""

    def __init__(self):
        self._length, self._failures = None, 0

    def drop(self):
        """Forget it: the system holds another one."""
        self._length = None

    def take(self, length):
        """Whether the first update of an increment of this `length` [s] is made with it. It is then dropped."""
        serves = self._length is not None and math.isclose(length, self._length, rel_tol=1e-9)
        self.drop()
        return serves

    def fail(self):
        """Count one that has not served."""
        self._failures += 1

    def keep(self, length):
        """Carry it from an increment of this `length` [s]."""
        self._length = length if self._failures < FAILURES else None


class Systems:
    """Pattern and BlockSystem of the last call of `get`, and the CarriedTangent in it; `choice`: SolverChoice of all its
    systems."""

    def __init__(self, model):
        self._model = model
        self._active, self._small_support, self._pattern, self._system = None, None, None, None
        self.choice, self.carried = _choice(model), CarriedTangent()

    def renew(self, model):
        """Use another model, whose pattern may differ, from the next call of `get` on."""
        if _kind(model) != _kind(self._model):
            self.choice = _choice(model)
        self._model, self._active = model, None

    def follow_points(self, model):
        """Use a model whose points have moved from process to process, or its nodes in space, and nothing else is new."""
        self._model = model

    def assemble_afresh(self):
        """Carry no tangent to the next increment."""
        self.carried = CarriedTangent()

    def destroy(self):
        """Release the matrices. PETSc keeps them until they are destroyed, even if Python holds no reference."""
        if self._system:
            self._system.destroy()
        self._active, self._pattern, self._system = None, None, None

    def get(self, active, small_support=None):
        """(Pattern, BlockSystem) for active nodes (N,) bool, some of them with small support (N,) bool."""
        small_support = np.zeros_like(active) if small_support is None else small_support
        same_nodes = self._active is not None and np.array_equal(active, self._active)
        reduced = self._model.solver.linear != "direct"
        same = same_nodes and not (reduced and not np.array_equal(small_support, self._small_support))
        if anywhere([not same]):    # all processes make theirs together
            pattern = self._pattern if same_nodes else None
            self.destroy()      # frees the old matrices before the new ones are allocated
            grid = self._model.soil.grid
            self._pattern = pattern or make_pattern(active, grid.fixed, grid.shape)
            self._system = self._make_system(small_support)
            self.carried.drop()
            self._active, self._small_support = active.copy(), small_support.copy()
        return self._pattern, self._system

    def _make_system(self, small_support):
        model, pattern, solver = self._model, self._pattern, self._model.solver
        reduced, symmetric = None, not anywhere([not model.soil.law.symmetric])     # of the points of all processes
        if solver.linear != "direct":
            reduced = ReducedMatrix(pattern.indptr, pattern.indices,
                                    reduced_entries(pattern, model.soil.grid.shape, small_support))
        if _shared(pattern, model.soil.grid):
            from hybrid.linalg.petsc_ranks import DistributedSystem  # imports MPI

            return DistributedSystem(pattern, model.soil.grid, model.body_unknowns, solver.linear_tolerance, reduced,
                                     symmetric, self.choice)
        return BlockSystem(pattern.indptr, pattern.indices, model.body_unknowns, solver.linear,
                           solver.linear_tolerance, reduced, symmetric, self.choice)


def direct_system(pattern, soil, body_unknowns, tolerance):
    """System of the few unknowns of a Pattern, solved with a direct factor."""
    if not _shared(pattern, soil.grid):
        return BlockSystem(pattern.indptr, pattern.indices, body_unknowns, "direct", tolerance)
    from hybrid.linalg.petsc_copies import CopiedSystem
    from hybrid.linalg.petsc_ranks import DistributedSystem, number_unknowns

    if soil.grid.count_unknowns(pattern.free) <= COPIED:
        own, numbers = number_unknowns(pattern.free, soil.grid)
        return CopiedSystem(pattern, numbers, own, body_unknowns, tolerance)
    return DistributedSystem(pattern, soil.grid, body_unknowns, tolerance, None, False, SolverChoice("direct"))


def _shared(pattern, grid):
    """Whether several processes have unknowns of the soil; those of the bodies alone are solved for by each of them."""
    return grid.nodes is not None and grid.count_unknowns(pattern.free) > 0


def _kind(model):
    """What a SolverChoice depends on: `solver.linear`, and whether an axis is collapsed."""
    return model.solver.linear, bool(model.soil.grid.collapsed.any())


def _choice(model):
    return SolverChoice(*_kind(model))
