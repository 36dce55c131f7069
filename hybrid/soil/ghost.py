"""Ghost penalty: stiffness for nodes at the boundary of the soil, where it fills only a small part of a cell.

The stiffness of a node vanishes with the part of its cells that soil fills. The condition number of the system then
grows without bound, and a small residual moves the node far. The penalty acts on the jump of the displacement gradient
across a face between a cell that is not full and the fullest of its neighbours:

    f_v = Σ_faces γ (1 - φ)² h ∫ [∂_n N_v] [∂_n Δu] dΓ      K_vw = Σ_faces γ (1 - φ)² h ∫ [∂_n N_v][∂_n N_w] dΓ I

[∂_n N] the jump over the face of the derivative along its normal; h the mean of the two cells along the normal [m]; φ
the share of the cell that soil fills, at most 1; γ a modulus [Pa], a factor times Young's modulus of the softest soil that
shares a node with the two cells. Δu is the increment of the step, so no stress remains in the next one. A linear field has
no jump: the penalty does not resist constant strain, translation or rotation. Rows sum to zero, so no momentum is added.

The softest, as a cell with a trace of rock on top of rock shares nodes with clay beside it: with the mean modulus of the
rock they followed the rock, and a wall on rock was pushed into clay with nine times its force.

So the field of the fullest neighbour is continued into a cell that is hardly filled, through further such cells if need
be, and full cells are left alone. After Coombs, Int. J. Numer. Methods Eng. 124 (2023) 4841-4875, who takes all faces
between a cell with an empty neighbour and any filled cell, γ = E/30 and h³/3 in place of h. A penalty on all these faces
stiffens full cells at the surface, so that its factor changes the result; and the stiffness has to scale with h for the
condition number not to depend on the cell size. That ties along a path to the fullest cells are enough is shown by
Badia, Neiva & Verdugo, Comput. Methods Appl. Mech. Eng. 388 (2022) 114232.

Equations: FORMULATION (25).
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import minimum_filter

from hybrid.grid.numbering import node_number
from hybrid.linalg.stencil import entry, local_number, relative_place
from hybrid.runtime.jit import njit

ALIKE = 0.99        # share of the fullest neighbour's filling from which another one counts as equally full
NEGLIGIBLE = 1e-12  # square of the empty share of a cell that is round-off


@dataclass(frozen=True)
class Ghost:
    """Penalty of one step. faces: (m, 4) indices i, j, k of the lower cell's first node, and axis of the normal;
    modulus: γ (m,) [Pa]."""

    faces: np.ndarray
    modulus: np.ndarray


def find_faces(cells, grid, factor):
    """Ghost of the cells that points fill in part.

    cells: FilledCells; factor: [-] on the modulus of the soil (γ where a cell is empty).
    """
    share, filled = cells.share, cells.volume
    softest = grid.cells_from_owners(_softest_around(cells))
    empty = np.where(filled > 0, np.maximum(1 - share, 0) ** 2, 0)
    fullest = grid.cells_from_owners(_fullest_neighbour(share))
    own = np.broadcast_to(grid.owned_cells, share.shape)
    faces, moduli = [], []
    for axis in range(3):
        (a, b), (best_a, best_b), (empty_a, empty_b) = (_pairs(values, axis) for values in (share, fullest, empty))
        weight = np.maximum(empty_a * (b >= ALIKE * best_a), empty_b * (a >= ALIKE * best_b))
        chosen = (weight > NEGLIGIBLE) & (a > 0) & (b > 0) & _pairs(own, axis)[0]
        lower = np.argwhere(chosen)
        faces.append(np.column_stack([lower, np.full(len(lower), axis)]))
        moduli.append(factor * weight[chosen] * np.minimum(*_pairs(softest, axis))[chosen])
    return Ghost(np.concatenate(faces), np.concatenate(moduli))


def _softest_around(cells):
    """Young's modulus [Pa] of the softest one of the cells with soil that share a node with each cell; inf without any."""
    young = np.divide(cells.stiffness, cells.volume, out=np.full_like(cells.volume, np.inf), where=cells.volume > 0)
    return minimum_filter(young, size=3, mode="nearest")


def _fullest_neighbour(share):
    """Largest `share` of the neighbours of each cell."""
    fullest = np.zeros_like(share)
    for axis in range(3):
        (a, b), (low, high) = _pairs(share, axis), _pairs(fullest, axis)
        np.maximum(low, b, out=low)
        np.maximum(high, a, out=high)
    return fullest


def _pairs(cells, axis):
    """Views of the cells below and above the faces normal to an axis."""
    below = [slice(None)] * 3
    above = list(below)
    below[axis], above[axis] = slice(None, -1), slice(1, None)
    return cells[tuple(below)], cells[tuple(above)]


def add_force(ghost, grid, displacement, force):
    """Add the penalty's force for nodal increments (N, 3) [m] to `force` (N, 3) [N]."""
    _add_force(ghost.faces, ghost.modulus, grid.axes, _thickness(grid), displacement, force)


