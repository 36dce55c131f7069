"""Clay that stands away from the sides of a body which moves up or down along them, so that its adhesion bears nothing.

The foot of a pile or of a skirt drives a hole that is wider than the body, by the rounding of its edges and what cells drag
along, and clay that its own strength holds up does not close it again. A strip of 0.5 m, 8 cells, pressed 1 m into clay of
5 kPa, α = 0.5: its sides bear 47 % of α s_u A, nothing until it is half as deep, and 48 and 43 % as it is drawn out by 0.1
and 0.2 m; one that is in the soil from the start 82 and 78 %. The skirts of a caisson, two cells thick: nothing.
"""

import numpy as np

from hybrid.monitors.monitor import Monitor
from hybrid.runtime.comm import gathered, maximum, total
from hybrid.scene.ground import heights_at

LIMIT = 0.6     # share of the adhesion of the sides that they bear
MATTERS = 0.1   # of the force on the body, along its motion: what is missing
STEPS = 3       # in a row
SLIPS = 0.05    # of a cell: way from which on they bear what they can
UPRIGHT = 0.98  # cosine between a motion and the vertical
ALONG = 0.2     # cosine between a motion and the normals of sides
PARTS = 8       # of an edge of a triangle, whose middles stand for its area


class PartedSides(Monitor):
    """Warns once for each body; the last values are those at the end."""

    grows = True
    forgets = ("_strength",)

    def __init__(self, model, state):
        super().__init__(model, state)
        self._steps, self._way = [0] * len(model.bodies), [0.0] * len(model.bodies)     # the way since a body turned round
        self._last = [motion.position.tolist() for motion in state.bodies] if any(map(_adheres, model.bodies)) else []
        self._strength = None

    def warnings(self, view):
        """Body, force, limit, cause and remedy."""
        for number, body, motion, contact in view.bodies if self._last else ():
            moved = motion.position - self._last[number]
            self._last[number] = motion.position.tolist()
            length = np.linalg.norm(moved)
            if not _adheres(body) or length == 0.0 or abs(moved[2]) < UPRIGHT * length:
                continue
            way = self._way[number] = float(moved[2]) + self._way[number] * (moved[2] * self._way[number] > 0.0)
            if abs(way) < SLIPS * view.model.soil.grid.smallest_cell:
                continue        # what the sides bear grows with it
            adhesion = self._of_sides(view.model, body, motion)
            side = np.abs(contact.normal[:, 2]) < ALONG
            borne = abs(float(total(contact.shear[side])[2]))
            missing = adhesion - borne > MATTERS * abs(contact.resultant[2])
            self._steps[number] = self._steps[number] + 1 if missing and borne < LIMIT * adhesion else 0
            if self._steps[number] >= STEPS:
                yield number, (
                    f"the sides of {body.name} bear {borne:.3g} N of the {adhesion:.3g} N of adhesion to the clay beside "
                    f"them ({borne / adhesion:.0%}, limit {LIMIT:.0%}) at t = {view.state.time:.4g} s: the hole that its "
                    "foot drives is wider than the body, and the clay stands away from it. Add what is missing by hand, or "
                    "let the body begin in the soil, or clay carry tension on it (body.tension, \"full\" for clay that "
                    "never breaks away)")

    def _of_sides(self, model, body, motion):
        """α s_u A [N] of the sides of a body in the part that is modelled, below the ground as it is at the start."""
        if self._strength is None:
            self._strength = _strength_by_height(model.soil)
        place, area = _sides(model.soil, body, motion)
        height, strength = self._strength
        top = height[-1] if model.soil.heights is None else np.minimum(
            heights_at(model.soil.heights[0], place[:, :2]), model.soil.heights[1])
        under = np.where(place[:, 2] < top, area, 0.0)
        return float(body.interface.adhesion * under @ np.interp(place[:, 2], height, strength))


def _adheres(body):
    """Whether nothing but the pressure and strength of clay limits the shear on a body."""
    return bool(body.interface and body.interface.adhesion) and not body.interface.tension and np.isinf(body.friction)


def _strength_by_height(soil):
    """Heights (k,) [m], the last one that of the top, and the mean strength of clay (k,) [Pa] there, 0 of other soil."""
    constants = soil.constants
    height = gathered(constants.position[:, 2])
    strength = gathered(np.where(soil.law.undrained, soil.law.shear_strength(0.0), 0.0))
    top = maximum(constants.position[:, 2] + constants.half_width[:, 2])
    rows, row = np.unique(height.round(9), return_inverse=True)
    mean = np.bincount(row, strength) / np.bincount(row)
    return np.append(rows, top), np.append(mean, mean[-1])


def _sides(soil, body, motion):
    """Places (k, 3) [m] on the upright faces of a body, and the area [m²] that each stands for."""
    collapsed, outline = soil.grid.collapsed, body.outline
    normals = outline.normals @ motion.rotation.T
    chosen = (np.abs(normals[:, 2]) < ALONG) & (np.abs(normals[:, collapsed]) < ALONG).all(axis=1)
    corners = (outline.vertices @ motion.rotation.T + motion.position)[outline.triangles[chosen]]
    at = [(i + part / 3, j + part / 3) for i in range(PARTS) for j in range(PARTS)
          for part in (1, 2) if i + j + part <= PARTS]
    weights = np.array([(PARTS - i - j, i, j) for i, j in at]) / PARTS
    share = 0.5 ** sum(not mirror.cut for mirror in body.mirrors)
    for axis in np.flatnonzero(collapsed):      # a body may be longer than the slice
        share *= np.ptp(soil.grid.extent[axis]) / np.ptp(outline.vertices @ motion.rotation[axis])
    area = np.repeat(share * outline.areas[chosen] / len(weights), len(weights))
    return (weights @ corners).reshape(-1, 3), area
