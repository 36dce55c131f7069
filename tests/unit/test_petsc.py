"""The block system against a dense solution, whatever its preconditioner; memory given back."""

import os
import signal
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import block_diag, csr_matrix, diags, identity, kron, random

from hybrid.linalg import inverses, solver_choice
from hybrid.linalg.petsc import BlockSystem
from hybrid.linalg.precond_pattern import ReducedMatrix
from hybrid.linalg.product import Product
from hybrid.linalg.solver_choice import ILU0, ILU0_SHIFTED, SSOR, Single, SolverChoice
from hybrid.runtime.errors import StepError
from hybrid.runtime.stop_signals import Stopped, stop_signals
from hybrid.scene import Solver, Time
from hybrid.setup.build import build
from hybrid.soil import model
from hybrid.step.equations import begin
from hybrid.step.workspace import Workspace
from hybrid.study.scenes import soil_scene


def filled(n, m, linear, tolerance=1e-12, seed=0):
    """(system, dense matrix) with random well-conditioned blocks."""
    rng = np.random.default_rng(seed)
    uu = (random(n, n, 0.05, random_state=seed) + diags(np.full(n, 10.0))).tocsr()
    uu.sort_indices()
    system = BlockSystem(uu.indptr.astype(np.int32), uu.indices.astype(np.int32), m, linear, tolerance)
    system.values[:] = uu.data
    system.uw[:], system.wu[:] = rng.standard_normal((n, m)), rng.standard_normal((m, n))
    system.ww[:] = rng.standard_normal((m, m)) + 100 * np.eye(m)
    return system, np.block([[uu.toarray(), system.uw], [system.wu, system.ww]])


@pytest.mark.parametrize("linear", ["auto", "direct"])
@pytest.mark.parametrize("n, m", [(200, 0), (200, 3), (200, 12), (0, 6)])
def test_solves_the_block_system(linear, n, m):
    if n:
        system, K = filled(n, m, linear)
    else:
        system = BlockSystem(np.zeros(1, np.int32), np.zeros(0, np.int32), m, linear, 1e-12)
        K = system.ww[:] = np.random.default_rng(1).standard_normal((m, m)) + 5 * np.eye(m)
    system.factor()
    residual = np.random.default_rng(2).standard_normal(n + m)
    soil, body, _ = system.solve(residual[:n], residual[n:])
    assert np.allclose(np.concatenate([soil, body]), -np.linalg.solve(K, residual), rtol=1e-9, atol=1e-11)


def test_exact_schur_complement_makes_one_iteration_of_a_direct_factor():
    system, _ = filled(200, 6, "direct")
    system.factor()
    assert system.solve(np.ones(200), np.ones(6))[2] <= 2


def test_a_factor_of_the_reduced_matrix_gives_the_same_solution():
    _, K = filled(200, 3, "auto")
    uu = csr_matrix(K[:200, :200])
    kept = abs(np.repeat(np.arange(200), np.diff(uu.indptr)) - uu.indices) < 80
    assert 0.2 < kept.mean() < 0.8
    system = BlockSystem(uu.indptr, uu.indices, 3, "auto", 1e-12, ReducedMatrix(uu.indptr, uu.indices, kept))
    residual = np.ones(203)
    for scale in (1.0, 3.0):
        system.values[:], system.uw[:], system.wu[:] = scale * uu.data, K[:200, 200:], K[200:, :200]
        system.ww[:], K[:200, :200] = K[200:, 200:], scale * uu.toarray()
        system.factor()
        soil, body, count = system.solve(residual[:200], residual[200:])
        assert np.allclose(np.concatenate([soil, body]), -np.linalg.solve(K, residual), rtol=1e-9, atol=1e-11)
        assert count > 1


@pytest.mark.parametrize("m", [0, 3])
def test_sweeps_follow_the_values_that_are_edited_in_place(m):
    """Sweeps keep the inverse of the diagonal, which must not outlive the values it came from."""
    uu = random(300, 300, 0.03, random_state=5)
    uu = csr_matrix(uu + uu.T + diags(np.full(300, 8.0)))
    scale = diags(10.0 ** np.random.default_rng(3).uniform(-1, 1, 300))
    others = [uu, csr_matrix(scale @ uu @ scale)]
    for matrix in others:
        matrix.sort_indices()
    system, fresh = (BlockSystem(uu.indptr, uu.indices, m, "auto", 1e-6, sweeps=True) for _ in range(2))
    counts = [pushed(system, matrix) for matrix in others]
    assert pushed(fresh, others[1]) == counts[1] < 20