def add_stiffness(ghost, grid, pattern, values):
    """Add the penalty's stiffness to the entries `values` of a matrix of sparsity `pattern`."""
    _add_stiffness(ghost.faces, ghost.modulus, grid.axes, _thickness(grid), pattern.sparsity, values)


def _thickness(grid):
    return grid.extent[:, 1] - grid.extent[:, 0]


@njit(cache=True)
def _line(nodes, first, thickness, normal, factor):
    """Fill `factor` (3, 3) with the matrix of a face along one axis: products of the jumps along the normal, else the
    mass matrix of the cell. Returns the number of nodes along the axis."""
    if len(nodes) == 1:
        factor[0, 0] = thickness
        return 1
    h = nodes[first + 1] - nodes[first]
    if not normal:
        factor[0, 0] = factor[1, 1] = h / 3
        factor[0, 1] = factor[1, 0] = h / 6
        return 2
    above = nodes[first + 2] - nodes[first + 1]
    jump = (1 / h, -1 / h - 1 / above, 1 / above)
    for a in range(3):
        for b in range(3):
            factor[a, b] = 0.5 * (h + above) * jump[a] * jump[b]
    return 3


@njit(cache=True)
def _face(face, axes, thickness, node, local, matrix):
    """Fill the nodes of a face, their local numbers (`hybrid.linalg.stencil`) and the matrix (12, 12) for γ = 1;
    returns the number of nodes."""
    fx, fy, fz = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    x, y, z = axes
    nx = _line(x, face[0], thickness[0], face[3] == 0, fx)
    ny = _line(y, face[1], thickness[1], face[3] == 1, fy)
    nz = _line(z, face[2], thickness[2], face[3] == 2, fz)
    r = 0
    for a in range(nx):
        for b in range(ny):
            for c in range(nz):
                node[r] = node_number((len(x), len(y), len(z)), face[0] + a, face[1] + b, face[2] + c)
                local[r] = local_number(a, b, c)
                s = 0
                for d in range(nx):
                    for e in range(ny):
                        for f in range(nz):
                            matrix[r, s] = fx[a, d] * fy[b, e] * fz[c, f]
                            s += 1
                r += 1
    return r


@njit(cache=True)
def _add_force(faces, modulus, axes, thickness, displacement, force):
    """As with the matrix of `_face`, factor by factor: the jumps across the face, averaged over it, on the nodes."""
    shape, jumps = (len(axes[0]), len(axes[1]), len(axes[2])), np.empty((2, 2, 3))
    strides = shape[1] * shape[2], shape[2], 1
    for f in range(len(faces)):
        i, j, k, n = faces[f]
        p, q = (n + 1) % 3, (n + 2) % 3     # axes of the face
        first, nodes, at = node_number(shape, i, j, k), axes[n], faces[f, n]
        h, above = nodes[at + 1] - nodes[at], nodes[at + 2] - nodes[at + 1]
        slope = 1 / h, -1 / h - 1 / above, 1 / above
        area = _width(axes[p], faces[f, p], thickness[p]) * _width(axes[q], faces[f, q], thickness[q])
        count_p, count_q = min(shape[p], 2), min(shape[q], 2)
        for a in range(count_p):
            for b in range(count_q):
                v = first + a * strides[p] + b * strides[q]
                for c in range(3):
                    jumps[a, b, c] = 0.0
                    for m in range(3):
                        jumps[a, b, c] += slope[m] * displacement[v + m * strides[n], c]
        for a in range(count_p):
            for b in range(count_q):
                v = first + a * strides[p] + b * strides[q]
                for c in range(3):
                    mean = 0.0
                    for d in range(count_p):
                        for e in range(count_q):
                            mean += _share(a, d, count_p) * _share(b, e, count_q) * jumps[d, e, c]
                    for m in range(3):
                        force[v + m * strides[n], c] += modulus[f] * 0.5 * (h + above) * area * slope[m] * mean


@njit(cache=True)
def _width(nodes, first, thickness):
    """Width of a cell along an axis, that of the slice where the axis is collapsed."""
    return thickness if len(nodes) == 1 else nodes[first + 1] - nodes[first]


@njit(cache=True)
def _share(a, b, count):
    """Entry of the mass matrix of a cell of width 1 along an axis with `count` nodes."""
    return 1.0 if count == 1 else 1 / 3 if a == b else 1 / 6


@njit(cache=True)
def _add_stiffness(faces, modulus, axes, thickness, sparsity, values):
    dof = sparsity.dof
    node, local, matrix = np.empty(12, np.int64), np.empty(12, np.int64), np.empty((12, 12))
    for f in range(len(faces)):
        m = _face(faces[f], axes, thickness, node, local, matrix)
        for r in range(m):
            for s in range(m):
                rank = 0
                for i in range(3):
                    held = dof[node[s], i] < 0
                    if dof[node[r], i] >= 0 and not held:
                        at = entry(sparsity, node[r], i, relative_place(local[r], local[s])) + rank
                        values[at] += modulus[f] * matrix[r, s]
                    rank += not held
