"""Approximate inverses M^-1 of K_uu that precondition GMRES: their options in PETSc, and what keeps their pivots away
from zero.

M^-1 is one of three: a symmetric Gauss-Seidel (SSOR) sweep over the blocks of nodes; ILU(0); ILU(0) of a matrix whose
diagonal is raised by half, which is stable where the soil is nearly incompressible and ILU(0) is of no use. Where none
of them converges at a reasonable cost, a direct factor (MUMPS, of all of K_uu) takes their place, if it fits in memory.
`hybrid.linalg.solver_choice` decides the order by the iterations counted. A sweep needs no factor, preserves positive
definiteness and does not converge more slowly with stiff contact, so it is used first where the soil's tangent is
symmetric. In sand, to a relative residual of 1e-2, sweeps over blocks take 13 GMRES iterations, sweeps over rows 14
(19 600 unknowns); with 103 000 unknowns they take 15 to 25, and 25 to 28.

All three are computed from a part of the entries (`hybrid.linalg.precond_pattern`): with only the entries that couple nodes
of one cell, the factor of 15 600 unknowns takes 0.04 s instead of 0.35 s, and GMRES needs 8 iterations instead of 4 to
1e-3, in the same time.
"""

import numpy as np

from hybrid.linalg.solver_choice import DIRECT, ILU0, ILU0_SHIFTED, SSOR

# PETSc options of M^-1. A node that domains hardly overlap has a row with very small entries and an even smaller pivot.
# Elimination without pivoting does not depend on the scale of rows and columns, so only a pivot of exactly zero is an
# error. Sweeps go forward and backward, PETSc's default. PETSc inverts the diagonal block of each node (its rows have the
# same sparsity) unless a shift or relaxation is set, but treats a scalar pivot below 2e-14 as zero: diagonals are raised
# to SMALLEST_DIAGONAL [N/m]. An exact zero would be an error; it is replaced by ZERO_DIAGONAL, with which sweeps diverge.
ILU_OPTIONS = {"ksp_type": "preonly", "pc_type": "ilu", "pc_factor_zeropivot": 0.0}
INVERSES = {
    SSOR: {"ksp_type": "preonly", "pc_type": "sor"},
    ILU0: ILU_OPTIONS,
    ILU0_SHIFTED: ILU_OPTIONS,
    DIRECT: {"ksp_type": "preonly", "pc_type": "lu", "pc_factor_mat_solver_type": "mumps"},
}
SMALLEST_DIAGONAL, ZERO_DIAGONAL = 1e-13, 1e-300
# Factor on the diagonal before ILU0_SHIFTED. Iterations for clay (von Mises, ν = 0.49, F-bar) of 4 800, 17 600 and
# 52 600 unknowns, to 1e-3: 1.2 stagnates; 1.3: 66, 114, 133; 1.5: 76, 142, 167; 2: 99, 198, 193.
RAISED = 1.5


def lift(values, places):
    """Raise the diagonal entries `values[places]` that PETSc would treat as zero in a sweep, keeping their sign."""
    diagonal = values[places]
    if (small := np.abs(diagonal) < SMALLEST_DIAGONAL).any():
        raised = np.copysign(SMALLEST_DIAGONAL, diagonal[small])
        values[places[small]] = np.where(diagonal[small] == 0.0, ZERO_DIAGONAL, raised)
