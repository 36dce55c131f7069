"""The block system in PETSc: the only place that knows how it is stored and solved.

    | K_uu  K_uw | |δu|     |R_u|
    | K_wu  K_ww | |δw| = - |R_w|

K_uu is sparse (AIJ) over the free soil unknowns, the others are dense and as thin as the bodies' free unknowns. The
preconditioner is the upper block factorisation: an incomplete (or, for checks, a direct) factor of K_uu and the exact
Schur complement K_ww - K_wu M^-1 K_uw, formed with one application of that factor M^-1 per body unknown.

All matrices stay allocated while the pattern is the same; values are edited in place. Options prefix: "hybrid_".
"""

from contextlib import contextmanager

import numpy as np
from petsc4py import PETSc

from hybrid.errors import StepError

DIRECT = {"ksp_type": "preonly", "pc_type": "lu", "pc_factor_mat_solver_type": "mumps"}
# A node that a domain barely overlaps has a tiny row and a far tinier pivot; elimination without pivoting does not
# depend on the scale of rows and columns, so only an exact zero is refused.
INCOMPLETE = {"ksp_type": "preonly", "pc_type": "ilu", "pc_factor_zeropivot": 0.0}
COMM = PETSc.COMM_SELF
CHOSEN_BY_USER = set(PETSc.Options().getAll())  # PETSC_OPTIONS of the environment override ours


class Lag:
    """When an incomplete factor may serve again. Making one costs about as much as 20 Krylov iterations.

    It serves `most` solutions, one more each time an old factor did well. When an old one needed more than half as
    many iterations again as the fresh one, every solution gets its own for a while.
    """

    PAUSE = 8

    def __init__(self):
        self.first, self.used, self.most, self.pause = 0, 0, 2, 0

    def due(self):
        """True when the next solution should have a fresh factor."""
        return self.used == 0 or self.used >= self.most

    def record(self, fresh, iterations):
        """Take note of a solution with a fresh or an old factor."""
        if fresh:
            self.first, self.used = iterations, 1
            self.pause = max(0, self.pause - 1)
            self.most = max(self.most, 2) if self.pause == 0 else 1
        elif iterations > 1.5 * self.first + 5:
            self.used, self.most, self.pause = 0, 1, self.PAUSE
        else:
            self.used += 1
            self.most = max(self.most, self.used + 1)


