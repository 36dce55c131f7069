"""The block system in PETSc: the only place that knows how it is stored and solved.

    | K_uu  K_uw | |δu|     |R_u|
    | K_wu  K_ww | |δw| = - |R_w|

K_uu is sparse (AIJ) over the free soil unknowns, the others are dense and as thin as the bodies' free unknowns. The
preconditioner is the upper block factorisation: an incomplete (or, for checks, a direct) factor of K_uu and the exact
Schur complement K_ww - K_wu M^-1 K_uw, formed with one application of that factor M^-1 per body unknown.

The incomplete factor is made from the entries between nodes of one cell only. A point near a cell's face also couples
nodes two cells apart, which makes three quarters of the entries but carries little: without them a factor of 15 600
unknowns takes 0.04 s instead of 0.35 s, and GMRES 8 iterations instead of 4 to 1e-3, in the same time.

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


class BlockSystem:
    """Storage and solution of the block system for one sparsity pattern.

    near: (entries,) bool, those of K_uu that the incomplete factor is made from, None for all.
    values: entries of K_uu in the order of the pattern; uw (n, m), wu (m, n), ww (m, m): dense blocks.
    """

    def __init__(self, indptr, indices, body_unknowns, linear, tolerance, near=None):
        n, m = len(indptr) - 1, body_unknowns
        self.values = np.zeros(len(indices))
        self.uw, self.wu = np.zeros((n, m), order="F"), np.zeros((m, n), order="F")
        self.ww, self._schur = np.zeros((m, m), order="F"), np.zeros((m, m), order="F")
        self.soil_unknowns, self.body_unknowns = n, m
        self._coupled, self._blocks, self._near = bool(n and m), [], None
        if n:
            self._uu = PETSc.Mat().createAIJWithArrays((n, n), (indptr, indices, self.values), comm=COMM)
            self._blocks.append(self._uu)
            if near is not None and linear != "direct":
                self._near, self._near_values = np.flatnonzero(near), np.zeros(np.count_nonzero(near))
                start = np.concatenate([[0], np.cumsum(near)[indptr[1:] - 1]]).astype(np.int32)
                self._uu_near = PETSc.Mat().createAIJWithArrays(
                    (n, n), (start, indices[near], self._near_values), comm=COMM)
        if m:
            self._ww = PETSc.Mat().createDense((m, m), array=self.ww, comm=COMM)
            self._blocks.append(self._ww)
        if self._blocks:
            self._join()
            self._ksp = self._krylov(DIRECT if linear == "direct" else INCOMPLETE, tolerance)
            self._x, self._b = self._matrix.createVecs()

    def _join(self):
        """The matrix, and what the preconditioner is made from; alone or as nests with the coupling blocks."""
        n, m = self.soil_unknowns, self.body_unknowns
        self._matrix = self._blocks[0]
        self._preconditioner = self._matrix if self._near is None else self._uu_near
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

    def _krylov(self, factor, tolerance):
        ksp = PETSc.KSP().create(COMM)
        ksp.setOptionsPrefix("hybrid_")
        ksp.setOperators(self._matrix, self._preconditioner)
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
        if self._blocks:
            if self._coupled:  # PETSc keeps the inner solvers of a Schur field split alive, factor and all
                self._ksp.getPC().getFieldSplitSubKSP()[0].getPC().reset()
            self._ksp.reset()
            things = [self._ksp, self._preconditioner, self._matrix, *self._blocks, self._x, self._b]
            things += [self._uu_near] if self._near is not None else []
            for thing in things:
                thing.destroy()

    def clear(self):
        """Zero what is assembled anew by adding: all blocks but K_uu, which is filled."""
        for block in (self.uw, self.wu, self.ww):
            block[...] = 0.0

    def factor(self):
        """Prepare the preconditioner after assembly."""
        if self._near is not None:
            np.take(self.values, self._near, out=self._near_values)
            self._uu_near.stateIncrease()
        for block in (*self._blocks, self._matrix, self._preconditioner):
            block.stateIncrease()
        self._ksp.setOperators(self._matrix, self._preconditioner)
        with _entered(self._options):  # the parts of a field split read theirs at the first set-up
            self._ksp.setUp()
        if self._coupled:
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
        if not self._blocks:
            return np.zeros(0), np.zeros(0), 0
        self._b.array = -np.concatenate([soil, body])
        try:
            self._ksp.solve(self._b, self._x)
        except PETSc.Error as error:
            raise StepError(_advice("a diagonal block is singular")) from error
        reason, count = self._ksp.getConvergedReason(), self._ksp.getIterationNumber()
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
