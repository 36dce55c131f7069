"""GIMP basis on a rectilinear grid, one axis at a time; three-dimensional values are products.

With N_v the hat function of node v, Φ_v its integral and l the half-width of the point's domain along the axis,

    S_v = [Φ_v(x + l) - Φ_v(x - l)] / 2l          dS_v/dx = [N_v(x + l) - N_v(x - l)] / 2l

(Charlton, Coombs & Augarde 2017; FORMULATION (3)). l = 0 gives the standard MPM. A domain is never wider than its cell,
so at most three nodes an axis have non-zero values for a point.

| symbol          | field    | shape     | unit |
|-----------------|----------|-----------|------|
| first node      | first    | (n, 3)    | -    |
| number of nodes | count    | (n, 3)    | -    |
| S_v             | value    | (n, 3, 3) | -    |
| dS_v/dx         | gradient | (n, 3, 3) | 1/m  |

The second index is the axis, the third the node counted from `first`. Fixed during a step.
"""

from typing import NamedTuple

import numpy as np

from hybrid.runtime.errors import StepError
from hybrid.runtime.jit import njit, prange

SNAP = 1e-8  # [-] of a cell: a domain end closer to a node is moved to the node, so that overlaps are never thinner


class Basis(NamedTuple):
    """Basis of all points at the start of a step; shapes in the module's table. Kernels take it as one argument."""

    first: np.ndarray
    count: np.ndarray
    value: np.ndarray
    gradient: np.ndarray


def evaluate_basis(position, half_width, axes):
    """Basis of points at `position` (n, 3) [m] with domain half-widths (n, 3) [m], zero for standard MPM.

    Raises StepError when a domain reaches outside the grid.
    """
    n = len(position)
    basis = Basis(np.zeros((n, 3), np.int32), np.ones((n, 3), np.int32), np.zeros((n, 3, 3)), np.zeros((n, 3, 3)))
    outside = np.empty(n, np.bool_)
    for axis, nodes in enumerate(axes):
        if len(nodes) == 1:
            basis.value[:, axis, 0] = 1.0
            continue
        _axis_basis(position, half_width, nodes, axis, basis, outside)
        if outside.any():
            p = np.flatnonzero(outside)[-1]
            raise StepError(
                f"point {p} at {'xyz'[axis]} = {position[p, axis]:.6g} m left the grid "
                f"[{nodes[0]:.6g}, {nodes[-1]:.6g}] m; enlarge grid.{'xyz'[axis]} or shorten the step")
    return basis


def with_margin(nodal, shape):
    """Nodal values (N, k) followed by zeros, so that kernels may read three nodes along every axis for any point.

    Loops of fixed length are several times as fast; nodes beyond the `count` of a point have zero values in its basis.
    """
    nodes, margin = len(nodal), 2 * (shape[1] * shape[2] + shape[2] + 1)
    out = np.zeros((nodes + margin, *nodal.shape[1:]))
    out[:nodes] = nodal
    return out


@njit(cache=True)
def find_cell(x, nodes):
    """Index of the cell of `nodes` that contains x, clipped to the grid."""
    last = len(nodes) - 2
    cell = min(max(int((x - nodes[0]) / (nodes[-1] - nodes[0]) * (last + 1)), 0), last)   # first guess: equal cells
    while cell > 0 and x < nodes[cell]:
        cell -= 1
    while cell < last and x >= nodes[cell + 1]:
        cell += 1
    return cell


@njit(cache=True)
def hat_integral(low, high, v, nodes):
    """Integral [m] over [low, high] of the hat function of node v, without cancellation for thin overlaps."""
    total = 0.0
    if v > 0:
        h = nodes[v] - nodes[v - 1]
        s0 = min(max(low - nodes[v - 1], 0.0), h)
        s1 = min(max(high - nodes[v - 1], 0.0), h)
        total += 0.5 * (s1 - s0) * (s1 + s0) / h
    if v < len(nodes) - 1:
        h = nodes[v + 1] - nodes[v]
        s0 = min(max(nodes[v + 1] - high, 0.0), h)
        s1 = min(max(nodes[v + 1] - low, 0.0), h)
        total += 0.5 * (s1 - s0) * (s1 + s0) / h
    return total


@njit(cache=True)
def hat(x, v, nodes):
    """Hat function of node v at x."""
    if x <= nodes[v]:
        return 1.0 if v == 0 else max(0.0, (x - nodes[v - 1]) / (nodes[v] - nodes[v - 1]))
    return 1.0 if v == len(nodes) - 1 else max(0.0, (nodes[v + 1] - x) / (nodes[v + 1] - nodes[v]))


@njit(cache=True)
def support(x, half, nodes):
    """(first node, last node, lower end, upper end) of a domain, ends closer than SNAP to a node moved to the node."""
    low, high = x - half, x + half
    i = j = find_cell(low, nodes)
    while j < len(nodes) - 2 and high >= nodes[j + 1]:
        j += 1
    if j > i:
        snap = SNAP * (nodes[i + 1] - nodes[i])
        if low > nodes[i + 1] - snap:
            i += 1
            low = nodes[i]
        if j > i and high < nodes[j] + snap:
            high = nodes[j]
            j -= 1
    return i, j + 1, low, high


@njit(cache=True, parallel=True)
def _axis_basis(position, half_width, nodes, axis, basis, outside):
    """Fill one axis of the basis, and `outside` (n,) bool: points whose domains reach outside the grid."""
    first, count, value, gradient = basis
    slack = 1e-9 * (nodes[-1] - nodes[0])
    for p in prange(len(position)):
        x, l = position[p, axis], half_width[p, axis]
        outside[p] = not (x - l >= nodes[0] - slack and x + l <= nodes[-1] + slack)
        if outside[p]:
            continue
        i, j, low, high = support(x, l, nodes)
        first[p, axis] = i
        count[p, axis] = j - i + 1
        for a in range(j - i + 1):
            if l > 0.0:
                value[p, axis, a] = hat_integral(low, high, i + a, nodes) / (high - low)
                gradient[p, axis, a] = (hat(high, i + a, nodes) - hat(low, i + a, nodes)) / (high - low)
            else:
                value[p, axis, a] = hat(x, i + a, nodes)
                gradient[p, axis, a] = (2 * a - 1) / (nodes[j] - nodes[i])