class BlockSystem:
    """Storage and solution of the block system for one sparsity pattern.

    values: entries of K_uu in the order of the pattern; uw (n, m), wu (m, n), ww (m, m): dense blocks.
    """

    def __init__(self, indptr, indices, body_unknowns, linear, tolerance):
        n, m = len(indptr) - 1, body_unknowns
        self.values = np.zeros(len(indices))
        self.uw, self.wu = np.zeros((n, m), order="F"), np.zeros((m, n), order="F")
        self.ww, self._schur = np.zeros((m, m), order="F"), np.zeros((m, m), order="F")
        self.soil_unknowns, self.body_unknowns = n, m
        self._blocks = []
        if n:
            self._uu = PETSc.Mat().createAIJWithArrays((n, n), (indptr, indices, self.values), comm=COMM)
            self._blocks.append(self._uu)
        if m:
            self._ww = PETSc.Mat().createDense((m, m), array=self.ww, comm=COMM)
            self._blocks.append(self._ww)
        self._coupled = bool(n and m)
        self._matrix = self._nest() if self._coupled else self._blocks[0] if self._blocks else None
        self._direct = linear == "direct" or not n
        self._lag, self._fresh = Lag(), True
        if self._matrix is not None:
            self._ksp = self._krylov(DIRECT if linear == "direct" else INCOMPLETE, tolerance)
            self._x, self._b = self._matrix.createVecs()
            self._soil_pc = None if self._coupled else self._ksp.getPC()

    def _nest(self):
        n, m = self.soil_unknowns, self.body_unknowns
        uw = PETSc.Mat().createDense((n, m), array=self.uw, comm=COMM)
        wu = PETSc.Mat().createDense((m, n), array=self.wu, comm=COMM)
        self._sp = PETSc.Mat().createDense((m, m), array=self._schur, comm=COMM)
        self._blocks += [uw, wu]
        for block in (*self._blocks, self._sp):
            block.assemble()
        return PETSc.Mat().createNest([[self._uu, uw], [wu, self._ww]], comm=COMM)

    def _krylov(self, factor, tolerance):
        ksp = PETSc.KSP().create(COMM)
        ksp.setOptionsPrefix("hybrid_")
        ksp.setOperators(self._matrix)
        ksp.setType("gmres")
        ksp.setGMRESRestart(100)
        ksp.setPCSide(PETSc.PC.Side.RIGHT)
        ksp.setTolerances(rtol=tolerance, atol=0.0, max_it=300)
        pc = ksp.getPC()
        if self._coupled:
            pc.setType("fieldsplit")
            u, w = self._matrix.getNestISs()[0]
            pc.setFieldSplitIS(("u", u), ("w", w))
            pc.setFieldSplitType(PETSc.PC.CompositeType.SCHUR)
            pc.setFieldSplitSchurFactType(PETSc.PC.SchurFactType.UPPER)
            pc.setFieldSplitSchurPreType(PETSc.PC.SchurPreType.USER, self._sp)
            self._options = {f"fieldsplit_u_{key}": value for key, value in factor.items()}
            self._options |= {"fieldsplit_w_ksp_type": "preonly", "fieldsplit_w_pc_type": "lu"}
        elif self.soil_unknowns:
            self._options = {**factor, "ksp_type": "gmres"}
        else:
            self._options = {"ksp_type": "preonly", "pc_type": "lu"}
        with _entered(self._options):
            ksp.setFromOptions()
        return ksp

    def destroy(self):
        """Release the memory of matrices and factors at once, rather than when Python gets to it."""
        if self._matrix is not None:
            if self._soil_pc is not None:
                self._soil_pc.reset()  # PETSc keeps the inner solvers of a Schur field split alive, factor and all
            self._ksp.reset()
            for thing in (self._ksp, self._matrix, *self._blocks, self._x, self._b):
                thing.destroy()

    def clear(self):
        """Zero all blocks before they are assembled anew."""
        for block in (self.values, self.uw, self.wu, self.ww):
            block[...] = 0.0

    def factor(self, fresh=False):
        """Prepare the preconditioner after assembly, from the factor at hand unless a `fresh` one is due."""
        for block in (*self._blocks, self._matrix):
            block.stateIncrease()
        self._fresh = fresh or self._direct or self._lag.due()
        if self._soil_pc is not None:
            self._soil_pc.setReusePreconditioner(not self._fresh)
        self._ksp.setOperators(self._matrix)
        with _entered(self._options):  # the parts of a field split read theirs at the first set-up
            self._ksp.setUp()
        if self._coupled:
            self._soil_pc = self._ksp.getPC().getFieldSplitSubKSP()[0].getPC()
            self._form_schur()

    def _form_schur(self):
        """S = K_ww - K_wu M^-1 K_uw; coupling only exists where corners touch, so zero columns cost nothing."""
        soil = self._ksp.getPC().getFieldSplitSubKSP()[0]
        x, b = self._uu.createVecs()
        self._schur[...] = self.ww
        for a in range(self.body_unknowns):
            if np.any(self.uw[:, a]):
                b.array = self.uw[:, a]
                soil.solve(b, x)
                self._schur[:, a] -= self.wu @ x.array
        self._sp.stateIncrease()

    def solve(self, soil, body):
        """Increments (n,), (m,) that cancel residuals (n,), (m,), and the number of Krylov iterations.

        Raises StepError when the Krylov method does not converge or meets a singular factor.
        """
        if self._matrix is None:
            return np.zeros(0), np.zeros(0), 0
        self._b.array = -np.concatenate([soil, body])
        try:
            self._ksp.solve(self._b, self._x)
        except PETSc.Error as error:
            raise StepError(_advice("a diagonal block is singular")) from error
        reason, count = self._ksp.getConvergedReason(), self._ksp.getIterationNumber()
        self._lag.record(self._fresh, count if reason > 0 else np.inf)
        if reason < 0 and not self._fresh:
            self.factor(fresh=True)
            return self.solve(soil, body)
        solution = self._x.array
        if reason < 0 or not np.isfinite(solution).all():
            raise StepError(_advice(f"no convergence in {count} iterations, PETSc reason {reason}"))
        return solution[:len(soil)].copy(), solution[len(soil):].copy(), count


def _advice(what):
    return (f"linear solver: {what}; hold components of bodies that nothing supports, shorten the step, or set "
            'solver.linear = "direct" to see whether the system is singular')


@contextmanager
def _entered(options):
    """Options under our prefix, except those the user set, for as long as the block lasts: the database is global
    and would hand them to the next system in the same process."""
    database = PETSc.Options("hybrid_")
    own = [key for key in options if f"hybrid_{key}" not in CHOSEN_BY_USER]
    for key in own:
        database[key] = options[key]
    try:
        yield
    finally:
        for key in own:
            database.delValue(key)
