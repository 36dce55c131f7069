"""Ghost penalty: stiffness for nodes at the boundary of the soil, where it fills only a small part of a cell.

The stiffness of a node vanishes with the part of its cells that soil fills. The condition number of the system then
grows without bound, and a small residual moves the node far. The penalty acts on the jump of the displacement gradient
across each face that a boundary cell (filled, with an empty neighbour) shares with any filled cell:

    f_v = Σ_faces γ h ∫ [∂_n N_v] [∂_n Δu] dΓ            K_vw = Σ_faces γ h ∫ [∂_n N_v][∂_n N_w] dΓ I

[∂_n N] the jump over the face of the derivative along its normal; h the mean of the two cells along the normal [m]; γ a
modulus [Pa], a factor times the mean Young's modulus of the points whose domains overlap the two cells. A linear field
has no jump: the penalty does not resist constant strain, translation or rotation. Rows sum to zero, so no momentum is
added. Δu is the increment of the step, so no stress remains in the next one.

After Coombs, Int. J. Numer. Methods Eng. 124 (2023) 4841-4875, who uses γ = E/30 and h³/3 in place of h. For h = 1 m
the two differ by the factor 1/3 only; but the stiffness has to scale with h for the condition number not to depend on
the cell size.

Equations: FORMULATION (25).
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from hybrid.grid.numbering import node_number
from hybrid.linalg.stencil import entry, local_number, relative_place


@dataclass(frozen=True)
class Ghost:
    """Penalty of one step. faces: (m, 4) indices i, j, k of the lower cell's first node, and axis of the normal;
    modulus: γ (m,) [Pa]."""

    faces: np.ndarray
    modulus: np.ndarray


def find_faces(basis, grid, modulus):
    """Ghost of the cells that the domains of a basis overlap; modulus: (n,) [Pa] of the points."""
    reached, weighted = np.zeros((2, *(max(1, n - 1) for n in grid.shape)))
    _fill(basis.first, basis.count, modulus, reached, weighted)
    filled = reached > 0
    boundary = np.zeros_like(filled)
    for axis in range(3):
        a, b = _pairs(filled, axis)
        low, high = _pairs(boundary, axis)
        low |= a & ~b
        high |= b & ~a
    faces, moduli = [], []
    for axis in range(3):
        a, b = _pairs(filled, axis)
        low, high = _pairs(boundary, axis)
        chosen = a & b & (low | high)
        cells = np.argwhere(chosen)
        faces.append(np.column_stack([cells, np.full(len(cells), axis)]))
        moduli.append((sum(_pairs(weighted, axis))[chosen]) / sum(_pairs(reached, axis))[chosen])
    return Ghost(np.concatenate(faces), np.concatenate(moduli))


def _pairs(cells, axis):
    """Views of the cells below and above the faces normal to an axis."""
    below = [slice(None)] * 3
    above = list(below)
    below[axis], above[axis] = slice(None, -1), slice(1, None)
    return cells[tuple(below)], cells[tuple(above)]


@njit(cache=True)
def _fill(first, count, modulus, reached, weighted):
    """Fill the number of points whose domains overlap each cell, and the sum of their moduli [Pa]."""
    for p in range(len(first)):
        for i in range(first[p, 0], first[p, 0] + max(1, count[p, 0] - 1)):
            for j in range(first[p, 1], first[p, 1] + max(1, count[p, 1] - 1)):
                for k in range(first[p, 2], first[p, 2] + max(1, count[p, 2] - 1)):
                    reached[i, j, k] += 1
                    weighted[i, j, k] += modulus[p]


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
    m = 0
    for a in range(nx):
        for b in range(ny):
            for c in range(nz):
                node[m] = node_number((len(x), len(y), len(z)), face[0] + a, face[1] + b, face[2] + c)
                local[m] = local_number(a, b, c)
                m += 1
    for r in range(m):
        for s in range(m):
            matrix[r, s] = (fx[r // (ny * nz), s // (ny * nz)] * fy[r // nz % ny, s // nz % ny] * fz[r % nz, s % nz])
    return m


@njit(cache=True)
def _add_force(faces, modulus, axes, thickness, displacement, force):
    node, local, matrix = np.empty(12, np.int64), np.empty(12, np.int64), np.empty((12, 12))
    for f in range(len(faces)):
        m = _face(faces[f], axes, thickness, node, local, matrix)
        for r in range(m):
            for s in range(m):
                for i in range(3):
                    force[node[r], i] += modulus[f] * matrix[r, s] * displacement[node[s], i]


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
