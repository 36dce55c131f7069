"""Principal values and directions of symmetric 3x3 matrices by Jacobi rotations, and the matrices from them.

Jacobi rotations keep full accuracy for repeated values, where closed formulas lose digits. LANES matrices are rotated
together. Entry ij of all of them is contiguous in memory, so that every operation uses the processor's vector
registers; sweeps are repeated until the slowest matrix has converged, nearly always four times.
"""

import numpy as np

from hybrid.runtime.jit import njit, prange

LANES = 32
SWEEPS = 30


def principal(matrices):
    """Eigenvalues (n, 3) and eigenvectors as columns (n, 3, 3) of symmetric matrices (n, 3, 3)."""
    values, directions = np.empty((len(matrices), 3)), np.empty((len(matrices), 3, 3))
    put_principal(matrices, values, directions)
    return values, directions


def from_principal(values, directions):
    """Tensors Σ values_i n_i ⊗ n_i (n, 3, 3) from values (n, 3) and directions (n, 3, 3), its columns n_i."""
    out = np.empty_like(directions)
    _from_principal(values, directions, out)
    return out


@njit(cache=True, error_model="numpy", fastmath={"contract"})
def _diagonalise(a, v, m):
    """Fill a[:3] with the eigenvalues of the first m matrices, and v[j, i] with component i of their eigenvectors j."""
    for i in range(3):
        for j in range(3):
            for n in range(m):
                v[j, i, n] = 1.0 if i == j else 0.0
    for _sweep in range(SWEEPS):
        left = 0.0
        for n in range(m):
            left = max(left, abs(a[3, n]) + abs(a[4, n]) + abs(a[5, n])
                       - 1e-16 * (abs(a[0, n]) + abs(a[1, n]) + abs(a[2, n])))
        if left <= 0.0:
            return
        _rotate(a[0], a[1], a[3], a[4], a[5], v[0], v[1], m)
        _rotate(a[0], a[2], a[4], a[3], a[5], v[0], v[2], m)
        _rotate(a[1], a[2], a[5], a[3], a[4], v[1], v[2], m)


@njit(cache=True, error_model="numpy", fastmath={"contract"})
def _rotate(app, aqq, apq, arp, arq, vp, vq, m):
    """Rotate m matrices so that entry pq becomes zero. The tangent of the angle is computed without a branch."""
    for n in range(m):
        apart = aqq[n] - app[n]
        size = abs(apart) + np.sqrt(apart * apart + 4.0 * apq[n] * apq[n]) + 1e-300
        t = 2.0 * apq[n] / size
        t = t if apart >= 0.0 else -t
        c = 1.0 / np.sqrt(t * t + 1.0)
        s = t * c
        app[n] -= t * apq[n]
        aqq[n] += t * apq[n]
        apq[n] = 0.0
        x, y = arp[n], arq[n]
        arp[n], arq[n] = c * x - s * y, s * x + c * y
        for i in range(3):
            x, y = vp[i, n], vq[i, n]
            vp[i, n], vq[i, n] = c * x - s * y, s * x + c * y


@njit(cache=True, parallel=True)
def put_principal(matrices, values, directions):
    """Fill `values` (n, 3) and `directions` (n, 3, 3) as `principal` returns them.

    For each block of LANES matrices a (6, LANES) holds the entries 00 11 22 01 02 12, v (3, 3, LANES) the eigenvectors.
    """
    for block in prange((len(matrices) + LANES - 1) // LANES):
        a, v, begin = np.empty((6, LANES)), np.empty((3, 3, LANES)), block * LANES
        m = min(LANES, len(matrices) - begin)
        for n in range(m):
            p = begin + n
            a[0, n], a[1, n], a[2, n] = matrices[p, 0, 0], matrices[p, 1, 1], matrices[p, 2, 2]
            a[3, n], a[4, n], a[5, n] = matrices[p, 0, 1], matrices[p, 0, 2], matrices[p, 1, 2]
        _diagonalise(a, v, m)
        for n in range(m):
            p = begin + n
            for j in range(3):
                values[p, j] = a[j, n]
                for i in range(3):
                    directions[p, i, j] = v[j, i, n]


@njit(cache=True, parallel=True)
def _from_principal(values, directions, out):
    for p in prange(len(values)):
        compose(values[p, 0], values[p, 1], values[p, 2], directions[p], out[p])


@njit(cache=True, fastmath={"contract"})
def compose(first, second, third, n, out):
    """Fill `out` (3, 3) with the tensor of three principal values and directions n_i, the columns of n (3, 3)."""
    for i in range(3):
        x, y, z = first * n[i, 0], second * n[i, 1], third * n[i, 2]
        for j in range(3):
            out[i, j] = x * n[j, 0] + y * n[j, 1] + z * n[j, 2]
