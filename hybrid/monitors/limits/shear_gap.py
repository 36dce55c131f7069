"""Bodies that slide past each other, with soil that they shear between them: the two halves of a shear box.

Soil is sheared over a row of cells. If the gap lies on a line of the grid, the bodies hold the rows on both sides of it, and
the soil at their edges has to give way too. Force over s_u times the area of clay in plane strain, 16 cells long, after
half a cell of sliding, by the gap and by its distance from the nearest line in cells:

    gap         0.02   0.16   0.5    0.75   1      2
    on a line   1.79   1.77   1.27   1.12   1.03   0.91
    0.4 off            1.12   1.01          1.01
    0.5 off            1.13

In the middle of a row it is right to 2 % for the first quarter of a cell. What decides is how far the farther face of the
gap is from that line: half a cell is enough.
"""

from itertools import combinations
from typing import NamedTuple

import numpy as np

from hybrid.monitors.limits.contact import way_along
from hybrid.monitors.limits.ways import PLANE, faces, outline
from hybrid.runtime.comm import anywhere

ROW = 0.5       # cells from the line nearest to a gap to its farther face, from which on a row is sheared in it
FINER = 0.3     # cells: cells as small as a narrower gap cost more than a user would want


class Face(NamedTuple):
    """Plane faces of a body at one place along an axis, with outward normals of one sign; bounds (2, 3) [m]."""

    axis: int
    sign: float
    bounds: np.ndarray


def shear_on_a_line(scene, model):
    """Pairs of bodies that slide along plane faces across an axis of the grid, with a gap on one of its lines between them,
    in soil that yields."""
    soil = model.soil
    if soil.held or not soil.law.plastic:
        return
    found = [list(_faces(*outline(described, body, soil), soil.grid)) for described, body in zip(scene.bodies, model.bodies)]
    joined = {frozenset(joint.bodies) for joint in model.joints}
    for a, b in combinations(range(len(found)), 2):
        if frozenset((a, b)) not in joined:
            yield from _of_pair(scene, model, (a, b), found[a], found[b])


def _of_pair(scene, model, pair, of_a, of_b):
    """The text about two bodies, with numbers `pair` and Faces of each; none if no gap between them is on a line."""
    grid = model.soil.grid
    for first, second in ((one, other) for one in of_a for other in of_b):
        if first.axis != second.axis or first.sign == second.sign or not _slide(scene, model, pair, first.axis):
            continue
        ends = np.array([first.bounds[0, first.axis], second.bounds[0, first.axis]])
        gap = first.sign * (ends[1] - ends[0])
        line, cell = _nearest(grid, first.axis, ends.mean())
        row = ROW * cell * (1 - 1e-6)
        if -1e-6 * cell <= gap and np.abs(ends - line).max() < row and _soil_between(model.soil, first, second, cell):
            yield _text(*(model.bodies[i].name for i in pair), "xyz"[first.axis], max(gap, 0.0), line, cell)
            return


def _text(one, other, axis, gap, line, cell):
    finer = f", or use cells of at most {gap:.2g} m" if gap > FINER * cell else ""
    return (f"{one} and {other} slide past each other with a gap of {gap:.2g} m at the line of the grid {axis} = {line:.4g} "
            f"m, limit one cell, {cell:.3g} m: soil is sheared over a row of cells, and they hold the rows on both sides of "
            "that line, so that the force grows with the way (clay in a shear box 16 cells long: 1.8 times as much with a "
            f"gap of 0.2 cells, after half a cell). Move the lines of the grid along {axis} by half a cell, so that the gap "
            f"lies in the middle of a row{finer}")


def _faces(body, place, grid):
    """Faces of a body across the axes of the grid, its vertices at `place` (V, 3) [m]."""
    normal, area = faces(body, place)
    corners = place[body.surface.triangles]
    for axis in np.flatnonzero(~grid.collapsed):
        for sign in (-1.0, 1.0):
            chosen = corners[sign * normal[:, axis] > PLANE * area]
            levels = chosen[:, 0, axis].round(6)
            for level in np.unique(levels):
                mine = chosen[levels == level].reshape(-1, 3)
                yield Face(int(axis), sign, np.array([mine.min(axis=0), mine.max(axis=0)]))


def _slide(scene, model, pair, across):
    """Whether two bodies can move past each other along an axis of the grid other than `across`."""
    for axis, name in enumerate("xyz"):
        free = any(model.bodies[i].free[axis] for i in pair)
        ways = [way_along(scene, scene.bodies[i], name) for i in pair]
        if axis != across and not model.soil.grid.collapsed[axis] and (free or ways[0] != ways[1]):
            return True
    return False


def _nearest(grid, axis, at):
    """(Place [m] of the line of the grid nearest to a place [m] along an axis, smaller cell [m] beside it)."""
    lines = np.asarray(grid.lines[axis])
    i = int(np.argmin(np.abs(lines - at)))
    return lines[i], np.diff(lines[max(i - 1, 0):i + 2]).min()


def _soil_between(soil, first, second, cell):
    """Whether there is soil within a cell of the gap between two Faces that face each other there."""
    low = np.maximum(first.bounds[0], second.bounds[0])
    high = np.minimum(first.bounds[1], second.bounds[1])
    other = np.arange(3) != first.axis
    if (high - low)[other & ~soil.grid.collapsed].min() < -1e-6 * cell:
        return False
    axis = first.axis
    low[axis], high[axis] = sorted((first.bounds[0, axis], second.bounds[0, axis]))
    margin = np.where(soil.grid.collapsed, np.inf, cell)
    at = soil.constants.position
    return bool(anywhere(((at > low - margin) & (at < high + margin)).all(axis=1)))


LIMITS = (shear_on_a_line,)
