"""Deformation of the points during a step, and update of F, b_e and stress on acceptance: FORMULATION (8), (9).

    ΔF = I + Σ_v Δu_v ⊗ ∇_n S_v      b_trial = ΔF b_e ΔF^T      ε = ½ ln b_trial = Σ ε_i n_i ⊗ n_i

With F-bar (`hybrid.soil.fbar`) ΔF is scaled to det ΔF = det ΔF_0 before b_trial is formed.
"""

from typing import NamedTuple

import numpy as np

from hybrid.grid.numbering import node_number
from hybrid.runtime.jit import njit, prange
from hybrid.soil.basis import with_margin
from hybrid.soil.buffers import resized
from hybrid.soil.matrices import determinant, invert, product, product_transposed
from hybrid.soil.principal import compose, principal, put_principal

# F is reset to an isotropic stretch of the same volume when any |F_ij| > F_LIMIT; that stretch is capped at
# STRETCH_LIMIT. A domain is never wider than its cell, so F beyond the limit does not change it.
F_LIMIT, STRETCH_LIMIT = 100.0, 10.0


class TrialStrain:
    """Trial kinematics of all points, in buffers that a later evaluation overwrites.

    increment     (n, 3, 3) ΔF
    inverse       (n, 3, 3) ΔF^-1
    strain        (n, 3) principal logarithmic trial strain
    directions    (n, 3, 3) principal directions of the strain, as columns
    mean_inverse  (n, 3, 3) ΔF_0^-1 of F-bar, else None
    inverted      numbers of the points with det ΔF <= 0

    `valid` is False after the buffers have been overwritten; from then on, reading the arrays raises an AssertionError.
    """

    def __init__(self, buffers, inverted):
        self._buffers, self._version, self.inverted = buffers, buffers.version, inverted

    @property
    def valid(self):
        return self._version == self._buffers.version

    def _checked(self):
        assert self.valid, ("a trial strain is read after a later evaluation has overwritten its buffers; pass the "
                            "trial as `keep` to the evaluations that it has to survive")
        return self._buffers

    @property
    def increment(self):
        return self._checked().increment

    @property
    def inverse(self):
        return self._checked().inverse

    @property
    def strain(self):
        return self._checked().strain

    @property
    def directions(self):
        return self._checked().directions

    @property
    def mean_inverse(self):
        return self._checked().mean_inverse


class _Buffers:
    """Memory of one TrialStrain; version: number of evaluations that have written to it."""

    def __init__(self, n, fbar):
        self.increment, self.inverse, self.directions = (np.empty((n, 3, 3)) for _ in range(3))
        self.strain, self.mean_inverse = np.empty((n, 3)), np.empty((n, 3, 3)) if fbar else None
        self.version = 0

    def resize(self, n):
        """Room for n points; what was written is lost."""
        self.increment, self.inverse, self.directions, self.strain = (
            resized(buffer, n) for buffer in (self.increment, self.inverse, self.directions, self.strain))
        self.mean_inverse = None if self.mean_inverse is None else resized(self.mean_inverse, n)
        self.version += 1


class _TrialArrays(NamedTuple):
    """ΔF, ΔF^-1 and b_trial (n, 3, 3), and whether det ΔF <= 0 (n,) bool."""

    increment: np.ndarray
    inverse: np.ndarray
    b_trial: np.ndarray
    inverted: np.ndarray


class _UpdatedArrays(NamedTuple):
    """F, b_e and σ [Pa] of the next state, each (n, 3, 3)."""

    deformation: np.ndarray
    b_elastic: np.ndarray
    cauchy: np.ndarray


