"""Friction at the threshold: a regularised law creeps where it should stick.

A block of 4 t, carried by 1 m² of a plane of tan θ = 0.5, is let go after its weight is carried.

    a = max(0, g (sin θ - μ cos θ))         d = a t² / 2

Friction that needs a way to act lets the block creep: a spring k = ε_T/ε_N p_f E A swings by 2 m g sin θ / k, which is
70 μm by default. At μ = tan θ itself nothing stops a block that moves, and it keeps the speed with which it leaves the
spring: g sin θ / ω, ω = √(k/m), or g sin θ Δt / 2 where a step is longer than that. The error is that of the way in
0.4 s, relative to that of a block without friction.
"""

import numpy as np

from hybrid.study.cases import watched
from hybrid.study.outcome import Seen
from hybrid.study.scenes import box, plane

TITLE = "stick and slip at the threshold"
PARAMETERS = ("friction over slope, μ / tan θ",)
MEASURE, RIGHT, WRONG = "error of the way over that without friction", 0.01, 0.05
METHODS = {"ε_T/ε_N = 1e-3": {"tangential": 1e-3}, "ε_T/ε_N = 1": {}, "Δt / 4": {"parts": 4}}
DEFAULT = "ε_T/ε_N = 1"
SAYS = r"tangential .* limit 0.3.*body\.tangential"
G, SLOPE, STEP, STEPS = 9.81, np.arctan(0.5), 0.01, 40


def settings(quick=False):
    ratios = (1.0,) if quick else (0.5, 0.9, 0.99, 1.0, 1.01, 1.1, 1.5)
    return [(ratio,) for ratio in ratios]


def solve(ratio, tangential=1.0, parts=1):
    """Seen of a block with that friction."""
    block = box(4.0, 4.0, 0.25, rest_on=0.0, friction=ratio * np.tan(SLOPE), held=("y", "rx", "ry", "rz"),
                tangential=tangential)
    gravity = G * np.array([np.sin(SLOPE), 0.0, -np.cos(SLOPE)])
    simulation, _, told = watched(plane(
        block, parts * STEPS, STEP / parts, stiffness=1e7, settle=5, gravity=tuple(gravity),
        solver={"tolerance": 1e-8}))
    way = simulation.state.bodies[0].position[0]
    time = STEPS * STEP
    free, exact = 0.5 * gravity[0] * time**2, 0.5 * max(0.0, gravity[0] * (1 - ratio)) * time**2
    return Seen(abs(way - exact) / free, tuple(text for text in told if "tangential" in text))
