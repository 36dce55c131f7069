"""The block system of several processes, solved by PETSc: as `hybrid.linalg.petsc`, with what differs between processes.

    K_uu   each process keeps the part that its own points give, over all its local unknowns, and applies it to them; sums
           over processes go along one fixed plan of scatters
    M^-1   each process has sweeps or incomplete factors of its own unknowns and the copies around them, whose part of the
           solution is left to their owners (restricted additive Schwarz). Entries that several processes have are added up
           along another plan. The direct factor is that of MUMPS, of assembled rows
    K_ww   whole in every process, and so is the Schur complement; its columns are made by all processes together

GMRES sees vectors with the own soil unknowns of each process, and those of the bodies in the first one.
"""

import numpy as np
from petsc4py import PETSc

from hybrid.linalg.blocks import SolversInTurn
from hybrid.linalg.inverses import INVERSES, RAISED, lift
from hybrid.linalg.precond_pattern import ReducedMatrix
from hybrid.linalg.product import Product
from hybrid.linalg.solver_choice import DIRECT, ILU0_SHIFTED, MOST
from hybrid.linalg.stencil_pattern import diagonal_places
from hybrid.runtime import comm, ranks

ALL, SELF = PETSc.COMM_WORLD, PETSc.COMM_SELF


def begin_counting():
    """From now on PETSc counts messages and reductions."""
    PETSc.Log.begin()


def counted(event):
    """{"count", "numMessages", "messageLength" [B] sent and received, "numReductions"} of a PETSc event of this process."""
    return PETSc.Log.Event(event).getPerfInfo()


class _Calls:
    """What PETSc calls of a DistributedSystem; it must not find its method `destroy`."""

    def __init__(self, system):
        self._system = system

    def mult(self, _, x, y):
        self._system.mult(x, y)

    def apply(self, _, x, y):
        self._system.apply(x, y)