class Kinematics:
    """Evaluates trial strains of n points into its own buffers, so that no evaluation allocates memory.

    There are two sets of buffers, so that one trial can be kept while others are evaluated. The pages of the second set
    are not used, and take no physical memory, until a trial is kept for the first time.
    """

    def __init__(self, n, fbar=False):
        self._sets = tuple(_Buffers(n, fbar) for _ in range(2))
        self._b_trial, self._inverted = np.empty((n, 3, 3)), np.zeros(n, bool)
        self._mean_volume = np.empty(n if fbar else 0)

    def resize(self, n):
        """Room for n points; trials of before are no longer valid."""
        for buffers in self._sets:
            buffers.resize(n)
        self._b_trial, self._inverted = resized(self._b_trial, n), resized(self._inverted, n)
        if self._sets[0].mean_inverse is not None:
            self._mean_volume = resized(self._mean_volume, n)

    def __call__(self, basis, shape, displacement, b_elastic, mean=None, inactive=None, keep=None):
        """TrialStrain from nodal increments (N, 3) [m] and committed b_e (n, 3, 3).

        mean: the basis of F-bar; inactive: (n,) bool, points that are not listed in `inverted`; keep: a TrialStrain
        whose buffers are not overwritten.
        """
        assert keep is None or keep.valid, "a trial strain cannot be kept after its buffers have been overwritten"
        buffers = next(one for one in self._sets if keep is None or one is not keep._buffers)
        buffers.version += 1
        shape = tuple(shape)
        deforms, nodal = np.array(shape) > 1, with_margin(displacement, shape)
        if mean is not None:
            _volumes(mean, shape, nodal, buffers.mean_inverse, self._mean_volume)
        _trial_b(basis, shape, nodal, b_elastic, self._mean_volume, deforms,
                 _TrialArrays(buffers.increment, buffers.inverse, self._b_trial, self._inverted))
        put_principal(self._b_trial, buffers.strain, buffers.directions)
        _logarithms(buffers.strain)
        return TrialStrain(buffers, np.flatnonzero(self._inverted if inactive is None else self._inverted & ~inactive))


