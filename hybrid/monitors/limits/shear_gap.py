"""Bodies that slide past each other, with soil that they shear between them: the two halves of a shear box.

Soil is sheared over a row of cells. If the gap lies on a line of the grid, the bodies hold the rows on both sides of it, and
the soil at their edges has to give way too. Force over s_u times the whole area of clay, in plane strain, 16 cells long,
after half a cell of sliding, by the gap and by its distance from the nearest line in cells:

    gap         0.02   0.16   0.5    0.75   1      2
    on a line   1.79   1.77   1.27   1.12   1.03   0.91
    0.4 off            1.12   1.01          1.01
    0.5 off            1.13

In the middle of a row it is right to 2 % for the first quarter of a cell; what it gains after that goes with one over the
length in cells (8: 35 %, 12: 21 %, 16: 13 %, 24: 10 %). What decides is how far the farther face of the gap is from that
line: half a cell is enough.
"""

from itertools import combinations
from typing import NamedTuple

import numpy as np

from hybrid.body.paths import travel_along
from hybrid.monitors.limits.shape import PLANE, faces
from hybrid.monitors.limits.start import outline
from hybrid.runtime.comm import anywhere

ROW = 0.5       # cells from the line nearest to a gap to its farther face, from which on a row is sheared in it
FINER = 0.3     # cells: cells as small as a narrower gap cost more than a user would want


class Face(NamedTuple):
    """All plane faces of a body at one place along an axis, with outward normals of one sign, such as the ends of both walls
    of a box; lowest and highest place of them, bounds (2, 3) [m]."""

    axis: int
    sign: float
    bounds: np.ndarray


def shear_on_a_line(scene, model):
    """Pairs of bodies that slide along plane faces across an axis of the grid, with a gap on one of its lines between them,
    in soil that yields."""
    soil = model.soil
    if soil.held or not soil.law.plastic:
        return
    found = [list(_faces(*outline(described, body, soil), soil.grid))
             for described, body in zip(scene.bodies, model.bodies)]
    joined = {frozenset(joint.bodies) for joint in model.joints}
    for a, b in combinations(range(len(found)), 2):
        if frozenset((a, b)) not in joined:
            yield from _of_pair(scene, model, (a, b), found[a], found[b])


def _of_pair(scene, model, pair, of_a, of_b):
    """The text about two bodies, with numbers `pair` and Faces of each; none if no gap between them is on a line."""
    grid = model.soil.grid
    for first, second in ((one, other) for one in of_a for other in of_b):
        facing = first.axis == second.axis and first.sign != second.sign
        if not (facing and _slide(scene, model, pair, first.axis)):
            continue
        ends = np.array([first.bounds[0, first.axis], second.bounds[0, first.axis]])
        gap = first.sign * (ends[1] - ends[0])
        line, cell = _nearest(grid, first.axis, ends.mean())
        row = ROW * cell * (1 - 1e-6)
        on_line = -1e-6 * cell <= gap and np.abs(ends - line).max() < row
        if on_line and _soil_between(model.soil, first, second, line, cell):
            yield _text(*(model.bodies[i].name for i in pair), "xyz"[first.axis], max(gap, 0.0), line, cell)
            return


def _text(one, other, axis, gap, line, cell):
    finer = f", or use cells of at most {gap:.2g} m" if gap > FINER * cell else ""
    return (f"{one} and {other} can slide past each other with a gap of {gap:.2g} m at the line of the grid {axis} = "
            f"{line:.4g} m, limit one cell, {cell:.3g} m: soil is sheared over a row of cells, and they hold the rows on "
            "both sides of that line, so that the force grows with the distance moved (clay in a shear box 16 cells "
            "long: 1.8 times as much with a gap of 0.2 cells, after half a cell). "
            f"Move the lines of the grid along {axis} by half a cell, so "
            f"that the gap lies in the middle of a row{finer}")


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
        travels = [travel_along(scene, scene.bodies[i], name) for i in pair]
        if axis != across and not model.soil.grid.collapsed[axis] and (free or travels[0] != travels[1]):
            return True
    return False


def _nearest(grid, axis, at):
    """(Place [m] of the line of the grid nearest to a place [m] along an axis, smaller cell [m] beside it)."""
    lines = np.asarray(grid.lines[axis])
    i = int(np.argmin(np.abs(lines - at)))
    return lines[i], np.diff(lines[max(i - 1, 0):i + 2]).min()


def _soil_between(soil, first, second, line, cell):
    """Whether two Faces that face each other enclose soil, within a cell of a line [m] between them on both its sides."""
    low, high = np.maximum(first.bounds[0], second.bounds[0]), np.minimum(first.bounds[1], second.bounds[1])
    along = (np.arange(3) != first.axis) & ~soil.grid.collapsed
    at = soil.constants.position
    enclosed = ((at > low) & (at < high))[:, along].all(axis=1)
    above = at[:, first.axis] - line
    return all(bool(anywhere(enclosed & (sign * above > 0.0) & (sign * above < cell))) for sign in (-1.0, 1.0))


LIMITS = (shear_on_a_line,)