def test_where_sweeps_divide_by_zero_the_factor_takes_over():
    """The incomplete factor of three diagonals is exact."""
    middle = np.where(np.arange(300) % 3 == 1, 0.0, 2.0)
    uu = csr_matrix(diags([np.ones(299), np.ones(300), np.ones(299)], [-1, 0, 1]))
    uu.setdiag(middle)      # zeros are kept as entries
    system = BlockSystem(uu.indptr, uu.indices, 3, "auto", 1e-10, sweeps=True)
    assert pushed(system, uu) <= 3


def nodes(count, block):
    """Rows of `count` nodes in line: `block` (k, k) of each with itself, a little of its neighbours'."""
    line = diags([np.ones(count - 1), np.ones(count - 1)], [-1, 1])
    matrix = csr_matrix(kron(line, np.ones(block.shape)) * 0.1 + kron(identity(count), block))
    matrix.sort_indices()
    return matrix


@pytest.mark.parametrize("m", [0, 3])
def test_sweeps_take_the_unknowns_of_a_node_together(monkeypatch, m):
    """Shear that outweighs the diagonal, as where sand flows, is nothing to the inverse of a block."""
    uu, counts = nodes(200, np.array([[1.0, 3.0, 2.0], [-3.0, 1.0, 3.0], [-2.0, -3.0, 1.0]])), []
    for shift in ({}, {"pc_sor_diagonal_shift": 1e-300}):   # with which PETSc takes every row by itself
        monkeypatch.setitem(inverses.INVERSES, SSOR, {**inverses.INVERSES[SSOR], **shift})
        system = BlockSystem(uu.indptr, uu.indices, m, "auto", 1e-8, sweeps=True)
        counts.append(pushed(system, uu))
    assert counts[0] < 15 and counts[1] > 2 * counts[0]


@pytest.mark.parametrize("part", [False, True])
@pytest.mark.parametrize("least, solver", [(inverses.SMALLEST_DIAGONAL, SSOR), (0.0, ILU0)])
def test_a_node_with_hardly_any_stiffness_does_not_stop_the_sweeps(monkeypatch, least, solver, part):
    """A lone component of 1e-17 N/m, among nodes whose blocks PETSc inverts."""
    monkeypatch.setattr(inverses, "SMALLEST_DIAGONAL", least)
    uu = csr_matrix(block_diag([nodes(100, 4 * np.eye(3)), [[1e-17]]]))
    kept = ReducedMatrix(uu.indptr, uu.indices, np.ones(uu.nnz, bool)) if part else None
    system = BlockSystem(uu.indptr, uu.indices, 3, "auto", 1e-10, kept, sweeps=True)
    system.values[:], system.ww[:], system.uw[:300], system.wu[:] = uu.data, 9 * np.eye(3), 0.01, 0.01
    system.wu[:, 300] = 0.0
    system.factor()
    residual = np.ones(300)
    soil, body, _ = system.solve(np.append(residual, 0.0), np.ones(3))
    assert system._order[system._at][0] == solver
    np.testing.assert_allclose(uu[:300, :300] @ soil[:300] + system.uw[:300] @ body, -1.0, atol=1e-8)
    system.destroy()


def pushed(system, uu, atol=1e-4):
    """Krylov iterations of a push on all of the soil, whose solution is checked."""
    m = system.body_unknowns
    system.values[:], system.ww[:] = uu.data, np.eye(m)
    system.factor()
    soil, _, count = system.solve(np.ones(uu.shape[0]), np.ones(m))
    np.testing.assert_allclose(uu @ soil, -1.0, atol=atol)
    return count


def test_a_singular_system_is_reported_with_its_cause():
    system, _ = filled(50, 3, "auto")
    system.clear()
    system.values[...] = 0.0
    reason = r"^linear solver: (a diagonal block is singular|no convergence in \d+ iterations)"
    with pytest.raises(StepError, match=reason):
        system.factor()
        system.solve(np.ones(50), np.ones(3))


