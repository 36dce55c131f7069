"""Rate at which a round body rolls in the first guess of an increment without inertia.

A body that is drawn along keeps no spin there. Displaced without turning, all of its contact points slip, and those
that close are expected to have slid: their tangential springs then resist the rolling. So it is turned by the smallest
rotation with which the points that touch it stand still in the mean,

    φ = argmin |Δ + φ × r|        r their mean arm, Δ the displacement that guides give the body in the increment

if hardly any slip is left at them. A block, or a pipe that is buried to its axis, does not roll in this way.
"""

import numpy as np

from hybrid.body.attitude import skew
from hybrid.runtime.comm import count, total

SLIDES = 0.3    # slip at the points that is left, rms over that without turning, from which on a body slides


def rolling_rate(body, state, history):
    """(6,) [m/s, rad/s] rate of turning of a RigidBody in a BodyState that guides draw along with `body.drive`; history: its
    ContactHistory."""
    free, rate = body.free[3:], np.zeros(6)
    drawn = body.drive[:3]
    if not (body.friction and free.any() and drawn.any() and body.outline.curved.any()):
        return rate
    arm = history.position[history.touching] - state.position
    points = count(history.touching)
    if not points:
        return rate
    by_rotation = -skew(total(arm) / points)[:, free]
    turn = np.zeros(3)
    turn[free] = np.linalg.lstsq(by_rotation, -drawn, rcond=1e-9)[0]
    left = np.sqrt(total(((drawn + np.cross(turn, arm)) ** 2).sum(axis=1)) / points)
    rate[3:] = turn if left < SLIDES * np.linalg.norm(drawn) else 0.0
    return rate
