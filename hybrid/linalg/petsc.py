"""The block system of one process in PETSc, how it is stored and solved (`petsc_ranks`: that of several).

    | K_uu  K_uw | |δu|     |R_u|
    | K_wu  K_ww | |δw| = - |R_w|

K_uu is sparse (AIJ) over the free soil unknowns. The other blocks are dense, with one row or column for each free
unknown of the bodies. The preconditioner is the upper block factorisation: an approximate inverse M^-1 of K_uu and the
exact Schur complement K_ww - K_wu M^-1 K_uw, formed with one application of M^-1 per body unknown.

M^-1 and the order in which its kinds are tried: `hybrid.linalg.inverses`, `hybrid.linalg.solver_choice`.

All matrices stay allocated while the pattern is unchanged; values are edited in place. Options prefix: "hybrid_".

Equations: FORMULATION (2), (47).
"""

import atexit
import gc
from contextlib import contextmanager
from weakref import WeakSet

import numpy as np
from petsc4py import PETSc

from hybrid.linalg.blocks import SolversInTurn
from hybrid.linalg.inverses import INVERSES, RAISED, lift
from hybrid.linalg.precond_pattern import ReducedMatrix
from hybrid.linalg.product import Product
from hybrid.linalg.solver_choice import DIRECT, ILU0_SHIFTED, MOST, SolverChoice
from hybrid.linalg.stencil_pattern import diagonal_places
from hybrid.runtime.stop_signals import held_back

SINGULAR = "finds the matrix singular"
ZERO_PIVOT = 71         # PETSC_ERR_MAT_LU_ZRPVT
COMM = PETSc.COMM_SELF
CHOSEN_BY_USER = set(PETSc.Options().getAll())  # PETSC_OPTIONS of the environment take precedence
ALIVE = WeakSet()       # systems that have not been destroyed


@atexit.register
def _destroy_all():
    """PETSc ends after Python has, and would then crash in destroying a matrix whose product is written in Python."""
    for system in list(ALIVE):
        system.destroy()
    gc.collect()
    PETSc.garbage_cleanup(COMM)     # what Python has collected and PETSc keeps