def test_bodies_that_nothing_supports_are_a_singular_system_and_no_error_of_petsc():
    """Their dense block is factored in the set-up; with stiffness again the same system is solved."""
    system = BlockSystem(np.zeros(1, np.int32), np.zeros(0, np.int32), 6, "auto", 1e-12)
    for stiffness in (0.0, 2.0, 0.0):
        system.ww[:] = stiffness * np.eye(6)
        system.factor()
        if stiffness:
            np.testing.assert_allclose(system.solve(np.zeros(0), np.ones(6))[1], -0.5)
        else:
            with pytest.raises(StepError, match="^linear solver: the direct factor finds the matrix singular$"):
                system.solve(np.zeros(0), np.ones(6))


def test_memory_is_given_back():
    def resident():
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * 4096 / 2**20

    n, k = 60000, 30
    indptr = np.arange(0, n * k + 1, k, dtype=np.int32)
    indices = np.sort((np.arange(n)[:, None] + np.arange(k)) % n, axis=1).astype(np.int32).ravel()
    column = np.repeat(np.arange(n), k)
    kept = abs(indices - column) < k // 2
    used = []
    for _ in range(6):
        system = BlockSystem(indptr.copy(), indices.copy(), 3, "auto", 1e-4, ReducedMatrix(indptr, indices, kept))
        system.values[:], system.ww[:] = indices == column, np.eye(3)
        system.factor()
        system.solve(np.ones(n), np.ones(3))
        system.destroy()
        used.append(resident())
    assert used[-1] - used[1] < 40  # one factor and matrix are 40 MiB; leaking them would be 160


def hardly_filled(filled, material=(), **soil):
    """Krylov iterations for a push everywhere on a block that reaches into the next layer of cells by a share of it."""
    scene = soil_scene(size=0.1, time=Time(step=1.0, inertia=False),
                       solver=Solver(linear="auto", linear_tolerance=1e-3), **soil)
    material = replace(scene.soil.material, **dict(material))
    simulation = build(replace(scene, soil=replace(scene.soil, material=material)))
    points = simulation.state.points
    points.position[:, 2] -= (1 - filled) * 0.1 * (1 + points.position[:, 2] / 0.4)     # the base stays
    points.half_width[:, 2] *= 1 - (1 - filled) * 0.25
    step = begin(simulation.model, simulation.state, 1.0, False, Workspace(simulation.model))
    step.assemble(step.evaluate(step.predictor()))
    return step.system.solve(np.random.default_rng(1).normal(size=step.pattern.size), np.zeros(0))[2]


def test_cells_hardly_filled_cost_no_iterations_with_the_ghost_penalty():
    counts = {filled: hardly_filled(filled, ghost=0.033) for filled in (1.0, 1e-2, 1e-4)}
    assert max(counts.values()) <= counts[1.0] + 2


def test_nodes_with_small_support_cost_few_iterations_as_their_distant_entries_are_kept(monkeypatch):
    sand = {"law": "drucker-prager", "friction_angle": 33.0, "dilation_angle": 5.0, "cohesion": 1e5, "poisson": 0.3}
    full, partly = (hardly_filled(filled, material=sand) for filled in (1.0, 0.03))
    assert partly <= full + 1
    monkeypatch.setattr(model, "SMALL_SUPPORT", 0.0)
    assert hardly_filled(0.03, material=sand) > 1.5 * partly


def test_diagonals_that_sweeps_take_for_zero_are_lifted_with_their_sign():
    """Not what is larger, nor what is no diagonal. An exact zero stays far below what sweeps invert: they diverge, and
    the next way is taken."""
    values = np.array([2.0, 1e-20, -1e-20, 0.0, -3.0, 1e-30])
    inverses.lift(values, np.array([0, 1, 2, 3, 4]))
    assert values.tolist() == [2.0, inverses.SMALLEST_DIAGONAL, -inverses.SMALLEST_DIAGONAL, inverses.ZERO_DIAGONAL,
                               -3.0, 1e-30]
    assert 2e-14 < inverses.SMALLEST_DIAGONAL and 0.0 < inverses.ZERO_DIAGONAL < 1e-200


def badly_conditioned(linear, choice=None, singular=False, bodies=0):
    """(BlockSystem, its matrix), which no approximate inverse solves before a direct factor costs less."""
    turned = np.linalg.qr(np.random.default_rng(4).standard_normal((90, 90)))[0]
    values = np.where(np.arange(90) % 2, -1.0, 1.0) * np.logspace(0, 8, 90)
    uu = csr_matrix(np.ones((90, 90)) if singular else turned * values @ turned.T)
    near = np.full(uu.nnz, True) if singular else abs(np.repeat(np.arange(90), 90) - uu.indices) < 3
    reduced = ReducedMatrix(uu.indptr, uu.indices, near)
    system = BlockSystem(uu.indptr, uu.indices, bodies, linear, 1e-10, reduced, True, choice)
    system.values[:] = uu.data
    return system, uu


