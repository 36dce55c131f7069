"""Which solver of the block system a tangent goes to, by what was counted in the run.

The solvers (`hybrid.linalg.petsc`) are GMRES with one of three approximate inverses of the soil block, and a direct
factor. Costs are in GMRES iterations, the unit in which they are counted, not in seconds, so that a run repeats itself
bit for bit on every machine. For n soil unknowns, m body unknowns and a reduction of the residual by D decades for each
tangent (with all its right-hand sides):

| solver       | set-up           | solution                     |
|--------------|------------------|------------------------------|
| SSOR         | 0                | iterations counted           |
| ILU0         | 5                | iterations counted           |
| ILU0_SHIFTED | 5                | iterations counted           |
| DIRECT       | f + 15 m         | 15 for a reduction by 1000   |

f is √n with a collapsed axis: a factor of 3 600 and 25 600 unknowns takes as long as 100 and 160 iterations. In space it is
n / 52, at least 300 or 5 √n: a factor of 4 300, 6 900, 19 100, 22 500, 52 200 unknowns takes as long as 280, 320, 370, 375,
1 010 iterations. The work of a factor goes with n², that of an iteration with n, but as long as a matrix fits in the
processor's cache an iteration takes less (von Mises, F-bar, MUMPS, iterations on two threads).

A tangent goes to the cheapest. Iterations are kept by decade of the last solution with each solver; one that has not
been tried counts as PRIOR, one that has failed as infinite. The solver in use is left for one that costs less than 1 /
MARGIN of it. A solver that takes MARGIN times what the next one would cost is stopped, at the earliest after LEAST
iterations, and the next one goes on; so a tangent takes at most a few times the cost of the best solver. After RETRY
tangents all is forgotten, as the soil may have changed. Where all have failed but the direct factor, it is forgotten
once factors have cost SOON iterations, twice as many the next time, up to LATE: one iterate that went astray must not
give the whole run to a factor. The more a factor costs, the fewer are computed. Where it finds a pivot of zero, those
that failed are tried again. The counts are part of a checkpoint.
"""

import math

import numpy as np

from hybrid.runtime import comm
from hybrid.runtime.memory import available_memory, direct_factor_memory

SSOR, ILU0, ILU0_SHIFTED, DIRECT = range(4)
SET_UP = 5.0                    # [iterations] of an incomplete factor
DIRECT_SOLUTION = 15.0          # [iterations] of a solution with a direct factor
PRIOR = (0.0, 10.0, 20.0)       # iterations a decade of the first, second and third solver, as long as it is not tried
DECADES = 3.0                   # of a tangent, before any is known
MARGIN = 1.5
LEAST, MOST = 60, 1000          # iterations before the next solver is tried; where no other solver is left
# Iterations of a solver that has failed before, where the direct factor finds a pivot of zero: nodes without stiffness,
# such as those of sand that has opened, make the matrix singular, and a Krylov method leaves them where they are.
LAST = 200
RETRY = 50      # tangents
# [iterations] A trial of all solvers before the direct factor costs about 400: two fifths of what factors have cost at
# first, a twentieth in the end.
SOON, LATE = 1000.0, 8000.0
FITS = 0.8      # of the memory that is left; the estimate is that of a block, and the step needs some memory too
ASKED = 10      # tangents after which the system is asked again how much memory is left, which takes it 2 ms


