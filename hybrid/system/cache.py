"""Keeps the numbering, pattern and matrices for as long as the set of active nodes stays the same."""

import numpy as np

from hybrid.system.pattern import make_pattern
from hybrid.system.petsc import BlockSystem

# An anchor dragged through cells that double: late, in sand that has flowed, the factor takes 34 iterations a solution
# and sweeps 9 (19 600 unknowns, to 1e-2); in the first 45 steps 5 and 7. The near entries alone are a poor stand-in
# there, even with an exact factor (82 iterations, 103 000 unknowns); sweeps look no farther than a node. With cells of
# one size it is the factor that takes fewer: 9 to 14 against 15 to 29 (sand, 20 000 unknowns, to 1e-3).
COARSER = 1.6


class Systems:
    """Pattern and BlockSystem for the active nodes asked for last."""

    def __init__(self, model):
        self._model = model
        self._active, self._current = None, None
        self.rebuilt = 0

    def renew(self, model):
        """Go on with another model."""
        self._model, self._active = model, None

    def destroy(self):
        """Release the matrices: PETSc keeps what Python lets go of."""
        if self._current:
            self._current[1].destroy()
        self._active, self._current = None, None

    def get(self, active):
        """(Pattern, BlockSystem) for active nodes (N,) bool."""
        if self._active is None or not np.array_equal(active, self._active):
            self.destroy()      # not to hold two at once
            grid, model = self._model.soil.grid, self._model
            pattern = make_pattern(active, grid.fixed, grid.shape)
            unknowns = int(np.count_nonzero(model.body_free))
            near = pattern.near_part(model.soil.ghost_factor > 0) if model.linear == "krylov" else None
            self._current = pattern, BlockSystem(
                pattern.indptr, pattern.indices, unknowns, model.linear, model.linear_tolerance, near,
                _sweeps_first(model.soil))
            self._active = active.copy()
            self.rebuilt += 1
        return self._current


def _sweeps_first(soil):
    """Whether sweeps are to stand for the inverse of the soil block rather than an incomplete factor: where its tangent
    is symmetric, or where neighbouring cells differ by more than COARSER."""
    cells = [np.diff(axis) for axis in soil.grid.axes]
    return soil.law.symmetric or any(
        (np.maximum(a[1:] / a[:-1], a[:-1] / a[1:]) > COARSER).any() for a in cells)