def solved(system, uu):
    """Krylov iterations with a new factor; the solution is checked."""
    system.factor()
    right = np.where(np.arange(uu.shape[0]) % 3, 1.0, -1.0)
    soil, _, count = system.solve(right, np.zeros(0))
    np.testing.assert_allclose(uu @ soil, -right, atol=1e-6)
    return count


def test_a_direct_factor_follows_where_the_iterative_solvers_fail_and_is_remembered():
    """Also by the next system, and its iterations count those that were in vain."""
    choice = SolverChoice("auto")
    system, uu = badly_conditioned("auto", choice)
    assert solved(system, uu) > 2 * solver_choice.LEAST and choice.direct and choice.factors == 1
    assert solved(system, uu) <= 2 and solved(*badly_conditioned("auto", choice)) <= 2 and choice.factors == 3


@pytest.mark.parametrize("singular", [False, True])
def test_a_direct_factor_that_follows_is_one_of_the_whole_matrix_also_with_bodies(singular):
    """Few iterations, as the Schur complement is exact; remembered by the next systems once one is destroyed."""
    choice, body = SolverChoice("auto"), np.ones((90, 3))
    body[:, 1:] = np.random.default_rng(6).standard_normal((90, 2))
    for attempt in range(3):
        system, uu = badly_conditioned("auto", choice, singular, bodies=3)
        system.uw[:], system.wu[:], system.ww[:] = body, body.T, 1e9 * np.eye(3)
        system.factor()
        if singular:
            with pytest.raises(StepError, match="the direct factor finds the matrix singular"):
                system.solve(np.linspace(-1.0, 2.0, 90), np.ones(3))
        else:
            soil, moved, count = system.solve(np.ones(90), np.ones(3))
            np.testing.assert_allclose(uu @ soil + body @ moved, -1.0, atol=1e-6)
            np.testing.assert_allclose(body.T @ soil + 1e9 * moved, -1.0, atol=1e-4)
            assert choice.direct and (count <= 4) == (attempt > 0)
        system.destroy()


@pytest.mark.parametrize("m", [0, 3])
def test_where_an_incomplete_factor_is_unstable_a_raised_diagonal_damps_it(m):
    """Volumetric stiffness of cells, 3000 times that of the springs between nodes, as of clay that flows. The damped factor
    needs fewer iterations than sweeps, and is remembered."""
    uu, counts = nearly_incompressible(9, 3000.0), {}
    for solver in (SSOR, ILU0, ILU0_SHIFTED):
        system = BlockSystem(uu.indptr, uu.indices, m, "auto", 1e-3, sweeps=True, choice=Single(solver))
        try:
            counts[solver] = pushed(system, uu, atol=np.inf)
        except StepError:
            counts[solver] = np.inf
        system.destroy()
    assert counts[ILU0] == np.inf and counts[ILU0_SHIFTED] < 0.8 * counts[SSOR]


def nearly_incompressible(cells, ratio):
    """Stiffness (n, n) of a cube of `cells` bricks along each edge, fixed at its base: springs between the nodes of a brick,
    and `ratio` times its volume change squared."""
    count = cells + 1
    number = np.arange(count**3).reshape(count, count, count)
    corner = np.array(np.unravel_index(np.arange(8), (2, 2, 2))).T
    volume = np.concatenate([(2.0 * c - 1.0) / 4 for c in corner])
    spring = np.kron(8 * np.eye(8) - np.ones((8, 8)), np.eye(3)) / 8
    brick = spring + ratio * np.outer(volume, volume)
    rows = []
    for base in np.ndindex(cells, cells, cells):
        nodes = [number[tuple(np.add(base, c))] for c in corner]
        rows.append((3 * np.array(nodes)[:, None] + np.arange(3)).ravel())
    rows = np.array(rows)
    where = np.repeat(rows, 24, axis=1).ravel(), np.tile(rows, (1, 24)).ravel()
    free = np.repeat(np.unravel_index(np.arange(count**3), (count,) * 3)[2] > 0, 3)
    uu = csr_matrix((np.tile(brick.ravel(), len(rows)), where), shape=(3 * count**3,) * 2)[free][:, free]
    uu.sort_indices()
    return uu


