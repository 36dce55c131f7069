"""Ground that is not level: heights along x, or on a grid of x and y, straight in between and level beyond their ends."""

from pathlib import Path

import numpy as np

from hybrid.runtime.errors import SceneError
from hybrid.scene.stage import csv_rows


def heights(given, path="soil.ground"):
    """(x (a,), y (b,) or None, z (a, b) or (a,)) [m] of `soil.ground`: a profile, or a CSV file with columns x, z or x,
    y, z.

    Two points of a profile at the same x are a vertical wall. Raises SceneError for what is no such surface.
    """
    rows = csv_rows(given, (2, 3), path, "x, z or x, y, z") if isinstance(given, Path) else given
    if len(rows) < 2:
        raise SceneError(f"{path}: has {len(rows)} points, must be at least 2; give [x, z] of both ends")
    table = np.array(rows)
    if table.shape[1] == 2:
        if np.any(np.diff(table[:, 0]) < 0.0) or table[0, 0] == table[-1, 0]:
            raise SceneError(f"{path}: x = {', '.join(f'{x:g}' for x in table[:6, 0])} ... must not decrease; sort the "
                             "points")
        return table[:, 0], None, table[:, 1]
    x, column = np.unique(table[:, 0], return_inverse=True)
    y, row = np.unique(table[:, 1], return_inverse=True)
    if len(table) != len(x) * len(y) or len(x) < 2 or len(y) < 2 or len(np.unique(column * len(y) + row)) != len(table):
        raise SceneError(f"{path} = {given}: {len(table)} points are no grid of {len(x)} x {len(y)} different x and y; give "
                         "a height for every pair of them, once")
    z = np.empty((len(x), len(y)))
    z[column, row] = table[:, 2]
    return x, y, z


def mean_heights(surface, lower, upper):
    """Mean height (n,) [m] of a `surface` (x, y, z) over rectangles from `lower` to `upper` (n, 2) [m]: exact of a
    profile, of a grid on 4 x 4 places."""
    x, y, z = surface
    if y is None:
        return (_integral(upper[:, 0], x, z) - _integral(lower[:, 0], x, z)) / (upper[:, 0] - lower[:, 0])
    offset = (np.arange(4) + 0.5) / 4
    places = [lower[:, i, None] + (upper - lower)[:, i, None] * offset for i in (0, 1)]
    return _bilinear(*(a.reshape(len(lower), -1) for a in np.broadcast_arrays(places[0][:, :, None], places[1][:, None])),
                     x, y, z).mean(axis=1)


def heights_at(surface, place):
    """Height (n,) [m] of a `surface` below or above places (n, 2) [m]; the upper one of a wall."""
    x, y, z = surface
    if y is not None:
        return _bilinear(place[:, 0], place[:, 1], x, y, z)
    return np.maximum(*(np.interp(place[:, 0] + side * 1e-9 * np.ptp(x), x, z) for side in (-1.0, 1.0)))


def steepest(surface):
    """Largest slope [-] of a `surface` (x, y, z), inf where it has a wall."""
    x, y, z = surface
    with np.errstate(divide="ignore", invalid="ignore"):
        slopes = [np.diff(z, axis=0).T / np.diff(x)] + ([] if y is None else [np.diff(z, axis=1) / np.diff(y)])
    return max(float(np.nanmax(np.abs(slope), initial=0.0)) for slope in slopes)


def _integral(at, x, z):
    """∫ z dx from x[0] to `at`, with z level beyond the ends."""
    area = np.concatenate([[0.0], np.cumsum(0.5 * (z[1:] + z[:-1]) * np.diff(x))])
    inside = np.clip(at, x[0], x[-1])
    i = np.clip(np.searchsorted(x, inside, side="right") - 1, 0, len(x) - 2)
    width = np.where(x[i + 1] > x[i], x[i + 1] - x[i], 1.0)
    d = inside - x[i]
    return area[i] + z[i] * d + 0.5 * (z[i + 1] - z[i]) / width * d**2 + np.where(
        at < x[0], z[0] * (at - x[0]), np.where(at > x[-1], z[-1] * (at - x[-1]), 0.0))


def _bilinear(px, py, x, y, z):
    def cell(p, nodes):
        p = np.clip(p, nodes[0], nodes[-1])
        i = np.clip(np.searchsorted(nodes, p, side="right") - 1, 0, len(nodes) - 2)
        return i, (p - nodes[i]) / (nodes[i + 1] - nodes[i])

    (i, u), (j, v) = cell(px, x), cell(py, y)
    return ((1 - u) * (1 - v) * z[i, j] + u * (1 - v) * z[i + 1, j] + (1 - u) * v * z[i, j + 1] + u * v * z[i + 1, j + 1])
