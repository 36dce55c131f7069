"""Arrays of the block system, and its solvers tried in turn: what is the same for one process and for several.

    | K_uu  K_uw |
    | K_wu  K_ww |      entries of K_uu in the order of its pattern; the other blocks dense
"""

import numpy as np

from hybrid.runtime.errors import StepError


class Blocks:
    """values (nnz,): entries of K_uu, filled by the first assembly; uw (n, m), wu (m, n), ww (m, m): dense blocks."""

    def __init__(self, entries, unknowns, body_unknowns):
        n, m = unknowns, body_unknowns
        self.values = np.empty(entries)
        self.uw, self.wu = np.zeros((n, m), order="F"), np.zeros((m, n), order="F")
        self.ww = np.zeros((m, m), order="F")

    def clear(self):
        """Set all blocks except K_uu to zero, because assembly adds to them; K_uu is overwritten."""
        for block in (self.uw, self.wu, self.ww):
            block[...] = 0.0


class SolversInTurn(Blocks):
    """A block system whose solvers are tried in the order of a SolverChoice.

    A subclass has `soil_unknowns` and `body_unknowns` of all processes, and the methods

    _set_up(solver)             make it ready for the current values; (why it cannot be, "" if it can)
    _attempt(solver, most, tolerance)   (why it fails, "" if it does not; number of Krylov iterations, at most `most`)
    """

    def __init__(self, entries, unknowns, body_unknowns, choice, sweeps, tolerance):
        super().__init__(entries, unknowns, body_unknowns)
        self._choice, self._sweeps, self._tolerance = choice, sweeps, tolerance
        self._order, self._at, self._failed = [], 0, ""

    def _begin(self):
        """Set up the first solver for the values assembled."""
        self._order = self._choice.begin(self.soil_unknowns, self.body_unknowns, self._sweeps)
        self._go_to(0)

    def _go_to(self, at):
        self._at = at
        self._failed = self._set_up(self._order[at][0])

    def _solve(self, tolerance):
        """Number of Krylov iterations in all, until a solver converges; tolerance: relative, None for that of the system.

        Raises StepError when none does: each fails, or the direct factor does not fit in memory.
        """
        tolerance = self._tolerance if tolerance is None else tolerance
        total, failures = 0, {}
        while True:
            solver, most = self._order[self._at]
            failure, count = (self._failed, 0) if self._failed else self._attempt(solver, most, tolerance)
            total += count
            if not failure:
                if self.soil_unknowns:
                    self._choice.solved(solver, count, tolerance)
                return total
            failures[solver] = failure
            self._choice.failed(solver)
            if self._at + 1 == len(self._order):
                raise StepError(f"linear solver: {self._choice.describe(failures, self.soil_unknowns)}")
            self._go_to(self._at + 1)
