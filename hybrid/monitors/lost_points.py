"""Tells of points that have gone astray: out of the grid, adrift, or stretched beyond reason (`hybrid.soil.lost_points`).

Of each kind it is told when there are some, and again whenever there are so many times as many as in AGAIN.
"""

import numpy as np

from hybrid.soil import lost_points
from hybrid.soil.basis import evaluate_basis

AGAIN = {"out": 2, "adrift": 10, "stretched": 10}


class Astray:
    """Notes about the points of a run; those that are so at the start are not told of."""

    def __init__(self, model, points):
        self._told = {kind: np.count_nonzero(found) for kind, found, _ in _kinds(model.soil, points)}

    def notes(self, model, state):
        """Texts about what is new at `state`: kind, number, mass, which, and what it means."""
        texts = []
        for kind, found, meaning in _kinds(model.soil, state.points):
            ids = np.flatnonzero(found)
            if len(ids) < max(1, AGAIN[kind.split()[0]] * self._told[kind]):
                continue
            self._told[kind] = len(ids)
            mass, at = model.soil.constants.mass, state.points.position[ids]
            heavy = mass[ids].sum()
            texts.append(f"{len(ids)} of {len(found)} points {kind} at t = {state.time:.4g} s ({heavy:.4g} kg, "
                         f"{heavy / mass.sum():.2g} of the mass): {lost_points.list_points(ids, at)}. {meaning}")
        return tuple(texts)


def _kinds(soil, points):
    """(kind, (n,) bool, what it means) of each kind."""
    out = np.zeros(len(points), bool) if points.inactive is None else points.inactive
    half = points.half_width if soil.basis == "gimp" else np.zeros_like(points.half_width)
    piece, _ = lost_points.detached_pieces(evaluate_basis(points.position, half, soil.grid.axes), soil.grid, ~out)
    return (
        ("out of the soil", out, "They take no part any more, and their mass, momentum and energy are gone."),
        ("adrift", (piece > 0) & ~out, "Their cells touch no other soil, so nothing but inertia acts on them."),
        (f"stretched beyond {lost_points.DISTORTION_LIMIT:g}", lost_points.distorted(points.deformation) & ~out,
         "Their domains are cut off at the width of a cell and say little of where the soil is; smaller steps or more "
         "points per cell help."),
    )
