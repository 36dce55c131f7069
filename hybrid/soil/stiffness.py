"""Consistent tangent of the internal force, added into the sparse soil block.

    K_vw,ik   = Σ_p V0 g_v,j A_ijkl g_w,l           A_ijkl = ∂τ_ij/∂l_kl - τ_il δ_jk

(FORMULATION (12); g, τ and V0 as in `hybrid.soil.forces`, A in `hybrid.soil.tangent`, rows in `hybrid.soil.rows`, the
terms of F-bar in `hybrid.soil.fbar`).

Within an increment ∇_n S is fixed, so a point's part of K is linear in the 81 numbers

    Â_imkn = ΔF^-1_mj A_ijkl ΔF^-1_nl        K_vw,ik = Σ_p V0 ∂_m S_v Â_imkn ∂_n S_w

From one Newton iteration to the next these change little, except in the few points that yield. So the assembled values
are kept, and only points whose Â has changed by more than a tolerance add the difference. With F-bar K is not linear in
Â, and is assembled anew.
"""

from typing import NamedTuple
from weakref import ref

import numpy as np
from numba import njit, prange

from hybrid.soil.fbar import add_mean_dilatation, mean_dilatation, project, subtract
from hybrid.soil.forces import current_gradients, reference_gradients
from hybrid.soil.rows import WIDTH, add_row, contract, find_stacks, free_components, scratch
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
    """Â (n, 81) last added, change (n,) [Pa] that is left out, and whether all points are added anew; (0, 81) and (0,)
    where nothing is kept."""

    tensors: np.ndarray
    limit: np.ndarray
    fresh: bool


NOTHING = _Kept(np.zeros((0, 81)), np.zeros(0), True)


def add_stiffness(step, grid, trial, principal_stress, tangent, volume, pattern, values):
    """Add the consistent tangent to the entries `values` of a matrix of sparsity `pattern`; with F-bar where the `step`
    (SoilStep) has a mean basis.

    trial: TrialStrain; principal_stress: (n, 3) Kirchhoff [Pa]; tangent: D (n, 3, 3) [Pa]; volume: (n,) initial [m³].
    """
    dilatation = None if step.mean is None else mean_dilatation(step, grid.collapsed, trial)
    points = _PointState(trial.inverse, trial.strain, trial.directions, principal_stress, tangent, volume)
    _add_stiffness(step.slabs, step.basis, grid.shape, points, pattern.sparsity, values, NOTHING, dilatation)


class KeptStiffness:
    """Tangent of one increment after another. Within an increment only points whose Â has changed by more than
    `tolerance` times Young's modulus (n,) [Pa] are assembled again.

    values: entries of the matrix, for the pattern of the last update
    """

    def __init__(self, tolerance, young):
        self._limit, self._tensors = tolerance * young, np.empty((len(young), 81))
        self._increment, self._pattern, self.values = lambda: None, None, np.zeros(0)

    def update(self, increment, shape, trial, principal_stress, tangent, volume, pattern, share=1.0):
        """Bring `values` up to date with a trial strain of an `increment` (SoilStep); the first update of an increment
        assembles all points. share: [-] of the tolerance to apply."""
        fresh = increment is not self._increment() or pattern is not self._pattern
        if pattern is not self._pattern:
            self._pattern = self.values = None      # frees the old values before the new ones are allocated
            self.values = np.empty(len(pattern.indices))
        if fresh:
            self._increment, self._pattern = ref(increment), pattern    # a weak reference: a past step can be freed
            self.values[...] = 0.0
        points = _PointState(trial.inverse, trial.strain, trial.directions, principal_stress, tangent, volume)
        _add_stiffness(increment.slabs, increment.basis, shape, points, pattern.sparsity, self.values,
                       _Kept(self._tensors, share * self._limit, fresh), None)


@njit(cache=True, parallel=True)
def _add_stiffness(slabs, basis, shape, points, sparsity, values, kept, dilatation):
    """Add the tangent of all points. `dilatation`: MeanDilatation of F-bar or None; numba compiles either case without
    the branches of the other one. Tuples are unpacked first, as access to their fields in the loops costs 10 %."""
    (order, start), (first, count, value, gradient) = slabs, basis
    dof, row, slot, indptr = sparsity
    inverse, strain, directions, stress, tangent, volume = points
    tensors, limit, fresh = kept
    for colour in range(2):
        for pair in prange((len(start) - colour) // 2):
            slab = 2 * pair + colour
            node, g, local, unknown, stack, place = scratch()
            A, dyads, pulled, B = np.empty(81), np.empty((3, 81)), np.empty((3, 3)), np.empty(9 * 81)
            h, H, S, ce = np.empty((27, 3)), np.empty((27, 3)), np.empty(9 * 81), np.empty((2, 3, 3))   # of F-bar
            for n in range(start[slab], start[slab + 1]):
                p = order[n]
                if dilatation is None:
                    pulled_back(inverse[p], directions[p], pulled)
                    point_tangent(directions[p], pulled, strain[p], stress[p], tangent[p], A, dyads)
                    if len(tensors) > 0 and not _replace(tensors[p], A, limit[p], fresh):
                        continue
                else:
                    point_tangent(directions[p], directions[p], strain[p], stress[p], tangent[p], A, dyads)
                m = reference_gradients(p, first, count, value, gradient, shape, node, g)
                if dilatation is not None:
                    reference_gradients(p, first, count, dilatation.value, gradient, shape, node, h)
                    current_gradients(inverse[p], m, g)
                    current_gradients(dilatation.inverse[p], m, h)
                stacks = free_components(count[p], node, dof, local, unknown, stack)
                contract(A, g, volume[p], unknown, stack[1, stacks], B)
                if dilatation is not None:
                    scalars = project(A, directions[p], stress[p], volume[p], dilatation.deforms, ce)
                    subtract(h, g, m, H)
                    add_mean_dilatation(unknown, stack[1, stacks], scalars, ce, g, h, H, B, S)
                for a in range(m):
                    if find_stacks(row[node[a]], local[a], stack, stacks, slot, place):
                        for i in range(3):
                            if dof[node[a], i] >= 0:
                                begin, x = indptr[dof[node[a], i]], np.uintp(3 * i) * WIDTH
                                add_row(values, begin, place, stack, stacks, B, x, (g[a, 0], g[a, 1], g[a, 2]))
                                if dilatation is not None:
                                    add_row(values, begin, place, stack, stacks, S, x, (H[a, 0], H[a, 1], H[a, 2]))


@njit(cache=True)
def _replace(kept, A, limit, fresh):
    """Keep A of a point and leave in A what has to be added; False when it has not changed by more than `limit`."""
    change = 0.0
    for n in range(81):
        change = max(change, abs(A[n] - kept[n]))
    if not fresh and change <= limit:
        return False
    for n in range(81):
        new = A[n]
        if not fresh:
            A[n] = new - kept[n]
        kept[n] = new
    return True
