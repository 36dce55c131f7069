"""Which solver of the block system is tried first for a tangent, remembered from one pattern to the next.

With `solver.linear = "auto"` the solvers (`hybrid.linalg.petsc`) are tried in this order, each where the one before it
does not converge:

    0, 1    sweeps and the incomplete factor, in the order of "krylov"
    2       the first of them again, for more iterations
    3       the direct factor, if its estimated memory fits in what the machine has left

Where one tangent needs solver 2 or 3 the next ones do too, as in clay that flows, so those go to it at once. After
RETRY of them the order is tried from its start: the soil may have changed. The choice is not part of a checkpoint: a
run that is continued begins at the start of the order.
"""

from hybrid.runtime.memory import available_memory, direct_factor_memory

FALLBACK = 2    # number of the first solver that is remembered
# Tangents. Trying 0 to 2 in vain costs 460 Krylov iterations in clay, the time of 1.2 direct factors with 4 900
# unknowns and of 0.8 with 17 900, so that a trial after every 50 factors costs 2 %.
RETRY = 50
FITS = 0.8      # of the memory that is left; the estimate is that of a block, and the step needs some memory too


class SolverChoice:
    """linear: value of `solver.linear`; plane: whether an axis is collapsed, so that a factor has little fill.

    direct: whether the direct factor is remembered; factors: number of tangents given to it, of all patterns.
    """

    def __init__(self, linear, plane=False):
        self.linear, self.plane, self.factors = linear, plane, 0
        self._first, self._left, self.direct = 0, 0, False

    def begin(self, unknowns, direct):
        """Number of the solver that a tangent of so many unknowns goes to first; direct: that of the direct factor,
        None where there is none."""
        first, self._left = self._first if self._left else 0, max(0, self._left - 1)
        return 0 if first == direct and self.refusal(unknowns) else first

    def solved(self, number, first, direct):
        """Remember the `number` of the solver that converged; first: that of the solver tried first."""
        if number != first:
            self._first, self._left = (number, RETRY) if number >= FALLBACK else (0, 0)
        self.direct = direct == number

    def refusal(self, unknowns):
        """Why a direct factor of so many unknowns is not taken; empty if its estimated memory fits."""
        need, left = direct_factor_memory(unknowns, self.plane), FITS * available_memory()
        if self.linear == "direct" or need <= left:
            return ""
        return (f"a direct factor does not fit: it needs about {need / 2**20:.0f} MiB of memory, limit "
                f"{left / 2**20:.0f} MiB, {FITS:g} of what is left")
