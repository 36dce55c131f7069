"""Points that leave the soil, and what is done with them according to `soil.stray`.

    outside the grid  "stop": the step is rejected, the message names the points; the accepted state is kept
                      "freeze": they stay at their last position and are inactive: no mass, stiffness or contact
                      "remove": the same, and they are not drawn
    detached          soil whose cells touch no other soil. Inertia carries it. In a quasi-static scene nothing does,
                      unless one of its nodes is held, so there it is treated as a point outside the grid
    distorted         stretched along some direction, or changed in volume, by more than DISTORTION_LIMIT: reported only

`hybrid.monitors.lost_points` reports all three.
"""

import dataclasses

import numpy as np
from scipy import ndimage

from hybrid.runtime.comm import anywhere, gathered, offset, total
from hybrid.runtime.errors import StepError
from hybrid.runtime.jit import njit, prange
from hybrid.soil.matrices import determinant

NEIGHBOURS = np.ones((3, 3, 3))  # cells that share a corner
DISTORTION_LIMIT = 10.0  # [-] norm |F|, or volume ratio or its inverse: beyond it a point no longer represents soil


def outside_grid(position, grid):
    """(n,) bool, points at `position` (n, 3) [m] outside the grid."""
    beyond = np.zeros(len(position), bool)
    for axis in np.flatnonzero(~grid.collapsed):
        lower, upper = grid.extent[axis]
        beyond |= (position[:, axis] < lower) | (position[:, axis] > upper)
    return beyond


def detached_pieces(basis, grid, active=None):
    """Pieces of soil: sets of filled cells that touch, at least at a corner.

    active: (n,) bool, points that count, None for all.
    Returns (n,) int, 0 for inactive points and those of the largest piece, else the number of the point's piece, and
    (pieces + 1,) bool, whether a node of the piece with that number is held.
    """
    shape = [max(1, n - 1) for n in grid.shape]
    filled = np.zeros(shape, np.bool_)
    active = np.ones(len(basis.first), bool) if active is None else active
    _mark_filled(basis.first, basis.count, active, filled)
    piece, count = ndimage.label(filled, NEIGHBOURS) if grid.nodes is None else _label_together(filled, grid)
    if count <= 1:
        return np.zeros(len(basis.first), int), np.array([True])
    own = piece[tuple(np.minimum(basis.first, np.array(shape) - 1).T)] * active
    sizes = total([np.bincount(own, minlength=count + 1)])
    sizes[0] = 0
    held = np.zeros(count + 1, bool)
    nodes = np.argwhere(grid.fixed[:, ~grid.collapsed].any(axis=1).reshape(grid.shape))
    for shift in np.ndindex(2, 2, 2):
        held[piece[tuple(np.clip(nodes - shift, 0, np.array(shape) - 1).T)]] = True
    held = total([held]) > 0
    own[own == sizes.argmax()] = 0
    return own, held


def _label_together(filled, grid):
    """ndimage.label of the `filled` cells (a, b, c) of all processes: numbers of the local ones, and of all pieces."""
    piece, count = ndimage.label(grid.summed_cells(filled.astype(np.int64)) > 0, NEIGHBOURS)
    before, number = None, np.where(piece > 0, piece + offset(count), 0)
    while before is None or anywhere(number != before):     # the smallest number spreads from process to process
        before = number.copy()
        smallest = ndimage.minimum(grid.cells_from_owners(number), piece, np.arange(count + 1))
        number = np.where(piece > 0, np.asarray(smallest, np.int64)[piece], 0)
    numbers = np.unique(gathered(np.append(0, np.unique(number))))
    return np.searchsorted(numbers, number), len(numbers) - 1


@njit(cache=True)
def _mark_filled(first, count, active, filled):
    """Mark the cells that domains of active points overlap."""
    for p in range(len(first)):
        if active[p]:
            for i in range(first[p, 0], first[p, 0] + max(1, count[p, 0] - 1)):
                for j in range(first[p, 1], first[p, 1] + max(1, count[p, 1] - 1)):
                    for k in range(first[p, 2], first[p, 2] + max(1, count[p, 2] - 1)):
                        filled[i, j, k] = True


def deactivate(old, new, leaving):
    """`new` Points, except that those `leaving` (n,) bool or inactive in `old` stay as in `old`, at rest, inactive."""
    inactive = leaving if old.inactive is None else old.inactive | leaving
    if not inactive.any():
        return new
    fields = {field.name: getattr(new, field.name) for field in dataclasses.fields(new)}
    for name, value in fields.items():
        if value is not None and name != "inactive":
            keep = inactive.reshape(-1, *[1] * (value.ndim - 1))
            before = None if name in ("velocity", "acceleration", "algorithmic", "affine") else getattr(old, name)
            fields[name] = np.where(keep, 0.0 if before is None else before, value)
    return dataclasses.replace(new, **fields | {"inactive": inactive})


def distorted(deformation):
    """(n,) bool, points whose F (n, 3, 3) has a stretch above DISTORTION_LIMIT, or a volume ratio above it or below its
    inverse."""
    found = np.empty(len(deformation), np.bool_)
    _distorted(deformation, found)
    return found


def list_points(ids, positions=None, limit=5):
    """Text that names the first `limit` of the points `ids`, their numbers in the run, with their positions (n, 3) [m] if
    given; all processes name the points of all."""
    ids, positions = gathered(np.asarray(ids)), positions if positions is None else gathered(positions)
    order = np.argsort(ids, kind="stable")
    ids, positions = ids[order], positions if positions is None else positions[order]
    at = [""] * len(ids)
    if positions is not None:
        at = [" at (" + ", ".join(f"{x:.4g}" for x in p) + ") m" for p in positions]
    shown = ", ".join(f"{i}{where}" for i, where in zip(ids[:limit], at))
    return f"point{'s' * (len(ids) > 1)} {shown}" + (f" and {len(ids) - limit} more" if len(ids) > limit else "")


def refuse_outside_grid(leaving, position, grid, constants):
    """Raises StepError if any points with `constants` are `leaving` (n,) bool the grid for `position` (n, 3) [m]."""
    ids = np.flatnonzero(leaving)
    if not anywhere([len(ids)]):
        return
    ends = "; ".join(f"{axis} {low:.6g} to {high:.6g}" for axis, (low, high) in zip("xyz", grid.extent))
    raise StepError(f"{list_points(constants.named(ids), position[ids])} would leave the grid ({ends} m); enlarge the "
                    'grid, hold its face, or set soil.stray = "freeze" or "remove"')


def refuse_detached(detached, position, constants):
    """Raises StepError if any points with `constants` at `position` (n, 3) [m] are `detached` (n,) bool in a quasi-static
    scene."""
    ids = np.flatnonzero(detached)
    if anywhere([len(ids)]):
        raise StepError(f"{list_points(constants.named(ids), position[ids])} touch no other soil and no held node, so "
                        'nothing carries them in a quasi-static scene; set soil.stray = "freeze" or "remove", or '
                        'time.inertia = true')


@njit(cache=True, parallel=True)
def _distorted(deformation, found):
    for p in prange(len(found)):
        squares, volume = 0.0, determinant(deformation[p])
        for i in range(3):
            for j in range(3):
                squares += deformation[p, i, j] ** 2        # no smaller than the largest stretch squared
        found[p] = squares > DISTORTION_LIMIT**2 or volume > DISTORTION_LIMIT or volume < 1 / DISTORTION_LIMIT
