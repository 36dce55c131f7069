"""Creation of material points whose domains tile the cells of a grid, their extent and their geostatic stress.

Equations: FORMULATION (21).
"""

import numpy as np

from hybrid.runtime.comm import maximum, minimum
from hybrid.runtime.errors import SceneError
from hybrid.state import Points


def lines_of_points(grid, lower, upper, per_axis):
    """(centres, half-widths [m], cells) along each axis of the whole grid, three arrays each, of points that tile the
    cells from `lower` to `upper` (3,) [m], `per_axis` (3,) points along each cell edge.

    The box ends on grid lines, which `hybrid.setup.soil.soil_box` has checked. Raises SceneError when it contains no cell.
    """
    centres, halves, cells = [], [], []
    for axis, nodes in enumerate(grid.lines):
        if len(nodes) == 1:
            ends = grid.extent[axis]
            centres.append(np.array([ends.mean()]))
            halves.append(np.array([0.5 * (ends[1] - ends[0])]))
            cells.append(np.zeros(1, int))
            continue
        first = _line(nodes, lower[axis])
        edges = nodes[first:_line(nodes, upper[axis]) + 1]
        if len(edges) < 2:
            raise SceneError(f"the soil contains no cell along {'xyz'[axis]}: it reaches from {lower[axis]:g} to "
                             f"{upper[axis]:g} m; set soil.lower and soil.upper (or soil.top) at least a cell apart")
        width = np.diff(edges) / per_axis[axis]
        offsets = np.arange(per_axis[axis]) + 0.5
        centres.append((edges[:-1, None] + width[:, None] * offsets).ravel())
        halves.append(np.repeat(0.5 * width, per_axis[axis]))
        cells.append(np.repeat(first + np.arange(len(width)), per_axis[axis]))
    return tuple(centres), tuple(halves), tuple(cells)


def _line(nodes, x):
    nearest = int(np.argmin(np.abs(nodes - x)))
    assert abs(nodes[nearest] - x) <= 1e-6 * np.diff(nodes).min(), "the soil ends inside a cell"
    return nearest


def extent(points, axis):
    """(Lowest, highest) coordinate [m] of the domains of points (n,) along an axis."""
    position, half = points.position[:, axis], points.half_width[:, axis]
    return minimum(position - half), maximum(position + half)


def overburden(constants, gravity):
    """Vertical stress (n,) [Pa], compression positive: weight of all points above a point and half its own, per area.

    With this stress the internal forces of a tiled box of soil in horizontal layers balance its weight to round-off,
    whatever the densities: GIMP integrates hat functions exactly over domains that end at nodes.
    """
    _, first, level = np.unique(constants.position[:, 2], return_index=True, return_inverse=True)
    density = constants.mass[first] / constants.volume[first]
    weight = density * gravity * 2 * constants.half_width[first, 2]
    return (np.cumsum(weight[::-1])[::-1] - 0.5 * weight)[level]


def overburden_of_columns(constants, gravity):
    """The same under ground that is not level: weight above in the own column of points, which are numbered along
    z first."""
    position, half = constants.position, constants.half_width
    weight = constants.mass * gravity / (4 * half[:, 0] * half[:, 1])
    begins = np.flatnonzero(np.any(position[1:, :2] != position[:-1, :2], axis=1)) + 1
    above = np.cumsum(weight[::-1])[::-1]
    last = np.append(begins, len(weight))                   # of each column, one beyond
    column = np.searchsorted(begins, np.arange(len(weight)), side="right")
    beyond = np.append(above, 0.0)[last[column]]
    return above - beyond - 0.5 * weight


def at_rest(constants, principal_stress, elastic_strain):
    """Points at rest with principal stresses (n, 3) [Pa] along the axes, and the elastic strains (n, 3) of these."""
    n = len(constants)
    diagonal = np.arange(3)
    stress, elastic = np.zeros((n, 3, 3)), np.zeros((n, 3, 3))
    stress[:, diagonal, diagonal] = principal_stress
    elastic[:, diagonal, diagonal] = np.exp(2 * elastic_strain)
    return Points(
        position=constants.position.copy(), velocity=np.zeros((n, 3)), acceleration=np.zeros((n, 3)),
        half_width=constants.half_width.copy(), deformation=np.tile(np.eye(3), (n, 1, 1)), b_elastic=elastic,
        stress=stress, plastic_strain=np.zeros(n))
