"""The block system in PETSc: the only module that knows how it is stored and solved.

    | K_uu  K_uw | |δu|     |R_u|
    | K_wu  K_ww | |δw| = - |R_w|

K_uu is sparse (AIJ) over the free soil unknowns. The other blocks are dense, with one row or column for each free
unknown of the bodies. The preconditioner is the upper block factorisation: an approximate inverse M^-1 of K_uu and the
exact Schur complement K_ww - K_wu M^-1 K_uw, formed with one application of M^-1 per body unknown.

M^-1 is a symmetric Gauss-Seidel (SSOR) sweep over the blocks of nodes, or ILU(0); if GMRES stagnates with one of them,
the other is used. If it converges with neither, linear = "auto" allows the first more iterations, then takes a direct
factor (MUMPS, of all of K_uu), and remembers which of them solved the system (`hybrid.linalg.solver_choice`). A sweep
needs no factor, preserves positive definiteness and does not converge more slowly with stiff contact, so it is used
first where the soil's tangent is symmetric. In sand, to a relative residual of 1e-2, sweeps over blocks take 13 GMRES
iterations, sweeps over rows 14 (19 600 unknowns); with 103 000 unknowns they take 15 to 25, and 25 to 28.

Both are computed from a part of the entries (`hybrid.linalg.precond_pattern`): with only the entries that couple nodes
of one cell, the factor of 15 600 unknowns takes 0.04 s instead of 0.35 s, and GMRES needs 8 iterations instead of 4 to
1e-3, in the same time.

All matrices stay allocated while the pattern is unchanged; values are edited in place. Options prefix: "hybrid_".

Equations: FORMULATION (2), (47).
"""

from contextlib import contextmanager

import numpy as np
from petsc4py import PETSc

from hybrid.linalg.solver_choice import SolverChoice
from hybrid.linalg.stencil_pattern import diagonal_places
from hybrid.runtime.errors import StepError

DIRECT = {"ksp_type": "preonly", "pc_type": "lu", "pc_factor_mat_solver_type": "mumps"}
# A node that domains hardly overlap has a row with very small entries and an even smaller pivot. Elimination without
# pivoting does not depend on the scale of rows and columns, so only a pivot of exactly zero is an error.
INCOMPLETE = {"ksp_type": "preonly", "pc_type": "ilu", "pc_factor_zeropivot": 0.0}
# A forward and a backward sweep, PETSc's default. PETSc inverts the diagonal block of each node (its rows have the same
# sparsity) unless a shift or relaxation is set, but treats a scalar pivot below 2e-14 as zero: diagonals are raised to
# SMALLEST_DIAGONAL [N/m]. An exact zero would be an error; it is replaced by ZERO_DIAGONAL, with which sweeps diverge.
SWEEPS = {"ksp_type": "preonly", "pc_type": "sor"}
SMALLEST_DIAGONAL, ZERO_DIAGONAL = 1e-13, 1e-300
SWITCH_AFTER = 60       # iterations after which the other preconditioner is used
MAX_ITERATIONS = 300
SINGULAR = "finds the matrix singular"
COMM = PETSc.COMM_SELF
CHOSEN_BY_USER = set(PETSc.Options().getAll())  # PETSC_OPTIONS of the environment take precedence