class SolverChoice:
    """linear: value of `solver.linear`; plane: whether an axis is collapsed, so that a factor has little fill.

    direct: whether the last system was solved with a direct factor; factors: number of tangents given to it.
    """

    def __init__(self, linear, plane=False):
        self.linear, self.plane, self.factors, self.direct = linear, plane, 0, False
        self._rates = np.full(3, np.nan)    # iterations a decade; nan: not tried, inf: failed
        self._decades, self._pending, self._tangents, self._last = DECADES, 0.0, 0, -1
        self._until, self._soon = RETRY, SOON   # tangents until all is forgotten; cost until then, the next time all fail
        self._factor = 0.0      # [iterations] cost of a direct factor of the last tangent
        self._fits = self._fits_for = None      # whether a direct factor fits, and of how many unknowns

    def memory(self):
        """(9,) what is remembered, for a checkpoint."""
        return np.array([*self._rates, self._decades, self._pending, self._tangents, self._last, self._until, self._soon])

    def restore(self, memory):
        """Go on from the `memory` (9,) of another SolverChoice."""
        self._rates, (self._decades, self._pending) = np.array(memory[:3], float), map(float, memory[3:5])
        self._tangents, self._last, self._until = map(int, memory[5:8])
        self._soon = float(memory[8])

    def begin(self, unknowns, bodies=0, symmetric=False):
        """Order of the solvers for the next tangent, [(solver, most iterations), ...], the cheapest first.

        unknowns: of the soil; bodies: unknowns of bodies; symmetric: whether sweeps are tried before an incomplete
        factor. The direct factor is left out if it does not fit in memory.
        """
        if self.linear == "direct" or not unknowns:
            return [(DIRECT, MOST)]
        if self._pending:
            self._decades, self._pending = 0.5 * (self._decades + self._pending), 0.0
        self._tangents += 1
        if self._tangents > self._until:
            self._rates[:], self._tangents, self._last, self._until = np.nan, 1, -1, RETRY
        if not self._fits or self._tangents % ASKED == 1 or unknowns != self._fits_for:
            self._fits, self._fits_for = not self.refusal(unknowns), unknowns
        fits = self._fits
        costs = self._costs(unknowns, bodies, symmetric)
        self._factor = costs[DIRECT]
        ranked = sorted(costs, key=lambda solver: costs[solver] / (MARGIN if solver == self._last else 1.0))
        order = [solver for solver in ranked if math.isfinite(costs[solver]) and (solver != DIRECT or fits)]
        limits = [_limit(costs[after]) for after in order[1:]] + [MOST]
        known = [*zip(order, limits[:len(order)], strict=True)]
        if not fits:
            return known + [(SSOR, MOST)]
        return known + [(solver, LAST) for solver in ranked if math.isinf(costs[solver])]

    def _costs(self, unknowns, bodies, symmetric):
        """{solver: iterations that the next tangent is expected to cost}."""
        usual = [SSOR, ILU0, ILU0_SHIFTED] if symmetric else [ILU0, SSOR, ILU0_SHIFTED]
        costs = {}
        for solver, prior in zip(usual, PRIOR, strict=True):
            rate = self._rates[solver]
            costs[solver] = (solver != SSOR) * SET_UP + self._decades * (prior if np.isnan(rate) else rate)
        costs[DIRECT] = _factor_cost(unknowns, self.plane) + DIRECT_SOLUTION * (bodies + self._decades / DECADES)
        return costs

    def solved(self, solver, iterations, tolerance):
        """Remember that a `solver` reached a relative `tolerance` in so many iterations."""
        decades = max(-math.log10(tolerance), 0.5)
        if solver != DIRECT:
            self._rates[solver], self._soon = iterations / decades, SOON
        self._pending, self._last, self.direct = self._pending + decades, solver, solver == DIRECT

    def failed(self, solver):
        """Remember that a `solver` did not converge."""
        if solver != DIRECT:
            self._rates[solver] = np.inf
            if np.isinf(self._rates).all():
                self._tangents, self._until = 1, min(math.ceil(self._soon / self._factor), RETRY)
                self._soon = min(2 * self._soon, LATE)

    def describe(self, failures, unknowns):
        """Text from {solver: reason of its failure}: the last iterative solver, then the direct factor, or why there was
        none for so many unknowns."""
        iterative = [text for solver, text in failures.items() if solver != DIRECT][-1:]
        direct = failures.get(DIRECT) or self.refusal(unknowns)
        return ", and ".join(iterative + [direct] * bool(direct))

    def refusal(self, unknowns):
        """Why a direct factor of so many unknowns is not taken; empty if its estimated memory fits."""
        need, left = direct_factor_memory(unknowns, self.plane), comm.minimum([FITS * available_memory()])
        if self.linear == "direct" or need <= left:
            return ""
        return (f"a direct factor does not fit: it needs about {need / 2**20:.0f} MiB of memory, limit "
                f"{left / 2**20:.0f} MiB, {FITS:g} of what is left")


class Single(SolverChoice):
    """Gives every tangent to one `solver`, for at most 300 iterations: for measurements and tests."""

    def __init__(self, solver):
        super().__init__("auto")
        self._order = [(solver, 300)]

    def begin(self, *_):
        return self._order


def _factor_cost(unknowns, plane):
    """[iterations] of a direct factor of so many soil unknowns."""
    root = math.sqrt(unknowns)
    return root if plane else max(min(5.0 * root, 300.0), unknowns / 52.0)


def _limit(cost):
    """Most iterations of a solver if the next one has this `cost`."""
    return int(min(max(MARGIN * cost, LEAST), MOST))
