"""Consistent tangent of the internal force, added into the sparse soil block.

    K_vw,ik   = Σ_p V0 g_v,j A_ijkl g_w,l           A_ijkl = ∂τ_ij/∂l_kl - τ_il δ_jk

(FORMULATION (12); g, τ and V0 as in `hybrid.soil.forces`, A in `hybrid.soil.tangent`, sums over points in
`hybrid.soil.boxes`, the terms of F-bar in `hybrid.soil.fbar`).

Within an increment ∇_n S is fixed, so a point's part of K is linear in the 81 numbers

    Â_imkn = ΔF^-1_mj A_ijkl ΔF^-1_nl        K_vw,ik = Σ_p V0 ∂_m S_v Â_imkn ∂_n S_w

From one Newton iteration to the next these change little, except in the few points that yield. So the assembled values
are kept, and only points whose D, τ or ΔF^-1 has changed by more than a tolerance compute Â anew and add the difference.
With F-bar the tangent of a point follows from 110 numbers, which are kept in the same way; the difference is formed in the
arrays B and S.
"""

from typing import NamedTuple
from weakref import ref

import numpy as np

from hybrid.runtime.jit import njit, prange
from hybrid.soil import ghost
from hybrid.soil.buffers import resized
from hybrid.soil.boxes import (
    NODES, STRIDE, add_box, add_point, box_widths, columns_reached, contract, empty_box, enter, is_in, move)
from hybrid.soil.fbar import COUNT, add_mean_terms, mean_dilatation, mean_tangent, project
from hybrid.soil.forces import reference_gradients
from hybrid.soil.tangent import point_tangent, pulled_back


class _PointState(NamedTuple):
    """What the tangent of the points follows from: ΔF^-1 (n, 3, 3), principal trial strain (n, 3), its directions
    (n, 3, 3), principal Kirchhoff stress τ (n, 3) [Pa], D = ∂τ/∂ε (n, 3, 3) [Pa], V0 (n,) [m³]."""

    inverse: np.ndarray
    strain: np.ndarray
    directions: np.ndarray
    stress: np.ndarray
    tangent: np.ndarray
    volume: np.ndarray


class _Kept(NamedTuple):
    """Numbers (n, 81), with F-bar (n, 110), of the points last added; changed: (n,) bool, points to add; fresh: whether all
    points are added to a matrix of zeros. No rows of numbers where nothing is kept."""

    numbers: np.ndarray
    changed: np.ndarray
    fresh: bool


class Origin(NamedTuple):
    """What the numbers of the points last added were computed from: D (n, 3, 3) and τ (n, 3) [Pa], ΔF^-1 and ΔF_0^-1
    (n, 3, 3), without F-bar the former twice."""

    tangent: np.ndarray
    stress: np.ndarray
    inverse: np.ndarray
    mean_inverse: np.ndarray


def add_stiffness(step, grid, trial, principal_stress, tangent, volume, pattern, values):
    """Add the consistent tangent to the entries `values` of a matrix of sparsity `pattern`; with F-bar where the `step`
    (SoilStep) has a mean basis.

    trial: TrialStrain; principal_stress: (n, 3) Kirchhoff [Pa]; tangent: D (n, 3, 3) [Pa]; volume: (n,) initial [m³].
    """
    points = _PointState(trial.inverse, trial.strain, trial.directions, principal_stress, tangent, volume)
    kept = _Kept(np.zeros((0, 81)), np.ones(len(volume), bool), True)
    _add_stiffness(step.slabs, step.basis, grid.shape, points, pattern.sparsity, values, kept,
                   mean_dilatation(step.mean, grid.collapsed, trial))


class KeptStiffness:
    """Tangent of one increment after another. Within an increment only points are assembled again whose D or τ has changed
    by more than `tolerance` times Young's modulus (n,) [Pa], or whose ΔF^-1 has by the same share of D.

    values: entries of the matrix, for the pattern of the last update
    """

    def __init__(self, tolerance, young, fbar):
        n = len(young)
        self._tolerance, self._limit, self._changed = tolerance, tolerance * young, np.empty(n, bool)
        self._numbers = np.empty((n, COUNT if fbar else 81))
        self._origin = Origin(*(np.empty(shape) for shape in ((n, 3, 3), (n, 3), (n, 3, 3), (n, 3, 3))))
        self._increment, self._pattern, self.values = lambda: None, None, np.zeros(0)

    def follow_points(self, young):
        """Go on with other points, of Young's moduli (n,) [Pa]; the next update assembles all of them."""
        n = len(young)
        self._limit, self._changed = self._tolerance * young, resized(self._changed, n)
        self._numbers = resized(self._numbers, n)
        self._origin = Origin(*(resized(array, n) for array in self._origin))
        self._increment = lambda: None

    def update(self, increment, grid, trial, principal_stress, tangent, volume, pattern, share=1.0):
        """Bring `values` up to date with a trial strain of an `increment` (SoilStep); the first update of an increment
        assembles all points. share: [-] of the tolerance to apply."""
        fresh = increment is not self._increment() or pattern is not self._pattern
        if pattern is not self._pattern:
            self._pattern = self.values = None      # frees the old values before the new ones are allocated
            self.values = np.empty(len(pattern.indices))
        if fresh:
            self._increment, self._pattern = ref(increment), pattern    # a weak reference: a past step can be freed
            self.values[...] = 0.0
            if increment.cuts:      # constant: displacements of an increment do not change it
                ghost.add_stiffness(increment.cuts, grid, pattern, self.values)
        points = _PointState(trial.inverse, trial.strain, trial.directions, principal_stress, tangent, volume)
        dilatation = mean_dilatation(increment.mean, grid.collapsed, trial)
        now = Origin(tangent, principal_stress, trial.inverse, trial.inverse if dilatation is None else dilatation.inverse)
        limit = np.full_like(self._limit, -np.inf) if fresh else share * self._limit
        mark_changed(now, self._origin, limit, self._changed)
        _add_stiffness(increment.slabs, increment.basis, grid.shape, points, pattern.sparsity, self.values,
                       _Kept(self._numbers, self._changed, fresh), dilatation)


