"""Spatial tangent of one point, A_ijkl = ∂τ_ij/∂l_kl - τ_il δ_jk.

In the principal frame of b_trial, with D = ∂τ_i/∂ε_j,

    ∂τ_ii/∂l_kk = D_ik      ∂τ_ij/∂l_ij = b_j κ_ij      ∂τ_ij/∂l_ji = b_i κ_ij      κ_ij = (τ_i - τ_j)/(b_i - b_j)

and κ_ij -> (D_ii - D_ij)/(2 b_i) where two principal values meet. These are all its entries, and it is symmetric in ij:
that leaves 54 numbers to turn into the frame of the grid, one index at a time.
"""

import numpy as np
from numba import njit


@njit(cache=True, fastmath={"contract"})
def spatial_tangent(strain, directions, stress, tangent, A, work):
    """A_ijkl (9, 9) of one point, row 3i + j, column 3k + l; `work` is (2, 9, 9) scratch.

    M holds ∂τ_ij/∂l_cd with ij in the frame of the grid, in the order xx yy zz xy xz yz, and cd in the principal one.
    """
    n, M, N = directions, work[0], work[1]
    b = (np.exp(2 * strain[0]), np.exp(2 * strain[1]), np.exp(2 * strain[2]))
    for c in range(3):
        for s in range(3):
            N[c, s] = n[s, c] * n[s, c]
        N[c, 3], N[c, 4], N[c, 5] = n[0, c] * n[1, c], n[0, c] * n[2, c], n[1, c] * n[2, c]
    for c in range(3):
        for s in range(6):
            M[4 * c, s] = tangent[0, c] * N[0, s] + tangent[1, c] * N[1, s] + tangent[2, c] * N[2, s]
    tau = (stress[0] * N[0, 0] + stress[1] * N[1, 0] + stress[2] * N[2, 0],
           stress[0] * N[0, 1] + stress[1] * N[1, 1] + stress[2] * N[2, 1],
           stress[0] * N[0, 2] + stress[1] * N[1, 2] + stress[2] * N[2, 2],
           stress[0] * N[0, 3] + stress[1] * N[1, 3] + stress[2] * N[2, 3],
           stress[0] * N[0, 4] + stress[1] * N[1, 4] + stress[2] * N[2, 4],
           stress[0] * N[0, 5] + stress[1] * N[1, 5] + stress[2] * N[2, 5])
    for c in range(2):
        for d in range(c + 1, 3):
            if abs(strain[c] - strain[d]) > 1e-7:
                kappa = (stress[c] - stress[d]) / (b[c] - b[d])
            else:
                kappa = 0.5 * (tangent[c, c] - tangent[c, d] + tangent[d, d] - tangent[d, c]) / (b[c] + b[d])
            pair = (2 * n[0, c] * n[0, d], 2 * n[1, c] * n[1, d], 2 * n[2, c] * n[2, d],
                    n[0, c] * n[1, d] + n[0, d] * n[1, c], n[0, c] * n[2, d] + n[0, d] * n[2, c],
                    n[1, c] * n[2, d] + n[1, d] * n[2, c])
            for s in range(6):
                M[3 * c + d, s], M[3 * d + c, s] = b[d] * kappa * pair[s], b[c] * kappa * pair[s]
    for c in range(3):
        for l in range(3):
            for s in range(6):
                N[3 * c + l, s] = n[l, 0] * M[3 * c, s] + n[l, 1] * M[3 * c + 1, s] + n[l, 2] * M[3 * c + 2, s]
    for k in range(3):
        for l in range(3):
            for s in range(6):
                M[3 * k + l, s] = n[k, 0] * N[l, s] + n[k, 1] * N[3 + l, s] + n[k, 2] * N[6 + l, s]
    _spread(M, tau, A)


@njit(cache=True)
def _spread(M, tau, A):
    """All of A from what is symmetric in ij, less τ_il δ_jk."""
    for kl in range(9):
        A[0, kl], A[4, kl], A[8, kl] = M[kl, 0], M[kl, 1], M[kl, 2]
        A[1, kl] = A[3, kl] = M[kl, 3]
        A[2, kl] = A[6, kl] = M[kl, 4]
        A[5, kl] = A[7, kl] = M[kl, 5]
    xx, yy, zz, xy, xz, yz = tau
    for j in range(3):
        A[j, 3 * j] -= xx
        A[j, 3 * j + 1] -= xy
        A[j, 3 * j + 2] -= xz
        A[3 + j, 3 * j] -= xy
        A[3 + j, 3 * j + 1] -= yy
        A[3 + j, 3 * j + 2] -= yz
        A[6 + j, 3 * j] -= xz
        A[6 + j, 3 * j + 1] -= yz
        A[6 + j, 3 * j + 2] -= zz


@njit(cache=True, fastmath={"contract"})
def pull_back(A, inverse, work):
    """Â of a point in place of its A."""
    for i in range(3):
        for m in range(3):
            for kl in range(9):
                work[3 * i + m, kl] = (inverse[m, 0] * A[3 * i, kl] + inverse[m, 1] * A[3 * i + 1, kl]
                                       + inverse[m, 2] * A[3 * i + 2, kl])
    for im in range(9):
        for k in range(3):
            for n in range(3):
                A[im, 3 * k + n] = (work[im, 3 * k] * inverse[n, 0] + work[im, 3 * k + 1] * inverse[n, 1]
                                    + work[im, 3 * k + 2] * inverse[n, 2])
