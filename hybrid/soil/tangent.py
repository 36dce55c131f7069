"""Consistent tangent of one point in the current configuration, A, and pulled back to that of the step's start, Â.

    A_ijkl = ∂τ_ij/∂l_kl - τ_il δ_jk            Â_imkn = ΔF^-1_mj A_ijkl ΔF^-1_nl

In the principal frame of b_trial A has 21 entries. With D = ∂τ_i/∂ε_j and a ≠ b,

    A_aacc = D_ac - τ_a δ_ac       A_abab = b_b κ_ab       A_abba = b_a κ_ab - τ_a       κ_ab = (τ_a - τ_b)/(b_a - b_b)

and κ_ab -> (D_aa - D_ab)/(2 b_a) for equal principal values. In the frame of the grid A is thus a sum of nine dyads,

    A = Σ_ab P_ab ⊗ Q_ab        P_ab = n_a ⊗ n_b        Q_aa = Σ_c A_aacc P_cc        Q_ab = A_abab P_ab + A_abba P_ba

summed over a first and then over b. Â is the same sum with P_ab = n_a ⊗ ΔF^-1 n_b.

Equations: FORMULATION (12), (13).
"""

import numpy as np

from hybrid.runtime.jit import njit

# Unsigned indices: numba tests at every access whether a signed one is negative, which costs more than the sum.
ONE, TWO, THREE, FOUR, FIVE, SIX, SEVEN, EIGHT = (np.uintp(i) for i in range(1, 9))


@njit(cache=True, fastmath={"contract"})
def point_tangent(first, second, strain, stress, tangent, A, work):
    """Fill A (81,) with A_ijkl of one point, entry ijkl at 9 (3i + j) + 3k + l.

    first, second: (3, 3) directions n_a as columns; if `second` has ΔF^-1 n_a as columns instead, the result is Â.
    strain, stress: (3,) principal trial strains and Kirchhoff stresses; tangent: D (3, 3); work: (3, 81) scratch.
    """
    P, Q, R = work[0], work[1], work[2]
    for a in range(3):
        for b in range(3):
            for i in range(3):
                for j in range(3):
                    P[27 * a + 9 * b + 3 * i + j] = first[i, a] * second[j, b]
    big = (np.exp(2 * strain[0]), np.exp(2 * strain[1]), np.exp(2 * strain[2]))
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        combine(Q, 36 * a, P, 36 * a, 36 * b, 36 * c, tangent[a, a] - stress[a], tangent[a, b], tangent[a, c])
        ab, ba = 27 * a + 9 * b, 27 * b + 9 * a
        if abs(strain[a] - strain[b]) > 1e-7:
            kappa = (stress[a] - stress[b]) / (big[a] - big[b])
        else:
            kappa = 0.5 * (tangent[a, a] - tangent[a, b] + tangent[b, b] - tangent[b, a]) / (big[a] + big[b])
        cross = big[a] * kappa - stress[a]      # = big[b] κ - stress[b]
        combine(Q, ab, P, ab, ba, ab, big[b] * kappa, cross, 0.0)
        combine(Q, ba, P, ba, ab, ba, big[a] * kappa, cross, 0.0)
    for i in range(3):
        for b in range(3):
            combine(R, 9 * b, Q, 9 * b, 27 + 9 * b, 54 + 9 * b, first[i, 0], first[i, 1], first[i, 2])
        for j in range(3):
            combine(A, 27 * i + 9 * j, R, 0, 9, 18, second[j, 0], second[j, 1], second[j, 2])


@njit(cache=True, fastmath={"contract"})
def combine(out, at, B, p, q, r, x, y, z):
    """Nine entries of x B_p + y B_q + z B_r. All reads precede all writes, so that the compiler can use the processor's
    vector registers."""
    at, p, q, r = np.uintp(at), np.uintp(p), np.uintp(q), np.uintp(r)
    one = x * B[p] + y * B[q] + z * B[r]
    two = x * B[p + ONE] + y * B[q + ONE] + z * B[r + ONE]
    three = x * B[p + TWO] + y * B[q + TWO] + z * B[r + TWO]
    four = x * B[p + THREE] + y * B[q + THREE] + z * B[r + THREE]
    five = x * B[p + FOUR] + y * B[q + FOUR] + z * B[r + FOUR]
    six = x * B[p + FIVE] + y * B[q + FIVE] + z * B[r + FIVE]
    seven = x * B[p + SIX] + y * B[q + SIX] + z * B[r + SIX]
    eight = x * B[p + SEVEN] + y * B[q + SEVEN] + z * B[r + SEVEN]
    nine = x * B[p + EIGHT] + y * B[q + EIGHT] + z * B[r + EIGHT]
    out[at], out[at + ONE], out[at + TWO], out[at + THREE] = one, two, three, four
    out[at + FOUR], out[at + FIVE], out[at + SIX], out[at + SEVEN] = five, six, seven, eight
    out[at + EIGHT] = nine


@njit(cache=True)
def pulled_back(inverse, directions, out):
    """Fill `out` (3, 3) with ΔF^-1 n_a of one point as columns; inverse: ΔF^-1 (3, 3); directions: n_a as columns."""
    for m in range(3):
        for a in range(3):
            out[m, a] = (inverse[m, 0] * directions[0, a] + inverse[m, 1] * directions[1, a]
                         + inverse[m, 2] * directions[2, a])
