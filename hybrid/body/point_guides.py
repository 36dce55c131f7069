"""Motion of a point of a body in chosen components: rows of constraints with multipliers, like those of joints.

    φ = e · (c + s) - x_n - Δ        s = R r        ∂φ/∂(δc, δφ) = (e, s × e)

with e the axis of the component, x_n where the point should be at the start of the increment and Δ the displacement that a
table has in it. λ is the force of the guide on the body at the point, λ Δ its work. All other components of the body and its
rotation stay free.

Equations: FORMULATION (53b).
"""

from dataclasses import dataclass, replace

import numpy as np

from hybrid.body.attitude import skew
from hybrid.body.guides import Guide

AXES = "xyz"


@dataclass(frozen=True)
class PointGuide:
    """A component of a point that follows a Guide.

    label: of the point; point: (3,) [m] from the centre in the body frame; bodies: (number of the body, None for the ground)
    """

    label: str
    point: np.ndarray
    guide: Guide
    bodies: tuple = (None, None)
    turning = None      # no hinge

    def of_body(self, number, start):
        """The guide of body `number` in a stage that starts at a time [s], to which its table is relative."""
        table = self.guide.table
        return replace(self, bodies=(number, None), guide=replace(
            self.guide, table=replace(table, times=table.times + start)))

    @property
    def name(self):
        """Label and component, such as "corner x"."""
        return f"{self.label} {AXES[self.guide.component]}"

    @property
    def bounds(self):
        """(1, 2) bounds of the multiplier: none."""
        return np.array([[-np.inf, np.inf]])

    @property
    def angular(self):
        """(1,) bool, rows that are angles."""
        return np.array([False])

    @property
    def points(self):
        """(2, 3) [m] in the frame of the body and of the ground."""
        return np.array([self.point, np.zeros(3)])

    def coordinate(self, poses):
        """The component [m] of the point's position."""
        (centre, turn), _ = poses
        return float((centre + turn @ self.point)[self.guide.component])

    def rows(self, poses, target=0.0):
        """φ (1,) and ∂φ/∂q (1, 12); target: [m] where the point should be."""
        axis = np.eye(3)[self.guide.component]
        gradient = np.concatenate([axis, np.cross(poses[0][1] @ self.point, axis), np.zeros(6)])
        return np.array([self.coordinate(poses) - target]), gradient[None]

    def curvature(self, poses, multipliers):
        """∂(λ ∂φ/∂q)/∂q (12, 12) [N/m, N, N m] with a fixed multiplier (1,)."""
        out = np.zeros((12, 12))
        force = multipliers[0] * np.eye(3)[self.guide.component]
        out[3:6, 3:6] = skew(force) @ skew(poses[0][1] @ self.point)
        return out
