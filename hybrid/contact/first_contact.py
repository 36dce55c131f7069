"""Where a corner that does not touch yet will meet the surface: the anchor of its friction, should it touch.

    y(s) = R(s)^T (x_c + s Δx_c - c - s Δc),   R(s) = exp(s φ~) R_n,   0 <= s <= 1
    anchor = y(s)  where the gap vanishes first, else y(1)

along the motion that the step expects (its first guess: everything keeps its velocity). Seen from a rolling
body the corner comes down a curved path, and before the touch it travels about a³/(3r²) along the surface of
a sphere of radius r, a being its way to the point of rest. At a = 50 mm and r = 0.25 m that is 0.7 mm, more
than what a stiff spring needs to slip, so an anchor where the corner stood at the step's start makes a
rolling sphere creep by 1-2 %. An anchor at the end of the step would lose the friction of the step in which
the contact is born. The expected motion is constant in a step, so the anchor adds nothing to the tangent.
Without motion the anchor is the place at the start. Where the path enters the body tells the side that the corner
comes from: in a thin body the nearest surface may soon be that of the other side.
"""

import math

import numpy as np
from numba import njit

from hybrid.body.attitude import log_so3
from hybrid.body.closest import NO_SIDE, clear, closest

HALVINGS = 12      # of the path: 10 μm at 40 mm
ON_SURFACE = 1e-9  # of the body's radius: a body laid on the soil touches it to round-off, and enters from there


def predicted_contact_points(start, end, body, pose, surface, clearance):
    """Meeting points (m, 3) [m] and outward normals there (m, 3), 0 where nothing is met, in the body frame.

    Corners are expected to go from `start` to `end` (m, 3) [m] in space while the body goes from `body` (a
    BodyState) to `pose` (position, rotation). clearance: (m,) [m] as in corners.Corners.
    """
    out = (start - body.position) @ body.rotation
    turn, side = log_so3(pose[1] @ body.rotation.T), np.zeros_like(out)
    angle = math.sqrt(turn @ turn)
    _meet(start - body.position, end - start - (pose[0] - body.position), turn / angle if angle > 0.0 else turn, angle,
          body.rotation, surface.radius, surface.tree, clearance, out, side)
    return out, side


@njit(cache=True)
def _meet(arm, way, axis, angle, rotation, radius, tree, clearance, out, side):
    """arm: (m, 3) from the centre at the start; way: (m, 3) relative to the centre; out: places before."""
    for n in range(len(arm)):
        begin = out[n, 0], out[n, 1], out[n, 2]
        last = _seen(n, arm, way, axis, angle, rotation, 1.0)
        x0, x1, x2 = last[0] - begin[0], last[1] - begin[1], last[2] - begin[2]
        short = x0 * x0 + x1 * x1 + x2 * x2 < max(clearance[n], 0.0) ** 2
        if short or clear(last[0], last[1], last[2], radius, tree) or _gap(last, tree) >= 0.0:
            out[n, 0], out[n, 1], out[n, 2] = last
        elif _gap(begin, tree) >= -ON_SURFACE * radius:
            outside, inside = 0.0, 1.0
            for _ in range(HALVINGS):
                middle = 0.5 * (outside + inside)
                if _gap(_seen(n, arm, way, axis, angle, rotation, middle), tree) > 0.0:
                    outside = middle
                else:
                    inside = middle
            y = _seen(n, arm, way, axis, angle, rotation, inside)
            triangle, feature, _, _, _ = closest(y, np.inf, tree, NO_SIDE)
            for i in range(3):
                out[n, i], side[n, i] = y[i], tree.normals[triangle, feature, i]


@njit(cache=True)
def _gap(y, tree):
    return closest(y, np.inf, tree, NO_SIDE)[4]


@njit(cache=True)
def _seen(n, arm, way, axis, angle, rotation, fraction):
    """Place in the body frame at a fraction of the step, as a tuple: turned back by Rodrigues' formula."""
    x0, x1, x2 = arm[n, 0] + fraction * way[n, 0], arm[n, 1] + fraction * way[n, 1], arm[n, 2] + fraction * way[n, 2]
    c, s = math.cos(fraction * angle), math.sin(fraction * angle)
    along = (1.0 - c) * (axis[0] * x0 + axis[1] * x1 + axis[2] * x2)
    y0 = c * x0 - s * (axis[1] * x2 - axis[2] * x1) + along * axis[0]
    y1 = c * x1 - s * (axis[2] * x0 - axis[0] * x2) + along * axis[1]
    y2 = c * x2 - s * (axis[0] * x1 - axis[1] * x0) + along * axis[2]
    return (rotation[0, 0] * y0 + rotation[1, 0] * y1 + rotation[2, 0] * y2,
            rotation[0, 1] * y0 + rotation[1, 1] * y1 + rotation[2, 1] * y2,
            rotation[0, 2] * y0 + rotation[1, 2] * y1 + rotation[2, 2] * y2)