class BlockSystem(SolversInTurn):
    """Storage and solution of the block system for one sparsity pattern.

    linear: value of `solver.linear`; tolerance: relative one of GMRES; reduced: ReducedMatrix from which M^-1 is computed,
    None for all of K_uu; sweeps: whether they are tried before ILU(0); choice: SolverChoice, which outlives this system.
    """

    def __init__(self, indptr, indices, body_unknowns, linear, tolerance, reduced=None, sweeps=False,
                 choice=None):
        n, m = len(indptr) - 1, body_unknowns
        super().__init__(len(indices), n, m, choice or SolverChoice(linear), sweeps, tolerance)
        self.soil_unknowns, self.body_unknowns, self._schur = n, m, np.zeros((m, m), order="F")
        self._coupled, self._blocks, self._reduced, self._solvers = bool(n and m), [], None, {}
        self._begun = set()     # solvers that have been set up: those of the parts of a field split exist
        if n:
            self._uu = PETSc.Mat().createAIJWithArrays((n, n), (indptr, indices, self.values), comm=COMM)
            self._blocks.append(self._uu)
            if linear != "direct":
                self._reduced = reduced or ReducedMatrix(indptr, indices, np.ones(len(indices), bool))
                self._product = PETSc.Mat().createPython((n, n), Product(indptr, indices, self.values), comm=COMM)
                self._product.setUp()
                self._uu_reduced = PETSc.Mat().createAIJWithArrays(
                    (n, n), (self._reduced.indptr, self._reduced.indices, self._reduced.values), comm=COMM)
                self._diagonal = diagonal_places(self._reduced.indptr, self._reduced.indices)
        if m:
            self._ww = PETSc.Mat().createDense((m, m), array=self.ww, comm=COMM)
            self._blocks.append(self._ww)
        if self._blocks:
            self._join()
            self._x, self._b = self._matrix.createVecs()
            ALIVE.add(self)

    def _join(self):
        """Form the system matrix, as it is factored and as GMRES applies it, and the preconditioner's matrix; with bodies
        and soil they are nested matrices."""
        n, m = self.soil_unknowns, self.body_unknowns
        soil = [self._blocks[0]] * 3 if self._reduced is None else [self._uu, self._product, self._uu_reduced]
        if self._coupled:
            uw = PETSc.Mat().createDense((n, m), array=self.uw, comm=COMM)
            wu = PETSc.Mat().createDense((m, n), array=self.wu, comm=COMM)
            self._sp = PETSc.Mat().createDense((m, m), array=self._schur, comm=COMM)
            self._blocks += [uw, wu]
            for block in (*self._blocks, soil[2], self._sp):
                block.assemble()
            soil = [PETSc.Mat().createNest([[uu, uw], [wu, self._ww]], comm=COMM) for uu in soil]
        self._matrix, self._applied, self._preconditioner = soil

    def _make_solver(self, solver):
        """(KSP, its options) with the approximate inverse that belongs to a `solver`."""
        ksp, inverse = PETSc.KSP().create(COMM), INVERSES[solver]
        ksp.setOptionsPrefix("hybrid_")
        ksp.setOperators(*self._operators(solver))
        ksp.setType("gmres")
        ksp.setGMRESRestart(100)
        ksp.setPCSide(PETSc.PC.Side.RIGHT)
        ksp.setTolerances(rtol=self._tolerance, atol=0.0, max_it=MOST)
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

    def _operators(self, solver):
        """Matrix that is applied, and what the preconditioner is made from."""
        return (self._matrix, self._matrix) if solver == DIRECT else (self._applied, self._preconditioner)

    def destroy(self):
        """Release the memory of matrices and factors now, not when Python's garbage collector runs. A second call does
        nothing."""
        ALIVE.discard(self)
        if self._blocks:
            for solver, (ksp, _) in self._solvers.items():
                if self._coupled and solver in self._begun:   # PETSc keeps solvers of parts, and their factors
                    ksp.getPC().getFieldSplitSubKSP()[0].getPC().reset()
                ksp.reset()
            things = [ksp for ksp, _ in self._solvers.values()]
            things += [self._preconditioner, self._applied, self._matrix, *self._blocks, self._x, self._b]
            things += [self._uu_reduced, self._product] if self._reduced is not None else []
            for thing in things:
                thing.destroy()
            self._blocks = []

    def factor(self):
        """Prepare the preconditioner after assembly."""
        if not self._blocks:
            return      # no unknowns
        for block in self._blocks:
            block.assemble()
        for matrix in (self._matrix, self._applied):
            matrix.stateIncrease()
        self._begin()

    def _set_up(self, solver):
        if solver not in self._solvers:
            self._solvers[solver] = self._make_solver(solver)
        ksp, options = self._solvers[solver]
        if solver != DIRECT:
            self._fill_reduced(RAISED if solver == ILU0_SHIFTED else 1.0)
        ksp.setOperators(*self._operators(solver))
        with _options_set(options):  # the parts of a field split read their options at the first set-up
            try:
                ksp.setUp()
            except PETSc.Error as error:
                if error.ierr != ZERO_PIVOT:
                    raise
                return _singular(solver)    # in the dense factor, of a body that nothing supports
        self._begun.add(solver)
        if solver == DIRECT and self.soil_unknowns:
            self._choice.factors += 1
            if failure := self._factor_failure(ksp):
                return failure
        if self._coupled:
            self._form_schur(ksp)
        return ""

    def _fill_reduced(self, raised):
        """Copy the current values to the matrix of the preconditioner, with its diagonal `raised` by this factor."""
        self._reduced.update(self.values)
        lift(self._reduced.values, self._diagonal)
        self._reduced.values[self._diagonal] *= raised
        self._uu_reduced.assemble()     # also discards the inverse of the diagonal that PETSc stores for sweeps
        self._preconditioner.stateIncrease()

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
        count, solution = self._solve(tolerance), self._x.array
        return solution[:len(soil)].copy(), solution[len(soil):].copy(), count

    def _attempt(self, solver, most, tolerance):
        ksp, _ = self._solvers[solver]
        ksp.max_it = most
        if "hybrid_ksp_rtol" not in CHOSEN_BY_USER:
            _, *others = ksp.getTolerances()
            ksp.setTolerances(tolerance, *others)
        try:
            with held_back():
                ksp.solve(self._b, self._x)
        except PETSc.Error:
            return _singular(solver), 0
        reason, count = ksp.getConvergedReason(), ksp.getIterationNumber()
        if reason < 0 or not np.isfinite(self._x.array).all():
            if solver == DIRECT:
                return f"the direct factor {SINGULAR} or nearly so (PETSc reason {reason})", count
            return f"no convergence in {count} iterations, PETSc reason {reason}", count
        return "", count


def _singular(solver):
    """Why a `solver` whose set-up or solution is an error of PETSc has failed."""
    return f"the direct factor {SINGULAR}" if solver == DIRECT else "a diagonal block is singular"


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
