"""Size of the soil block, and memory of a run, before there is a matrix.

    memory = LIBRARIES + `growing_memory` of the points and of the entries of the soil block, as measured
"""

import numpy as np

from hybrid.linalg.stencil_pattern import sizes_of_box
from hybrid.runtime.comm import maximum, minimum
from hybrid.runtime.memory import direct_factor_memory
from hybrid.soil.workspace import keeps_tangents

# [bytes]
LIBRARIES = 320e6       # interpreter with dolfinx, PETSc, gmsh and compiled kernels
PICTURES = 95e6         # process that draws pictures
BYTES_PER_POINT = 1600  # history, constants, trial buffers and temporaries of one point
BYTES_PER_ENTRY = 34    # entry of the soil block: value, index, incomplete factor and its temporaries
PART = 0.1  # [-] of points and matrix, besides: those of an increment restricted to few nodes (`hybrid.step.restriction`)
KEPT_PER_POINT, KEPT_PER_ENTRY = 889, 8     # tangents kept within an increment: 111 numbers and a mark, and one
FBAR_PER_POINT = 4000   # more with F-bar and contact on faces, as measured with a moving grid


def sizes(soil):
    """Sizes of the soil block in the first step, of all processes: nodes in the support of a point at its initial place."""
    planes = []
    position, half_width = soil.constants.position.T, soil.constants.half_width.T
    grid = soil.grid
    for nodes, fixed, collapsed, x, half in zip(grid.lines, grid.planes, grid.collapsed, position, half_width):
        reached = np.full(len(nodes), not soil.held)
        if not (soil.held or collapsed):
            reached = (nodes >= _at_or_below(nodes, minimum(x - half))) & (nodes <= _at_or_above(nodes, maximum(x + half)))
        planes.append(reached[:, None] & ~fixed)
    return sizes_of_box(planes)


def _at_or_below(nodes, x):
    """The node below `x` [m], or the first one: soil may have started outside the grid that follows a body."""
    return nodes[max(np.searchsorted(nodes, x + 1e-9, side="right") - 1, 0)]


def _at_or_above(nodes, x):
    return nodes[min(np.searchsorted(nodes, x - 1e-9, side="left"), len(nodes) - 1)]


def growing_memory(soil, points, entries, unknowns, solver, direct=False):
    """Largest memory [bytes] of so many points, entries of the matrix and its factor; direct: whether a direct factor turned
    out to be needed."""
    return growing_memory_of(
        points, entries, unknowns, soil.fbar, keeps_tangents(soil, solver),
        direct or solver.linear == "direct", bool(soil.grid.collapsed.any()))


def growing_memory_of(points, entries, unknowns, fbar, kept, direct, plane):
    """The same by numbers; kept: whether points keep their tangents; plane: whether an axis is collapsed."""
    per_point = BYTES_PER_POINT + KEPT_PER_POINT * kept + FBAR_PER_POINT * fbar
    memory = (1 + PART) * (per_point * points + (BYTES_PER_ENTRY + KEPT_PER_ENTRY * kept) * entries)
    return memory + (direct_factor_memory(unknowns, plane) if direct else 0.0)
