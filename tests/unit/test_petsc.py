"""The block system against a dense solution, whatever its preconditioner; memory given back."""

import numpy as np
import pytest
from scipy.sparse import csr_matrix, diags, random

from hybrid.errors import StepError
from hybrid.system.petsc import BlockSystem


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


@pytest.mark.parametrize("linear", ["krylov", "direct"])
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


def test_a_factor_of_the_near_entries_gives_the_same_solution():
    _, K = filled(200, 3, "krylov")
    uu = csr_matrix(K[:200, :200])
    near = abs(np.repeat(np.arange(200), np.diff(uu.indptr)) - uu.indices) < 80
    assert 0.2 < near.mean() < 0.8
    system = BlockSystem(uu.indptr, uu.indices, 3, "krylov", 1e-12, near)
    residual = np.ones(203)
    for scale in (1.0, 3.0):
        system.values[:], system.uw[:], system.wu[:] = scale * uu.data, K[:200, 200:], K[200:, :200]
        system.ww[:], K[:200, :200] = K[200:, 200:], scale * uu.toarray()
        system.factor()
        soil, body, count = system.solve(residual[:200], residual[200:])
        assert np.allclose(np.concatenate([soil, body]), -np.linalg.solve(K, residual), rtol=1e-9, atol=1e-11)
        assert count > 1


def test_a_singular_system_is_reported_with_advice():
    system, _ = filled(50, 3, "krylov")
    system.clear()
    system.values[...] = 0.0
    with pytest.raises(StepError, match="direct"):
        system.factor()
        system.solve(np.ones(50), np.ones(3))


def test_memory_is_given_back():
    def resident():
        with open("/proc/self/statm") as file:
            return int(file.read().split()[1]) * 4096 / 2**20

    n, k = 60000, 30
    indptr = np.arange(0, n * k + 1, k, dtype=np.int32)
    indices = np.sort((np.arange(n)[:, None] + np.arange(k)) % n, axis=1).astype(np.int32).ravel()
    column = np.repeat(np.arange(n), k)
    diagonal, near = np.flatnonzero(indices == column), abs(indices - column) < k // 2
    used = []
    for _ in range(6):
        system = BlockSystem(indptr.copy(), indices.copy(), 3, "krylov", 1e-4, near)
        system.values[diagonal], system.ww[:] = 1.0, np.eye(3)
        system.factor()
        system.solve(np.ones(n), np.ones(3))
        system.destroy()
        used.append(resident())
    assert used[-1] - used[1] < 40  # one factor and matrix are 40 MiB; leaking them would be 160