@njit(cache=True, parallel=True)
def _volumes(basis, shape, u, inverse, volume):
    first, _, value, gradient = basis
    chunk = 256
    for block in prange((len(volume) + chunk - 1) // chunk):
        F = np.empty((3, 3))
        for p in range(block * chunk, min(len(volume), (block + 1) * chunk)):
            _gradient(p, first, value, gradient, shape, u, F)
            for i in range(3):
                F[i, i] += 1.0
            volume[p] = invert(F, inverse[p])


@njit(cache=True, parallel=True, error_model="numpy")
def _trial_b(basis, shape, u, elastic, mean_volume, deforms, out):
    """Fill `out` (_TrialArrays). mean_volume: (n,) det ΔF_0 of F-bar, or (0,)."""
    (first, _, value, gradient), (increment, inverse, b_trial, inverted) = basis, out
    chunk, axes = 256, np.sum(deforms)
    for block in prange((len(increment) + chunk - 1) // chunk):
        half, scaled = np.empty((3, 3)), np.empty((3, 3))
        for p in range(block * chunk, min(len(increment), (block + 1) * chunk)):
            F = increment[p]
            _gradient(p, first, value, gradient, shape, u, F)
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
            product(scaled, elastic[p], half)
            product_transposed(half, scaled, b_trial[p])


def _logarithms(values):
    """Replace the principal values (n, 3) of b by ½ ln of them, in place."""
    np.maximum(values, 1e-300, out=values)
    np.log(values, out=values)
    values *= 0.5


@njit(cache=True, fastmath={"contract"})
def _gradient(p, first, value, gradient, shape, u, out):
    """Fill `out` with Σ_v u_v ⊗ ∇S_v at one point. The sum over z is the innermost, because all nodes of a column along
    z share the products of the other axes."""
    xx, xy, xz, yx, yy, yz, zx, zy, zz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    s0, s1, s2 = value[p, 2, 0], value[p, 2, 1], value[p, 2, 2]
    d0, d1, d2 = gradient[p, 2, 0], gradient[p, 2, 1], gradient[p, 2, 2]
    for a in range(3):
        for b in range(3):
            v = node_number(shape, first[p, 0] + a, first[p, 1] + b, first[p, 2])
            along_x, along_y = gradient[p, 0, a] * value[p, 1, b], value[p, 0, a] * gradient[p, 1, b]
            along_z = value[p, 0, a] * value[p, 1, b]
            sx = u[v, 0] * s0 + u[v + 1, 0] * s1 + u[v + 2, 0] * s2
            sy = u[v, 1] * s0 + u[v + 1, 1] * s1 + u[v + 2, 1] * s2
            sz = u[v, 2] * s0 + u[v + 1, 2] * s1 + u[v + 2, 2] * s2
            xx += sx * along_x
            yx += sy * along_x
            zx += sz * along_x
            xy += sx * along_y
            yy += sy * along_y
            zy += sz * along_y
            xz += (u[v, 0] * d0 + u[v + 1, 0] * d1 + u[v + 2, 0] * d2) * along_z
            yz += (u[v, 1] * d0 + u[v + 1, 1] * d1 + u[v + 2, 1] * d2) * along_z
            zz += (u[v, 2] * d0 + u[v + 1, 2] * d1 + u[v + 2, 2] * d2) * along_z
    out[0, 0], out[0, 1], out[0, 2] = xx, xy, xz
    out[1, 0], out[1, 1], out[1, 2] = yx, yy, yz
    out[2, 0], out[2, 1], out[2, 2] = zx, zy, zz


def update_strains(trial, elastic, stress, old, deforms):
    """Updated F = ΔF F_n, b_e = Σ exp(2 ε_i) n_i ⊗ n_i and Cauchy stress σ = τ / det F [Pa], each (n, 3, 3).

    elastic: ε (n, 3), elastic strains after the stress return; stress: Kirchhoff τ (n, 3, 3) [Pa]; old: Points at the
    start of the step; deforms: (3,) bool, axes that deform. F is reset to an isotropic stretch of the same volume when
    any |F_ij| > F_LIMIT: where the grid pulls loose sand apart, F would grow until det F is round-off, then negative.
    """
    deformation, b_elastic, cauchy = (np.empty_like(old.deformation) for _ in range(3))
    _update(trial.increment, trial.directions, elastic, stress, old.deformation, deforms,
            _UpdatedArrays(deformation, b_elastic, cauchy))
    return deformation, b_elastic, cauchy


def logarithmic(b):
    """Principal logarithmic strains ½ ln b_i (n, 3) of b (n, 3, 3)."""
    return 0.5 * np.log(principal(b)[0])


@njit(cache=True, parallel=True, error_model="numpy", fastmath={"contract"})
def _update(increment, directions, strain, stress, old, deforms, out):
    deformation, b_elastic, cauchy = out
    for p in prange(len(old)):
        F = deformation[p]
        product(increment[p], old[p], F)
        if _largest(F) > F_LIMIT:
            _reset(F, deforms)
        inverse_J = 1.0 / determinant(F)
        compose(np.exp(2 * strain[p, 0]), np.exp(2 * strain[p, 1]), np.exp(2 * strain[p, 2]), directions[p], b_elastic[p])
        for i in range(3):
            for j in range(3):
                cauchy[p, i, j] = stress[p, i, j] * inverse_J


@njit(cache=True)
def _largest(F):
    most = 0.0
    for i in range(3):
        for j in range(3):
            most = max(most, abs(F[i, j]))
    return most


@njit(cache=True)
def _reset(F, deforms):
    """Reset F to the isotropic stretch (det F)^(1/n) along the n axes that deform, at most STRETCH_LIMIT."""
    stretch = min(abs(determinant(F)) ** (1.0 / np.sum(deforms)), STRETCH_LIMIT)
    for i in range(3):
        for j in range(3):
            F[i, j] = (stretch if deforms[i] else 1.0) if i == j else 0.0
