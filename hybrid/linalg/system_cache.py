"""Keeps numbering and pattern for as long as the set of active nodes stays the same, matrices while that of light ones
does too."""

import numpy as np

from hybrid.linalg.petsc import BlockSystem
from hybrid.linalg.precond_pattern import ReducedMatrix, reduced_entries
from hybrid.linalg.stencil_pattern import make_pattern


class Systems:
    """Pattern and BlockSystem for the active and light nodes asked for last."""

    def __init__(self, model):
        self._model = model
        self._active, self._light, self._pattern, self._system = None, None, None, None

    def renew(self, model):
        """Go on with another model."""
        self._model, self._active = model, None

    def destroy(self):
        """Release the matrices: PETSc keeps what Python lets go of."""
        if self._system:
            self._system.destroy()
        self._active, self._pattern, self._system = None, None, None

    def get(self, active, small_support=None):
        """(Pattern, BlockSystem) for active nodes (N,) bool, some of them light (N,) bool."""
        small_support = np.zeros_like(active) if small_support is None else small_support
        known = self._active is not None and np.array_equal(active, self._active)
        krylov = self._model.linear == "krylov"
        if not known or krylov and not np.array_equal(small_support, self._light):
            pattern = self._pattern if known else None
            self.destroy()      # not to hold two at once
            grid = self._model.soil.grid
            self._pattern = pattern or make_pattern(active, grid.fixed, grid.shape)
            self._system = self._made(small_support)
            self._active, self._light = active.copy(), small_support.copy()
        return self._pattern, self._system

    def _made(self, small_support):
        model, pattern = self._model, self._pattern
        near = None
        if model.linear == "krylov":
            near = ReducedMatrix(pattern.indptr, pattern.indices, reduced_entries(pattern, model.soil.grid.shape, small_support))
        return BlockSystem(pattern.indptr, pattern.indices, int(np.count_nonzero(model.body_free)), model.linear,
                           model.linear_tolerance, near, model.soil.law.symmetric)
