"""Points that are inactive, detached from the soil, or distorted (`hybrid.soil.lost_points`).

A warning of each kind is given when there are such points, and again when their number has grown by the factor AGAIN.
"""

import numpy as np

from hybrid.monitors.monitor import Monitor
from hybrid.runtime.comm import count, number, total
from hybrid.soil import lost_points
from hybrid.soil.basis import evaluate_basis

AGAIN = {"inactive": 2, "detached": 10, "distorted": 10}


class LostPoints(Monitor):
    """Warns of the points of a run that get lost; those that are so at the start are not counted."""

    def __init__(self, model, state):
        super().__init__(model, state)
        self._reported = {kind: count(found) for kind, found, *_ in _kinds(model.soil, state.points)}

    def warnings(self, view):
        """Kind, number, mass, first few points and places, and what it means."""
        constants, points = view.model.soil.constants, view.state.points
        for kind, found, words, meaning in _kinds(view.model.soil, points):
            ids, lost = np.flatnonzero(found), count(found)
            if lost < max(1, AGAIN[kind] * self._reported[kind]):
                continue
            self._reported[kind] = lost
            mass = total(constants.mass[ids])
            yield (kind, lost), (
                f"{lost} of {number(found)} points {words} at t = {view.state.time:.4g} s ({mass:.4g} kg, "
                f"{mass / total(constants.mass):.2g} of the mass): "
                f"{lost_points.list_points(constants.named(ids), points.position[ids])}. {meaning}")


def _kinds(soil, points):
    """(kind, (n,) bool, words, what it means) of each kind; none where the soil is held."""
    if soil.held:
        return ()
    inactive = ~points.active
    half = points.half_width if soil.basis == "gimp" else np.zeros_like(points.half_width)
    piece, _ = lost_points.detached_pieces(evaluate_basis(points.position, half, soil.grid.axes), soil.grid, ~inactive)
    return (
        ("inactive", inactive, "are inactive",
         "They left the grid or lost all support; their mass, momentum and energy are no longer in the model."),
        ("detached", (piece > 0) & ~inactive, "are detached",
         "Their cells touch no other soil, so nothing but gravity and inertia acts on them."),
        ("distorted", lost_points.distorted(points.deformation) & ~inactive,
         f"are distorted (stretch or volume ratio beyond {lost_points.DISTORTION_LIMIT:g})",
         "Their domains are cut off at the width of a cell and no longer show where the soil is. Use smaller steps, or "
         "a larger soil.points_per_axis."),
    )