class BlockSystem:
    """Storage and solution of the block system for one sparsity pattern.

    reduced: ReducedMatrix from which sweeps and the incomplete factor are computed, None for all of K_uu; sweeps:
    whether sweeps are tried before the incomplete factor; choice: SolverChoice, which outlives this system.
    values: entries of K_uu in the order of the pattern; uw (n, m), wu (m, n), ww (m, m): dense blocks.
    """

    def __init__(self, indptr, indices, body_unknowns, linear, tolerance, reduced=None, sweeps=False,
                 choice=None):
        n, m = len(indptr) - 1, body_unknowns
        self.values = np.empty(len(indices))    # filled by the first assembly
        self.uw, self.wu = np.zeros((n, m), order="F"), np.zeros((m, n), order="F")
        self.ww, self._schur = np.zeros((m, m), order="F"), np.zeros((m, m), order="F")
        self.soil_unknowns, self.body_unknowns = n, m
        self._tolerance, self._choice = tolerance, choice or SolverChoice(linear)
        self._coupled, self._blocks, self._reduced, self._prepared = bool(n and m), [], None, set()
        if n:
            self._uu = PETSc.Mat().createAIJWithArrays((n, n), (indptr, indices, self.values), comm=COMM)
            self._blocks.append(self._uu)
            if reduced is not None and linear != "direct":
                self._reduced = reduced
                # y += A x, which nested matrices use, takes PETSc a third longer with inodes (groups of rows with the
                # same sparsity) than row by row
                self._uu.setOption(PETSc.Mat.Option.USE_INODES, False)
                self._uu_reduced = PETSc.Mat().createAIJWithArrays(
                    (n, n), (reduced.indptr, reduced.indices, reduced.values), comm=COMM)
        if m:
            self._ww = PETSc.Mat().createDense((m, m), array=self.ww, comm=COMM)
            self._blocks.append(self._ww)
        if self._blocks:
            self._join()
            exact = linear == "direct" or not n
            first, last = (SWEEPS, INCOMPLETE) if sweeps else (INCOMPLETE, SWEEPS)
            inverses = [] if exact else [(first, SWITCH_AFTER), (last, MAX_ITERATIONS)]
            inverses += [(first, MAX_ITERATIONS)] if not exact and linear == "auto" else []
            inverses += [(DIRECT, MAX_ITERATIONS)] if exact or linear == "auto" else []
            self._solvers, self._current = [self._krylov(*inverse) for inverse in inverses], 0
            self._direct = len(inverses) - 1 if n and inverses[-1][0] is DIRECT else None
            self._order, self._failed = [], ""
            self._x, self._b = self._matrix.createVecs()
            given = (indptr, indices) if self._reduced is None else (reduced.indptr, reduced.indices)
            self._diagonal = diagonal_places(*given) if len(inverses) > 1 else np.zeros(0, int)

    def _join(self):
        """Form the system matrix and the preconditioner's matrix; with bodies and soil both are nested matrices."""
        n, m = self.soil_unknowns, self.body_unknowns
        self._matrix = self._blocks[0]
        self._preconditioner = self._matrix if self._reduced is None else self._uu_reduced
        if self._coupled:
            uw = PETSc.Mat().createDense((n, m), array=self.uw, comm=COMM)
            wu = PETSc.Mat().createDense((m, n), array=self.wu, comm=COMM)
            self._sp = PETSc.Mat().createDense((m, m), array=self._schur, comm=COMM)
            self._blocks += [uw, wu]
            for block in (*self._blocks, self._preconditioner, self._sp):
                block.assemble()
            soil = self._preconditioner
            self._matrix = PETSc.Mat().createNest([[self._uu, uw], [wu, self._ww]], comm=COMM)
            self._preconditioner = PETSc.Mat().createNest([[soil, uw], [wu, self._ww]], comm=COMM)

    def _krylov(self, inverse, most):
        """(KSP with at most `most` iterations, its options); inverse: PETSc options of M^-1."""
        ksp = PETSc.KSP().create(COMM)
        ksp.setOptionsPrefix("hybrid_")
        ksp.setOperators(*self._operators(inverse is DIRECT))
        ksp.setType("gmres")
        ksp.setGMRESRestart(100)
        ksp.setPCSide(PETSc.PC.Side.RIGHT)
        ksp.setTolerances(rtol=self._tolerance, atol=0.0, max_it=most)
        pc = ksp.getPC()
        if self._coupled:
            pc.setType("fieldsplit")
            u, w = self._matrix.getNestISs()[0]
            pc.setFieldSplitIS(("u", u), ("w", w))
            pc.setFieldSplitType(PETSc.PC.CompositeType.SCHUR)
            pc.setFieldSplitSchurFactType(PETSc.PC.SchurFactType.UPPER)
            pc.setFieldSplitSchurPreType(PETSc.PC.SchurPreType.USER, self._sp)
            options = {f"fieldsplit_u_{key}": value for key, value in inverse.items()}
            options |= {"fieldsplit_w_ksp_type": "preonly", "fieldsplit_w_pc_type": "lu"}
        elif self.soil_unknowns:
            options = {**inverse, "ksp_type": "gmres"}
        else:
            options = {"ksp_type": "preonly", "pc_type": "lu"}
        with _options_set(options):
            ksp.setFromOptions()
        return ksp, options

    def _operators(self, direct):
        """Matrix, and what the preconditioner is made from."""
        return self._matrix, self._matrix if direct else self._preconditioner

    def destroy(self):
        """Release the memory of matrices and factors now, not when Python's garbage collector runs."""
        if self._blocks:
            for ksp in (self._solvers[number][0] for number in self._prepared):
                if self._coupled:  # PETSc keeps the inner solvers of a Schur field split, and their factors
                    ksp.getPC().getFieldSplitSubKSP()[0].getPC().reset()
                ksp.reset()
            things = [ksp for ksp, _ in self._solvers]
            things += [self._preconditioner, self._matrix, *self._blocks, self._x, self._b]
            things += [self._uu_reduced] if self._reduced is not None else []
            for thing in things:
                thing.destroy()

    def clear(self):
        """Set all blocks except K_uu to zero, because assembly adds to them; K_uu is overwritten."""
        for block in (self.uw, self.wu, self.ww):
            block[...] = 0.0

    def factor(self):
        """Prepare the preconditioner after assembly."""
        if self._reduced is not None:
            self._reduced.update(self.values)
            _lift(self._reduced.values, self._diagonal)
            self._uu_reduced.assemble()
        else:
            _lift(self.values, self._diagonal)
        for block in self._blocks:
            block.assemble()    # also discards the inverse of the diagonal that PETSc stores for sweeps
        for matrix in (self._matrix, self._preconditioner):
            matrix.stateIncrease()
        first = self._choice.begin(self.soil_unknowns, self._direct)
        self._order = [*range(first, len(self._solvers)), *range(first)]
        self._prepare(first)

    def _prepare(self, number):
        """Make solver `number` the current one and set it up with the current values."""
        (ksp, options), self._current, self._failed = self._solvers[number], number, ""
        ksp.setOperators(*self._operators(number == self._direct))
        with _options_set(options):  # the parts of a field split read their options at the first set-up
            ksp.setUp()
        self._prepared.add(number)
        if number == self._direct:
            self._choice.factors += 1
            self._failed = self._factor_failure(ksp)
        if self._coupled and not self._failed:
            self._form_schur(ksp)

    def _factor_failure(self, ksp):
        """Why there is no direct factor, "" if there is one."""
        if self._coupled:
            ksp = ksp.getPC().getFieldSplitSubKSP()[0]
            ksp.setUp()
        try:
            code = ksp.getPC().getFactorMatrix().getMumpsInfog(1)
        except PETSc.Error:     # the user chose another package
            return ""
        if code >= 0:
            return ""
        known = {-6: SINGULAR, -10: SINGULAR, -9: "runs out of memory", -13: "runs out of memory"}
        return f"the direct factor {known.get(code, f'fails with error {code} of MUMPS')}"

    def _form_schur(self, ksp):
        """Form S = K_ww - K_wu M^-1 K_uw. Columns of K_uw are zero for bodies without contact, and are skipped."""
        soil = ksp.getPC().getFieldSplitSubKSP()[0]
        x, b = self._uu.createVecs()
        self._schur[...] = self.ww
        for a in range(self.body_unknowns):
            if np.any(self.uw[:, a]):
                b.array = self.uw[:, a]
                soil.solve(b, x)
                with np.errstate(invalid="ignore"):     # a sweep over a singular row is not finite
                    self._schur[:, a] -= self.wu @ x.array
        self._sp.stateIncrease()

    def solve(self, soil, body, tolerance=None):
        """Increments (n,), (m,) that cancel residuals (n,), (m,), and the number of Krylov iterations.

        tolerance: relative tolerance of the Krylov method, None for that of the system.
        Raises StepError when no solver converges: each fails, or the direct factor does not fit in memory.
        """
        if not self._blocks:
            return np.zeros(0), np.zeros(0), 0
        self._b.array = -np.concatenate([soil, body])
        total, failures = 0, {}
        while True:
            failure, count = self._attempt(self._solvers[self._current][0], tolerance)
            total += count
            if not failure:
                self._choice.solved(self._current, self._order[0], self._direct)
                solution = self._x.array
                return solution[:len(soil)].copy(), solution[len(soil):].copy(), total
            failures[self._current] = failure
            self._next(failures)

    def _next(self, failures):
        """Prepare the solver that follows the current one; failures: texts by number of solver. StepError if none
        follows."""
        rest = self._order[self._order.index(self._current) + 1:]
        if rest[:1] == [self._direct] and (refusal := self._choice.refusal(self.soil_unknowns)):
            failures[self._direct], rest = refusal, rest[1:]
        if not rest:    # of the iterative inverses, the last one; then the direct factor
            iterative = [failures[number] for number in sorted(failures) if number != self._direct][-1:]
            direct = [failures[self._direct]] if self._direct in failures else []
            raise StepError(f"linear solver: {', and '.join(iterative + direct)}")
        self._prepare(rest[0])

    def _attempt(self, ksp, tolerance):
        """(Reason of failure, "" if there is none; number of Krylov iterations)."""
        if self._failed:
            return self._failed, 0
        if "hybrid_ksp_rtol" not in CHOSEN_BY_USER:
            _, *others = ksp.getTolerances()
            ksp.setTolerances(self._tolerance if tolerance is None else tolerance, *others)
        try:
            ksp.solve(self._b, self._x)
        except PETSc.Error:
            if self._current == self._direct:
                return f"the direct factor {SINGULAR}", 0
            return "a diagonal block is singular", 0
        reason, count = ksp.getConvergedReason(), ksp.getIterationNumber()
        if reason < 0 or not np.isfinite(self._x.array).all():
            if self._current == self._direct:
                return f"the direct factor {SINGULAR} or nearly so (PETSc reason {reason})", count
            return f"no convergence in {count} iterations, PETSc reason {reason}", count
        return "", count


def _lift(values, places):
    """Raise the diagonal entries `values[places]` that PETSc would treat as zero in a sweep, keeping their sign."""
    diagonal = values[places]
    if (small := np.abs(diagonal) < SMALLEST_DIAGONAL).any():
        raised = np.copysign(SMALLEST_DIAGONAL, diagonal[small])
        values[places[small]] = np.where(diagonal[small] == 0.0, ZERO_DIAGONAL, raised)


@contextmanager
def _options_set(options):
    """Set options with the prefix "hybrid_", except those that the user has set, inside a `with` block only: PETSc's
    database is global, and the options would also apply to the next system of the process."""
    database = PETSc.Options("hybrid_")
    own = [key for key in options if f"hybrid_{key}" not in CHOSEN_BY_USER]
    for key in own:
        database[key] = options[key]
    try:
        yield
    finally:
        for key in own:
            database.delValue(key)