def test_a_direct_factor_that_does_not_fit_in_memory_is_refused(monkeypatch):
    monkeypatch.setattr(solver_choice, "available_memory", lambda: 100 * 2**10)
    reason = r"^linear solver: no convergence in .* and a direct factor does not fit: it needs about .* MiB.*, limit"
    choice = SolverChoice("auto")
    with pytest.raises(StepError, match=reason):
        solved(*badly_conditioned("auto", choice))
    assert choice.factors == 0
    assert solved(*badly_conditioned("direct")) <= 2      # which is the user's choice


@pytest.mark.parametrize("linear", ["auto", "direct"])
def test_a_matrix_that_is_singular_to_the_direct_factor_is_named(linear):
    with pytest.raises(StepError, match="^linear solver: .*the direct factor finds the matrix singular"):
        solved(*badly_conditioned(linear, singular=True))


LOOP = """
def steps():
    kept = system()
    kept.values[:], kept.ww[:] = 1.0, np.eye(6)
    kept.factor()
    try:
        yield kept.solve(np.ones(3), np.ones(6), 1e-3)
    finally:        # in a loop that is left early, when Python ends
        kept.destroy()
loop = steps()
next(loop)
"""
DROPPED = """
import numpy as np
from hybrid.linalg.petsc import BlockSystem

def system():
    return BlockSystem(np.arange(4, dtype=np.int32), np.arange(3, dtype=np.int32), 6, "auto", 1e-3)

{}
"""


@pytest.mark.parametrize("how", ["system()", "kept = system()", "kept = system()\nkept.itself = kept\ndel kept",
                                 "kept = [system()._product]\nkept.append(kept)\ndel kept", LOOP])
def test_a_process_ends_well_with_systems_that_nobody_has_destroyed(how):
    """PETSc ends after Python has, and must have no matrix by then that calls Python."""
    ended = subprocess.run([sys.executable, "-c", DROPPED.format(how)], capture_output=True, text=True)
    assert ended.returncode == 0, ended.stderr


def test_where_the_direct_factor_finds_a_pivot_of_zero_solvers_that_failed_are_tried_again():
    """Unknowns of sand that has opened have no stiffness, and no residual: a Krylov method leaves them where they are."""
    choice = SolverChoice("auto")
    choice.begin(200)
    for solver in (SSOR, ILU0, ILU0_SHIFTED):
        choice.failed(solver)
    _, K = filled(200, 0, "auto")
    K[:, 7] = K[7] = 0.0
    pattern = csr_matrix(K + np.eye(200))
    system = BlockSystem(pattern.indptr, pattern.indices, 0, "auto", 1e-10, choice=choice)
    system.values[:] = K[np.repeat(np.arange(200), np.diff(pattern.indptr)), pattern.indices]
    residual = np.where(np.arange(200) == 7, 0.0, 1.0)
    system.factor()
    found, _, _ = system.solve(residual, np.zeros(0))
    assert choice.factors == 1 and not choice.direct and found[7] == 0.0
    assert K @ found == pytest.approx(-residual, abs=1e-8)


def test_a_signal_in_what_petsc_calls_back_ends_the_run_after_the_solution(monkeypatch):
    """Raised in the product of the matrix it was an error of PETSc, which left a vector locked, and the run failed."""
    product, sent = Product.mult, []

    def mult(self, matrix, x, y):
        if not sent:
            sent.append(os.kill(os.getpid(), signal.SIGTERM))
        product(self, matrix, x, y)

    monkeypatch.setattr(Product, "mult", mult)
    system, K = filled(200, 0, "auto")
    system.factor()
    residual = np.random.default_rng(2).standard_normal(200)
    with stop_signals(), pytest.raises(Stopped):
        system.solve(residual, np.zeros(0))
    assert K @ system.solve(residual, np.zeros(0))[0] == pytest.approx(-residual, abs=1e-8)


def test_a_system_that_is_interrupted_before_its_solver_is_set_up_can_be_destroyed(monkeypatch):
    system, _ = filled(200, 6, "auto")
    monkeypatch.setattr(system, "_fill_reduced", lambda raised: os.kill(os.getpid(), signal.SIGTERM))
    with stop_signals(), pytest.raises(Stopped):
        system.factor()
    system.destroy()
