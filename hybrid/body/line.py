"""Elastic pull line from a point of a rigid body to a target that moves as prescribed.

    d = c + R r - X      l = |d|      e = d/l      f = k (l - l0), or 0 when slack      E = ½ k (l - l0)²
    residual = B^T f e,  B = [I, -s~],  s = R r                                  = gradient of E
    tangent  = B^T D B + [0, 0; 0, f e~ s~],  D = k e e^T + (f/l)(I - e e^T)

| symbol | meaning                                          | shape | unit |
|--------|--------------------------------------------------|-------|------|
| r      | attachment on the body, from the centre, body frame | (3,) | m   |
| X      | target, in space                                 | (3,)  | m    |
| l0, k  | unstretched length and stiffness                 | -     | m, N/m |
| f      | tension, negative where a line carries compression | -   | N    |

The unknowns are (δc, δφ) with R <- exp(δφ~) R. Frozen: r, X, l0, k.

Equations: FORMULATION (37).
"""

import math

import numpy as np

from hybrid.body.attitude import skew
from hybrid.runtime.errors import StepError


def line_force(position, rotation, attachment, target, length, stiffness, tension_only=True):
    """Tension, residual, tangent and energy of the line.

    position (3,) [m] and rotation (3, 3) of the body; attachment (3,) [m] from its centre in the body
    frame; target (3,) [m]; length [m], stiffness [N/m], both above 0. Returns tension [N], residual (6,) = [N, N m about
    the centre], minus the force and moment of the line on the body, its tangent (6, 6) with respect to (δc,
    spatial δφ), and energy [J].

    A slack line (`tension_only` and not longer than `length`) gives zeros, even if both its ends
    coincide. Raises StepError when the ends of a line that carries compression coincide, as it then has no
    direction.
    """
    arm = rotation @ attachment
    span = position + arm - target
    distance = math.sqrt(np.dot(span, span))
    stretch = distance - length
    if tension_only and stretch <= 0.0:
        return 0.0, np.zeros(6), np.zeros((6, 6)), 0.0
    if distance <= 1e-12 * length:
        raise StepError(
            f"pull line: its ends are {distance:g} m apart, so a line that carries compression has no direction "
            f"(limit {1e-12 * length:g} m); use tension_only = true, or move the target away from the body"
        )

    tension = stiffness * stretch
    along = span / distance
    force = tension * along
    arm_skew = skew(arm)
    projector = np.outer(along, along)
    by_point = stiffness * projector + tension / distance * (np.eye(3) - projector)

    jacobian = np.hstack((np.eye(3), -arm_skew))
    tangent = jacobian.T @ by_point @ jacobian
    tangent[3:, 3:] += skew(force) @ arm_skew
    return tension, jacobian.T @ force, tangent, 0.5 * stiffness * stretch * stretch