@njit(cache=True, parallel=True)
def _add_stiffness(slabs, basis, shape, points, sparsity, values, kept, dilatation):
    """Add the tangent of all points. `dilatation`: MeanDilatation of F-bar or None; numba compiles either case without the
    branches of the other one."""
    order, start = slabs
    for colour in range(2):
        for pair in prange((len(start) - colour) // 2):
            slab = 2 * pair + colour
            _add_slab(order[start[slab]:start[slab + 1]], basis, shape, points, sparsity, values, kept, dilatation)


@njit(cache=True)
def _add_slab(order, basis, shape, points, sparsity, values, kept, dilatation):
    """Add the tangent of the points of one slab, box by box. Tuples are unpacked first, as access to their fields in the
    loop costs 10 %."""
    first, count, value, gradient = basis
    inverse, strain, directions, stress, tangent, volume = points
    numbers, changed, fresh = kept
    widths, deforms = box_widths(shape), np.array([n > 1 for n in shape])
    if dilatation is not None:
        mean_value, mean_inverse, deforms = dilatation
    box, node = empty_box(), np.empty(NODES, np.int64)
    number, column = np.empty(NODES + 1, np.int64), np.empty(NODES + 1, np.int64)
    new, A, dyads, pulled = np.empty(COUNT), np.empty(81), np.empty((3, 81)), np.empty((3, 3))
    g, E, B = np.empty((NODES + 1, 3)), np.empty(9 * STRIDE), np.empty((3, 6 * STRIDE))
    d, work, c, e = np.empty_like(g), np.empty_like(E), np.empty((3, 3)), np.empty((3, 3))      # of F-bar
    for p in order:
        if not changed[p]:
            continue
        if not is_in(box, first[p]):
            add_box(box, widths, shape, sparsity, values)
            move(box, first[p])
        if dilatation is None:
            pulled_back(inverse[p], directions[p], pulled)
            point_tangent(directions[p], pulled, strain[p], stress[p], tangent[p], new, dyads)
        else:
            point_tangent(directions[p], directions[p], strain[p], stress[p], tangent[p], A, dyads)
            scalars = project(A, directions[p], stress[p], deforms, c, e)
            mean_tangent(A, c, e, scalars, inverse[p], mean_inverse[p], dyads[0], new)
        if len(numbers) > 0:
            _replace(numbers[p], new, fresh)
        enter(box, count[p], widths, number, column)
        columns = columns_reached(count[p, 0], widths[2])
        m = reference_gradients(p, first, count, value, gradient, shape, node, g)
        g[m:] = 0.0
        contract(new, g, volume[p], column, m, columns, E, B)
        if dilatation is None:
            add_point(box.K, number, m, deforms, g, None, B, columns)
        else:
            reference_gradients(p, first, count, mean_value, gradient, shape, node, d)
            d[m:] = 0.0
            B[:, 3 * STRIDE:] = 0.0
            if fresh:
                add_mean_terms(new, volume[p], column, m, columns, g, d, work, B)
            else:
                add_mean_terms(numbers[p], volume[p], column, m, columns, g, d, work, B)
                add_mean_terms(new, -volume[p], column, m, columns, g, d, work, B)
            add_point(box.K, number, m, deforms, g, d, B, columns)
    add_box(box, widths, shape, sparsity, values)


@njit(cache=True)
def _replace(kept, new, fresh):
    """Keep the `new` numbers of a point. Where an earlier tangent of the point is replaced, `new` becomes what has to be
    added: the difference of Â, and the old values of the others, which enter the tangent of F-bar in products."""
    for n in range(len(kept)):
        before, kept[n] = kept[n], new[n]
        if not fresh:
            new[n] = new[n] - before if n < 81 else before


@njit(cache=True, parallel=True)
def copy_values(values, out):
    """Copy `values` (entries,) to `out`."""
    for n in prange(len(out)):
        out[n] = values[n]


@njit(cache=True, parallel=True)
def mark_changed(now, before, limit, changed):
    """Fill `changed` (n,): points where D or τ, or an inverse times the largest of these, is farther than the `limit` (n,)
    [Pa] from where it was `before`, which becomes what it is `now` there. A limit of -∞ marks all; one of zero passes over
    points that are where they were."""
    D, stress, inverse, mean_inverse = now
    D0, stress0, inverse0, mean_inverse0 = before
    for p in prange(len(limit)):
        change = modulus = turned = 0.0
        for i in range(3):
            change, modulus = max(change, abs(stress[p, i] - stress0[p, i])), max(modulus, abs(stress[p, i]))
            for j in range(3):
                change, modulus = max(change, abs(D[p, i, j] - D0[p, i, j])), max(modulus, abs(D[p, i, j]))
                turned = max(turned, abs(inverse[p, i, j] - inverse0[p, i, j]),
                             abs(mean_inverse[p, i, j] - mean_inverse0[p, i, j]))
        changed[p] = not max(change, modulus * turned) <= limit[p]
        if changed[p]:
            for i in range(3):
                stress0[p, i] = stress[p, i]
                for j in range(3):
                    D0[p, i, j], inverse0[p, i, j] = D[p, i, j], inverse[p, i, j]
                    mean_inverse0[p, i, j] = mean_inverse[p, i, j]
