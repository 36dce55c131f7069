"""The size of a scene's grid and soil before anything of that size is made: a SceneError where it cannot fit in memory.

    memory = 400 bytes per node + `growing_memory` of the points and of the entries of the soil block

Entries: nodes couple with all that are at most two cells away, so n nodes in a row have 5 n - 6 entries, and a box of
them (3 - c)² Π (5 n_i - 6) with c collapsed axes. Nodes count that touch soil, held ones too.
"""

from math import inf, prod

import numpy as np

from hybrid.grid.axes import cells_that_grow
from hybrid.runtime.errors import SceneError
from hybrid.runtime.memory import available_memory
from hybrid.scene.soil import ends
from hybrid.soil.size import growing_memory_of

BYTES_PER_NODE = 400    # conditions, numbers, masses and vectors of a node, with soil or without
BYTES_ON_AXIS = 100     # coordinates and what is made from them along one axis


def refuse_cells(scene):
    """SceneError where memory does not hold the cells along one axis, or the blocks of a grid that follows a body; they
    are counted without being made."""
    axes = {name: getattr(scene.grid, name) for name in "xyz"}
    counts = {name: _least_cells(axis) for name, axis in axes.items()}
    blocks = prod(_cells(axis) / 2**axis.doublings for axis in axes.values() if axis.moves)
    need = BYTES_ON_AXIS * max(counts.values()) + blocks * scene.grid.moves
    _refuse(need, counts)


def refuse_size(scene, axes):
    """SceneError where grid and soil do not fit in memory; axes: three arrays of nodes [m]."""
    need, points = size(scene, axes)
    counts = [max(1, len(nodes) - 1) for nodes in axes]
    _refuse(need, dict(zip("xyz", counts)), points)


def size(scene, axes):
    """(Memory [bytes] of grid and soil, number of points) of a scene; axes: three arrays of nodes [m]."""
    soil, filled = scene.soil, [_filled(scene, number, nodes) for number, nodes in enumerate(axes)]
    per_axis = np.broadcast_to(soil.points_per_axis, 3)
    points = prod(n * (int(per) if len(nodes) > 1 else 1) for n, per, nodes in zip(filled, per_axis, axes))
    rows = [n + 1 for n, nodes in zip(filled, axes) if len(nodes) > 1]
    held, plane = soil.held, len(rows) < 3
    nodes = 0 if held else prod(rows)
    entries = 0 if held else len(rows) ** 2 * prod(max(1, 5 * n - 6) for n in rows)
    need = BYTES_PER_NODE * prod(len(nodes) for nodes in axes) + growing_memory_of(
        points, entries, nodes * len(rows), fbar=bool(soil.fbar), kept=scene.solver.tangent_tolerance > 0 and not held,
        direct=scene.solver.linear == "direct", plane=plane)
    return need, points


def _refuse(need, counts, points=None):
    left = available_memory()
    if need > left:
        cells = " x ".join(f"{n:.3g}" for n in counts.values())
        most = max(counts, key=counts.get)
        raise SceneError(
            f"grid: {cells} cells{f' and {points} points' if points else ''} need about {_bytes(need)} of memory, and "
            f"{_bytes(left)} are left: choose a larger grid.{most}.size or a shorter axis, fewer "
            "soil.points_per_axis, or a machine with more memory")


def _bytes(number):
    if number == inf:
        return "endless"
    for power, unit in ((40, "TiB"), (30, "GiB")):
        if number >= 2**power:
            return f"{number / 2**power:.3g} {unit}"
    return f"{number / 2**20:.3g} MiB"


def _cells(axis):
    """Cells of the smallest size along an axis that is not given by nodes."""
    return (axis.end - axis.start) / axis.size if axis.size else 1.0


def _least_cells(axis):
    """Number of cells along an axis; of one that follows a body, at least so many."""
    if axis.collapsed:
        return 1.0
    if axis.nodes is not None:
        return float(len(axis.nodes) - 1)
    if axis.moves:
        window = min(sum(axis.window or (inf,)), axis.end - axis.start)
        return min(sum(axis.around or (inf,)), window) / axis.size + window / axis.size / 2**axis.doublings
    if axis.fine is None:
        return _cells(axis)
    low, high = axis.fine
    return (high - low) / axis.size + sum(
        cells_that_grow(distance, axis.size, axis.growth) for distance in (low - axis.start, axis.end - high))


def _filled(scene, axis, nodes):
    """Number of cells of an axis with soil in them."""
    if len(nodes) == 1:
        return 1
    soil = scene.soil
    lower = soil.lower[axis] if soil.lower else -inf
    upper = soil.upper[axis] if soil.upper else inf
    if axis == 2:
        lower, upper = ends(soil, scene.grid)
    middle = 0.5 * (nodes[1:] + nodes[:-1])
    return int(np.count_nonzero((middle > lower) & (middle < upper)))
