"""Keeps the numbering, pattern and matrices for as long as the sets of active and of light nodes stay the same."""

import numpy as np

from hybrid.system.pattern import make_pattern
from hybrid.system.petsc import BlockSystem


class Systems:
    """Pattern and BlockSystem for the active and light nodes asked for last."""

    def __init__(self, model):
        self._model = model
        self._active, self._light, self._current = None, None, None
        self.rebuilt = 0

    def renew(self, model):
        """Go on with another model."""
        self._model, self._active = model, None

    def destroy(self):
        """Release the matrices: PETSc keeps what Python lets go of."""
        if self._current:
            self._current[1].destroy()
        self._active, self._current = None, None

    def get(self, active, light=None):
        """(Pattern, BlockSystem) for active nodes (N,) bool, some of them light."""
        light = np.zeros_like(active) if light is None else light
        if self._active is None or not (np.array_equal(active, self._active) and np.array_equal(light, self._light)):
            self.destroy()      # not to hold two at once
            grid, model = self._model.soil.grid, self._model
            pattern = make_pattern(active, grid.fixed, grid.shape, light)
            unknowns = int(np.count_nonzero(model.body_free))
            near = pattern.near_part() if model.linear == "krylov" else None
            self._current = pattern, BlockSystem(
                pattern.indptr, pattern.indices, unknowns, model.linear, model.linear_tolerance, near,
                model.soil.law.symmetric)
            self._active, self._light = active.copy(), light.copy()
            self.rebuilt += 1
        return self._current
