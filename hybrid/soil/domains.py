"""Domains of the points: boxes aligned with the axes, whose half-widths l follow the deformation.

    none      l_i = l0_i
    moments   l_i = s √Σ_j (F_ij l0_j)²,  s such that Π l = J Π l0 over the axes that deform

With `moments` the box has the second moments Σ_j (F_ij l0_j)²/3 of the deformed domain along the axes, and its
volume; so it follows rotations, whatever the initial shape of the domain (`demos/domains.py` compares the rules).

The width of a domain is limited to the cell that contains its centre (so that three nodes an axis suffice) and to the
grid. With n points a cell along an axis, domains therefore tile a bar only up to a stretch of n.

Equations: FORMULATION (4).
"""

import numpy as np

from hybrid.grid.axes import cell_sizes
from hybrid.runtime.jit import njit, prange
from hybrid.soil.basis import find_cell
from hybrid.soil.matrices import determinant

THINNEST = 1e-3  # of the initial half-width: keeps the basis well defined for a squashed point


def updated_half(rule, initial_half, deformation, position, axes):
    """Half-widths (n, 3) [m] from the initial ones, F (n, 3, 3) and positions (n, 3) [m]."""
    if rule == "moments":
        half, deforms = np.empty_like(initial_half), np.array([len(nodes) > 1 for nodes in axes])
        _moments(initial_half, deformation, deforms, int(deforms.sum()), half)
    else:
        half = initial_half.copy()
    _limit(initial_half, position, *axes, half)
    return half


def cells_wide(initial_half, deformation, position, axes):
    """Widths (n, 3) [-] of the deformed domains of points at `position` (n, 3) [m] along the axes, those of `moments`
    before their volume is set, relative to their cells; 0 along a collapsed axis. Domains with a relative width above 1
    are limited to their cell."""
    return 2 * np.linalg.norm(deformation * initial_half[:, None, :], axis=2) / cell_sizes(axes, position)


@njit(cache=True, parallel=True, fastmath={"contract"})
def _moments(initial_half, deformation, deforms, count, out):
    for p in prange(len(deformation)):
        F, ratio = deformation[p], 1.0
        for i in range(3):
            square = 0.0
            for j in range(3):
                reach = F[i, j] * initial_half[p, j]
                square += reach * reach     # not **: see `hybrid.runtime.kernel_copies`
            out[p, i] = np.sqrt(square)
            if deforms[i]:
                ratio *= out[p, i] / initial_half[p, i]
        scale = (determinant(F) / ratio) ** (1.0 / count)
        for i in range(3):
            out[p, i] *= scale


@njit(cache=True, parallel=True)
def _limit(initial, position, x, y, z, half):
    for p in prange(len(half)):
        half[p, 0] = _limited(half[p, 0], initial[p, 0], position[p, 0], x)
        half[p, 1] = _limited(half[p, 1], initial[p, 1], position[p, 1], y)
        half[p, 2] = _limited(half[p, 2], initial[p, 2], position[p, 2], z)


@njit(cache=True)
def _limited(half, initial, x, nodes):
    """Half-width of a domain at x: at least THINNEST `initial`, no wider than its cell, and inside the grid."""
    if len(nodes) == 1:
        return initial
    cell, room = find_cell(x, nodes), min(x - nodes[0], nodes[-1] - x)
    return min(max(half, THINNEST * initial), 0.5 * (nodes[cell + 1] - nodes[cell]), max(room, 0.0))