class DistributedSystem(SolversInTurn):
    """Storage and solution of the block system; attributes and methods as those of BlockSystem.

    pattern: Pattern of the local unknowns; grid: Block; reduced: ReducedMatrix, None for all of K_uu; choice: SolverChoice
    """

    def __init__(self, pattern, grid, body_unknowns, tolerance, reduced, sweeps, choice):
        n, m = pattern.size, body_unknowns
        super().__init__(len(pattern.indices), n, m, choice, sweeps, tolerance)
        self._own, numbers = number_unknowns(pattern.free, grid)
        self._count = int(np.count_nonzero(self._own))
        self.body_unknowns, self.soil_unknowns = m, comm.count(self._own)
        self._map = PETSc.LGMap().create(numbers, comm=ALL)
        sizes = (self._count, self.soil_unknowns)
        self._vector, self._copy = PETSc.Vec().createMPI(sizes, comm=ALL), PETSc.Vec().createSeq(n, comm=SELF)
        self._result, self._inverted = self._vector.duplicate(), self._vector.duplicate()
        places = PETSc.IS().createGeneral(numbers, comm=SELF)
        self._scatter = PETSc.Scatter().create(self._vector, places, self._copy, None)
        places.destroy()
        self._product, self._multiply = self._copy.duplicate(), Product(pattern.indptr, pattern.indices, self.values)
        self._local = PETSc.Mat().createAIJWithArrays((n, n), (pattern.indptr, pattern.indices, self.values), comm=SELF)
        self._reduced = reduced or ReducedMatrix(pattern.indptr, pattern.indices, np.ones(len(pattern.indices), bool))
        self._diagonal = diagonal_places(self._reduced.indptr, self._reduced.indices)
        self._shared = _shared_entries(self._reduced, pattern.free, grid.nodes.shared)
        self._made = {}     # {solver: (matrices, KSP)}
        self._parts = [self._map, self._vector, self._copy, self._result, self._inverted, self._scatter, self._product,
                       self._local]
        self._make_krylov()

    def owners(self):
        """(n,) process that owns each unknown of this one."""
        return np.searchsorted(self._vector.getOwnershipRanges(), self._map.indices, side="right") - 1

    def _make_krylov(self):
        own = self._count + (self.body_unknowns if ranks.rank() == 0 else 0)
        sizes = (own, self.soil_unknowns + self.body_unknowns)
        self._matrix = PETSc.Mat().createPython((sizes, sizes), context=_Calls(self), comm=ALL)
        self._matrix.setUp()
        self._x, self._b = self._matrix.createVecs()
        self._ksp = PETSc.KSP().create(ALL)
        self._ksp.setOptionsPrefix("hybrid_")
        self._ksp.setOperators(self._matrix)
        self._ksp.setType("gmres")
        self._ksp.setGMRESRestart(100)
        self._ksp.setPCSide(PETSc.PC.Side.RIGHT)
        self._ksp.getPC().setType("python")
        self._ksp.getPC().setPythonContext(_Calls(self))
        self._ksp.setFromOptions()
        self._parts += [self._matrix, self._x, self._b, self._ksp]

    def destroy(self):
        """Release the memory of matrices and factors."""
        for thing in [*self._parts, *(each for made in self._made.values() for each in made)]:
            thing.destroy()
        self._parts, self._made = [], {}

    # -------------------------------------------------------------- vectors of own and of local unknowns

    def _to_local(self, own):
        """(n,) values of the local unknowns from those of the own ones."""
        self._vector.array = own
        self._scatter.scatter(self._vector, self._copy, addv=PETSc.InsertMode.INSERT, mode=PETSc.ScatterMode.FORWARD)
        return self._copy.array_r

    def _summed(self, local):
        """(own,) sums over processes of values (n,) of local unknowns."""
        self._product.array = local
        self._result.set(0.0)
        self._scatter.scatter(self._product, self._result, addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
        return self._result.array_r

    def _of_bodies(self, vector):
        """(m,) entries of the bodies in a vector of GMRES, in every process."""
        if not self.body_unknowns:
            return np.zeros(0)
        return comm.from_first(vector.array_r[self._count:].copy())

    def _put(self, vector, soil, bodies):
        vector.array = soil if ranks.rank() else np.concatenate([soil, bodies])

    # -------------------------------------------------------------- what GMRES calls

    def mult(self, x, y):
        """y = K x."""
        soil, bodies = self._to_local(x.array_r[:self._count]), self._of_bodies(x)
        self._multiply.mult(None, self._copy, self._product)
        on_bodies = comm.total([self.wu @ soil]) + self.ww @ bodies if self.body_unknowns else bodies
        self._put(y, self._summed(self._product.array_r + self.uw @ bodies), on_bodies)

    def apply(self, x, y):
        """y = the preconditioner's inverse times x."""
        bodies, soil = self._of_bodies(x), x.array_r[:self._count]
        if self.body_unknowns:
            bodies = np.linalg.solve(self._schur, bodies)
            soil = soil - self._summed(self.uw @ bodies)
        self._put(y, self._inverse(soil), bodies)

    def _inverse(self, own):
        """(own,) M^-1 times own entries (own,)."""
        ksp = self._made[self._solver][-1]
        if self._solver == DIRECT:
            self._vector.array = own
            ksp.solve(self._vector, self._inverted)
            return self._inverted.array_r
        self._to_local(own)
        ksp.solve(self._copy, self._product)
        return self._product.array_r[self._own]

    # -------------------------------------------------------------- preconditioner

    def factor(self):
        """Prepare the preconditioner after assembly."""
        self._local.assemble()
        self._local.stateIncrease()
        self._begin()

    def _set_up(self, solver):
        self._solver = solver
        if solver not in self._made:
            self._made[solver] = self._make(solver)
        *matrices, ksp = self._made[solver]
        if solver == DIRECT:
            unassembled, matrix = matrices
            unassembled.assemble()
            unassembled.convert("aij", matrix)
        else:
            self._fill_reduced(matrix := matrices[0], RAISED if solver == ILU0_SHIFTED else 1.0)
        ksp.setOperators(matrix)
        ksp.setUp()
        if solver == DIRECT:
            self._choice.factors += 1
            code = ksp.getPC().getFactorMatrix().getMumpsInfog(1)
            if code < 0:
                return f"the direct factor fails with error {code} of MUMPS"
        self._form_schur()
        return ""

    def _fill_reduced(self, matrix, raised):
        """As in BlockSystem; entries of unknowns that several processes have are those of all of them together."""
        values = self._reduced.values
        self._reduced.update(self.values)
        parts = {other: values[at] for other, at in self._shared.items()}
        for other, part in comm.neighbours(parts, {other: len(at) for other, at in self._shared.items()}, (), float).items():
            values[self._shared[other]] += part
        lift(values, self._diagonal)
        values[self._diagonal] *= raised
        matrix.assemble()
        matrix.stateIncrease()

    def _make(self, solver):
        """(matrices that a solver is made from, KSP): local entries and assembled rows, or the reduced matrix of this
        process."""
        matrices = self._assembled() if solver == DIRECT else [self._of_this_process()]
        ksp = PETSc.KSP().create(ALL if solver == DIRECT else SELF)
        prefix = f"hybrid_inverse_{solver}_"
        ksp.setOptionsPrefix(prefix)
        options = PETSc.Options()
        for key, value in INVERSES[solver].items():
            options[prefix + key] = value
        ksp.setFromOptions()
        return *matrices, ksp

    def _assembled(self):
        sizes = (self._count, self.soil_unknowns)
        unassembled, matrix = PETSc.Mat().createIS((sizes, sizes), lgmapr=self._map, lgmapc=self._map, comm=ALL), PETSc.Mat()
        self._local.incRef()
        unassembled.setISLocalMat(self._local)
        unassembled.assemble()
        unassembled.convert("aij", matrix)
        return unassembled, matrix

    def _of_this_process(self):
        n, csr = len(self._own), (self._reduced.indptr, self._reduced.indices, self._reduced.values)
        return PETSc.Mat().createAIJWithArrays((n, n), csr, comm=SELF)

    def _form_schur(self):
        """S = K_ww - K_wu M^-1 K_uw in every process."""
        self._schur = self.ww.copy()
        for a in range(self.body_unknowns):
            if comm.anywhere(self.uw[:, a]):
                column = self._to_local(self._inverse(self._summed(self.uw[:, a]).copy()))
                with np.errstate(invalid="ignore"):
                    self._schur[:, a] -= comm.total([self.wu @ column])

    # -------------------------------------------------------------- solution

    def solve(self, soil, body, tolerance=None):
        """Increments (n,) of the local unknowns and (m,) of the bodies, and the number of Krylov iterations, as
        `BlockSystem.solve`; soil: residuals (n,), summed over processes."""
        self._put(self._b, -soil[self._own], -body)
        count = self._solve(tolerance)
        bodies = self._of_bodies(self._x)
        return self._to_local(self._x.array_r[:self._count]).copy(), bodies, count

    def _attempt(self, solver, most, tolerance):
        if not np.isfinite(self._schur).all() or self.body_unknowns and not np.linalg.cond(self._schur) < 1e300:
            return "the Schur complement of the bodies is singular", 0
        self._ksp.setTolerances(rtol=tolerance, atol=0.0, max_it=min(most, MOST))
        self._ksp.setUp()
        self._ksp.solve(self._b, self._x)
        reason, count = self._ksp.getConvergedReason(), self._ksp.getIterationNumber()
        if reason < 0 or comm.anywhere(~np.isfinite(self._x.array_r)):
            return f"no convergence in {count} iterations, PETSc reason {reason}", count
        return "", count


def number_unknowns(free, grid):
    """((n,) bool, which of the local unknowns of a Block are this process's own; (n,) their numbers among those of all
    processes, consecutive for those of a process). free: (N, 3) bool"""
    own = grid.own_unknowns(free)
    count, numbers = int(np.count_nonzero(own)), np.full(free.shape, -1)
    numbers[free & grid.nodes.owned[:, None]] = comm.offset(count) + np.arange(count)
    found = grid.from_owners(numbers)[free].astype(PETSc.IntType)
    assert (found >= 0).all(), "processes have different active nodes"
    return own, found


def _shared_entries(matrix, free, shared):
    """{other process: places of the entries of a ReducedMatrix between unknowns that it has too}, in an order that is the
    same in both. free: (N, 3) bool; shared: {other process: local numbers of common nodes}"""
    places, rows = {}, np.diff(matrix.indptr)
    for other, nodes in shared.items():
        common = np.zeros_like(free)
        common[nodes] = True
        common = common[free]
        places[other] = np.flatnonzero(np.repeat(common, rows) & common[matrix.indices])
    return places
