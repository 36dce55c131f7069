"""Deformation of the points during a step, and what follows from it on acceptance.

    ΔF = I + Σ_v Δu_v ⊗ ∇_n S_v      b_trial = ΔF b_e ΔF^T      ε = ½ ln b_trial = Σ ε_i n_i ⊗ n_i

F-bar (`hybrid.soil.fbar`) scales ΔF before b_trial is formed, so that its determinant is that of ΔF_0.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit, prange

from hybrid.soil.eigen import LANES, diagonalise, lanes, principal, put_in, take_out


@dataclass(frozen=True)
class TrialStrain:
    """Trial kinematics of all points.

    increment: (n, 3, 3) ΔF; inverse: (n, 3, 3) ΔF^-1; strain: (n, 3) principal logarithmic trial strain;
    directions: (n, 3, 3) eigenvectors as columns; inverted: numbers of points with det ΔF <= 0;
    mean_inverse: (n, 3, 3) ΔF_0^-1 of F-bar, else None.
    """

    increment: np.ndarray
    inverse: np.ndarray
    strain: np.ndarray
    directions: np.ndarray
    inverted: np.ndarray
    mean_inverse: np.ndarray | None = None


class Kinematics:
    """Evaluates trial strains into buffers it keeps, so that no memory is touched for the first time in a step."""

    def __init__(self, n, fbar=False):
        self._increment, self._inverse, self._directions = (np.empty((n, 3, 3)) for _ in range(3))
        self._strain = np.empty((n, 3))
        self._inverted = np.zeros(n, bool)
        self._mean_inverse, self._mean_volume = (np.empty((n, 3, 3)), np.empty(n)) if fbar else (None, np.empty(0))

    def __call__(self, basis, shape, displacement, elastic, mean=None, out=None):
        """TrialStrain from nodal increments (N, 3) [m] and committed b_e (n, 3, 3); mean: the basis of F-bar; out: (n,)
        bool, points that may be inverted, taking no part."""
        deforms = np.array(shape) > 1
        if mean is not None:
            _volumes(mean.first, mean.count, mean.value, mean.slope, shape[1], shape[2], displacement,
                     self._mean_inverse, self._mean_volume)
        _trial_strain(basis.first, basis.count, basis.value, basis.slope, shape[1], shape[2], displacement, elastic,
                      self._mean_volume, deforms, int(deforms.sum()), self._increment, self._inverse, self._strain,
                      self._directions, self._inverted)
        return TrialStrain(self._increment, self._inverse, self._strain, self._directions,
                           np.flatnonzero(self._inverted if out is None else self._inverted & ~out),
                           self._mean_inverse)


@njit(cache=True, error_model="numpy")
def invert(a, out):
    """Inverse of a 3x3 matrix into `out`, not finite where it has none; returns the determinant."""
    c00 = a[1, 1] * a[2, 2] - a[1, 2] * a[2, 1]
    c01 = a[1, 2] * a[2, 0] - a[1, 0] * a[2, 2]
    c02 = a[1, 0] * a[2, 1] - a[1, 1] * a[2, 0]
    det = a[0, 0] * c00 + a[0, 1] * c01 + a[0, 2] * c02
    out[0, 0], out[1, 0], out[2, 0] = c00 / det, c01 / det, c02 / det
    out[0, 1] = (a[0, 2] * a[2, 1] - a[0, 1] * a[2, 2]) / det
    out[1, 1] = (a[0, 0] * a[2, 2] - a[0, 2] * a[2, 0]) / det
    out[2, 1] = (a[0, 1] * a[2, 0] - a[0, 0] * a[2, 1]) / det
    out[0, 2] = (a[0, 1] * a[1, 2] - a[0, 2] * a[1, 1]) / det
    out[1, 2] = (a[0, 2] * a[1, 0] - a[0, 0] * a[1, 2]) / det
    out[2, 2] = (a[0, 0] * a[1, 1] - a[0, 1] * a[1, 0]) / det
    return det


@njit(cache=True, parallel=True)
def _volumes(first, count, value, slope, ny, nz, u, inverse, volume):
    chunk = 256
    for block in prange((len(first) + chunk - 1) // chunk):
        F = np.empty((3, 3))
        for p in range(block * chunk, min(len(first), (block + 1) * chunk)):
            _gradient(p, first, count, value, slope, ny, nz, u, F)
            for i in range(3):
                F[i, i] += 1.0
            volume[p] = invert(F, inverse[p])


@njit(cache=True, parallel=True, error_model="numpy")
def _trial_strain(first, count, value, slope, ny, nz, u, elastic, mean_volume, deforms, axes, increment, inverse,
                  strain, directions, inverted):
    for block in prange((len(first) + LANES - 1) // LANES):
        b, half, scaled = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
        (a, v), begin = lanes(), block * LANES
        m = min(LANES, len(first) - begin)
        for n in range(m):
            p = begin + n
            F = increment[p]
            _gradient(p, first, count, value, slope, ny, nz, u, F)
            for i in range(3):
                F[i, i] += 1.0
            volume = invert(F, inverse[p])
            inverted[p] = not volume > 0.0
            scaled[...] = F
            if len(mean_volume) > 0:
                inverted[p] |= not mean_volume[p] > 0.0
                s = (abs(mean_volume[p] / volume)) ** (1.0 / axes)
                for i in range(3):
                    if deforms[i]:
                        scaled[i] *= s
            _product(scaled, elastic[p], half)
            _product_transposed(half, scaled, b)
            put_in(a, n, b)
        diagonalise(a, v, m)
        for n in range(m):
            take_out(a, v, n, strain[begin + n], directions[begin + n])
            for i in range(3):
                strain[begin + n, i] = 0.5 * np.log(max(strain[begin + n, i], 1e-300))


@njit(cache=True)
def _gradient(p, first, count, value, slope, ny, nz, u, out):
    """Σ_v u_v ⊗ ∇S_v at one point, summed along z first: the products of the other axes are the same for a column."""
    xx, xy, xz, yx, yy, yz, zx, zy, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for a in range(count[p, 0]):
        for b in range(count[p, 1]):
            v = ((first[p, 0] + a) * ny + first[p, 1] + b) * nz + first[p, 2]
            sx, sy, sz, dx, dy, dz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            for c in range(count[p, 2]):
                s, d = value[p, 2, c], slope[p, 2, c]
                sx += u[v + c, 0] * s
                sy += u[v + c, 1] * s
                sz += u[v + c, 2] * s
                dx += u[v + c, 0] * d
                dy += u[v + c, 1] * d
                dz += u[v + c, 2] * d
            along_x, along_y = slope[p, 0, a] * value[p, 1, b], value[p, 0, a] * slope[p, 1, b]
            along_z = value[p, 0, a] * value[p, 1, b]
            xx += sx * along_x
            yx += sy * along_x
            zx += sz * along_x
            xy += sx * along_y
            yy += sy * along_y
            zy += sz * along_y
            xz += dx * along_z
            yz += dy * along_z
            zz += dz * along_z
    out[0, 0], out[0, 1], out[0, 2] = xx, xy, xz
    out[1, 0], out[1, 1], out[1, 2] = yx, yy, yz
    out[2, 0], out[2, 1], out[2, 2] = zx, zy, zz


@njit(cache=True)
def _product(a, b, out):
    for i in range(3):
        for j in range(3):
            out[i, j] = a[i, 0] * b[0, j] + a[i, 1] * b[1, j] + a[i, 2] * b[2, j]


@njit(cache=True)
def _product_transposed(a, b, out):
    for i in range(3):
        for j in range(3):
            out[i, j] = a[i, 0] * b[j, 0] + a[i, 1] * b[j, 1] + a[i, 2] * b[j, 2]


def moved_on(increment, deformation):
    """F = ΔF F_n (n, 3, 3) and its determinant (n,)."""
    out, volume = np.empty_like(deformation), np.empty(len(deformation))
    _moved_on(increment, deformation, out, volume)
    return out, volume


def logarithmic(b):
    """Principal logarithmic strains ½ ln b_i (n, 3) of b (n, 3, 3)."""
    return 0.5 * np.log(principal(b)[0])


@njit(cache=True, parallel=True)
def _moved_on(increment, deformation, out, volume):
    for p in prange(len(out)):
        F = out[p]
        _product(increment[p], deformation[p], F)
        volume[p] = (F[0, 0] * (F[1, 1] * F[2, 2] - F[1, 2] * F[2, 1]) - F[0, 1] * (F[1, 0] * F[2, 2] - F[1, 2] * F[2, 0])
                     + F[0, 2] * (F[1, 0] * F[2, 1] - F[1, 1] * F[2, 0]))
