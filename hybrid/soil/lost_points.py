"""Points that go astray, and what becomes of them by `soil.stray`.

    out of the grid   "stop": the step is refused, with the points' numbers; what was accepted stays
                      "freeze": they stay where they were last and take no part any more: no mass, stiffness or contact
                      "remove": the same, and they are left out of what is drawn
    adrift            soil whose cells touch no other soil. Inertia carries it; in a quasi-static scene nothing does
                      unless one of its nodes is held, so there it is treated as out of the grid
    stretched         by more than LIMIT along some direction, or in volume: told of

Nothing of this is silent: `hybrid.monitors.lost_points` tells of all three once.
"""

import dataclasses

import numpy as np
from numba import njit
from scipy import ndimage

from hybrid.runtime.errors import StepError

LIMIT = 10.0  # [-] principal stretch or its inverse of F, that says more about the points than about the soil


def outside(position, grid):
    """(n,) bool, points at `position` (n, 3) [m] beyond the grid."""
    beyond = np.zeros(len(position), bool)
    for axis in np.flatnonzero(~grid.collapsed):
        lower, upper = grid.extent[axis]
        beyond |= (position[:, axis] < lower) | (position[:, axis] > upper)
    return beyond


def adrift(basis, grid, taking_part=None):
    """(n,) int, 0 for points of the largest piece of soil, else the number of their piece, and (pieces,) bool, whether
    a node of a piece is held. Pieces are sets of cells that touch, at a corner at least.

    taking_part: (n,) bool, None for all.
    """
    shape = [max(1, n - 1) for n in grid.shape]
    filled = np.zeros(shape, np.bool_)
    taking_part = np.ones(len(basis.first), bool) if taking_part is None else taking_part
    _fill(basis.first, basis.count, taking_part, filled)
    piece, count = ndimage.label(filled, np.ones((3, 3, 3)))
    if count <= 1:
        return np.zeros(len(basis.first), int), np.array([True])
    own = piece[tuple(np.minimum(basis.first, np.array(shape) - 1).T)] * taking_part
    sizes = np.bincount(own, minlength=count + 1)
    sizes[0] = 0
    held = np.zeros(count + 1, bool)
    nodes = np.argwhere(grid.fixed[:, ~grid.collapsed].any(axis=1).reshape(grid.shape))
    for shift in np.ndindex(2, 2, 2):
        held[piece[tuple(np.clip(nodes - shift, 0, np.array(shape) - 1).T)]] = True
    own[own == sizes.argmax()] = 0
    return own, held


@njit(cache=True)
def _fill(first, count, taking_part, filled):
    for p in range(len(first)):
        if taking_part[p]:
            for i in range(first[p, 0], first[p, 0] + max(1, count[p, 0] - 1)):
                for j in range(first[p, 1], first[p, 1] + max(1, count[p, 1] - 1)):
                    for k in range(first[p, 2], first[p, 2] + max(1, count[p, 2] - 1)):
                        filled[i, j, k] = True


def kept_back(old, new, leaving):
    """`new` Points but for those that were out of `old` or are `leaving` (n,) bool: they stay as in `old`, at rest."""
    out = leaving if old.inactive is None else old.inactive | leaving
    if not out.any():
        return new
    fields = {field.name: getattr(new, field.name) for field in dataclasses.fields(new)}
    for name, value in fields.items():
        if value is not None and name != "inactive":
            keep = out.reshape(-1, *[1] * (value.ndim - 1))
            still = name in ("velocity", "acceleration", "algorithmic", "affine")
            fields[name] = np.where(keep, 0.0 if still else getattr(old, name), value)
    return dataclasses.replace(new, **fields | {"inactive": out})


def stretched(deformation):
    """(n,) bool, points whose F (n, 3, 3) stretches a direction or the volume by more than LIMIT, or by less than its
    inverse."""
    squares = np.einsum("nij,nij->n", deformation, deformation)     # no smaller than the largest stretch squared
    volume = np.linalg.det(deformation)
    return (squares > LIMIT**2) | (volume > LIMIT) | (volume < 1 / LIMIT)


def listed(ids, places=None, most=5):
    """The first few of `ids` for a message, with their places [m]."""
    ids = np.asarray(ids)
    at = [""] * len(ids) if places is None else [" at (" + ", ".join(f"{x:.4g}" for x in p) + ") m" for p in places]
    shown = ", ".join(f"{i}{where}" for i, where in zip(ids[:most], at))
    return f"point{'s' * (len(ids) > 1)} {shown}" + (f" and {len(ids) - most} more" if len(ids) > most else "")


def refuse_outside(left, position, grid):
    """StepError about points `left` (n,) bool that would come to `position` (n, 3) [m] outside the grid, if any."""
    ids = np.flatnonzero(left)
    if len(ids) == 0:
        return
    ends = "; ".join(f"{axis} {low:.6g} to {high:.6g}" for axis, (low, high) in zip("xyz", grid.extent))
    raise StepError(f"{listed(ids, position[ids])} would leave the grid ({ends} m); enlarge the grid, hold its face, "
                    'or set soil.stray = "freeze" or "remove"')


def refuse_adrift(loose, position):
    """StepError about points `loose` (n,) bool at `position` that nothing holds in a quasi-static scene, if any."""
    ids = np.flatnonzero(loose)
    if len(ids):
        raise StepError(f"{listed(ids, position[ids])} touch no other soil and no held node, so that nothing carries "
                        'them in a quasi-static scene; set time.inertia = true, or soil.stray = "freeze" or "remove"')
