"""Rotations of a rigid body: the group SO(3), its exponential map and its Cayley map.

    exp(Θ̃) = I + sinθ/θ Θ̃ + (1 - cosθ)/θ² Θ̃²                 Rodrigues
    T(Θ)   = I - (1 - cosθ)/θ² Θ̃ + (θ - sinθ)/θ³ Θ̃²           right tangent:
    exp(Θ̃) exp(δΦ~) = exp((Θ + δΘ)~)  with  δΦ = T δΘ          to first order

    cay(Θ) = (I - Θ̃/2)^-1 (I + Θ̃/2)     about Θ by 2 atan(θ/2)  Cayley: rational, and
    cay(Θ) - I = Θ̃ (cay(Θ) + I)/2        a rotated arm changes by Θ × the mean of before and after
    cay(Θ) cay(δΦ) = cay(Θ + δΘ)          with  δΘ = (I + Θ̃/2 + ΘΘᵀ/4) δΦ

| symbol | meaning                                              | shape  | unit |
|--------|------------------------------------------------------|--------|------|
| Θ      | rotation vector: axis times angle θ                  | (3,)   | rad  |
| Θ̃      | skew matrix of Θ, Θ̃ a = Θ × a                        | (3, 3) | rad  |
| R      | rotation, body frame to space                        | (3, 3) | -    |
| T      | right tangent of the exponential map                 | (3, 3) | -    |

The Cayley vector is twice the vector part of the unit quaternion over its scalar part, 2 tan(angle/2) along the axis.

Sources: J. C. Simo and K. K. Wong, Int. J. Numer. Meth. Engng 31 (1991) 19-52 (T and the update on SO(3));
S. W. Shepperd, J. Guidance and Control 1 (1978) 223-224 (quaternion from a matrix without cancellation);
M. D. Shuster, J. Astronaut. Sci. 41 (1993) 439-517 (Cayley's vector, named after Rodrigues or Gibbs there).

Equations: FORMULATION (31), (35).
"""

import math

import numpy as np

from hybrid.runtime.errors import SceneError
from hybrid.runtime.jit import njit

# Below this angle (θ - sinθ)/θ³ loses digits; five terms of its series are then exact to round-off.
SERIES_ANGLE = 0.3


def skew(v):
    """Matrix (3, 3) with skew(v) @ a = v × a, for v of shape (3,)."""
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def skews(v):
    """The same of many: matrices (m, 3, 3) of v (m, 3)."""
    out = np.zeros((len(v), 3, 3))
    out[:, 0, 1], out[:, 0, 2], out[:, 1, 2] = -v[:, 2], v[:, 1], -v[:, 0]
    return out - out.transpose(0, 2, 1)


def _coefficients(angle):
    """sinθ/θ, (1 - cosθ)/θ² and (θ - sinθ)/θ³, accurate for any θ >= 0 including zero."""
    half, s = _sinc(0.5 * angle), angle * angle
    if angle < SERIES_ANGLE:
        cubic = 1 / 6 - s / 120 * (1 - s / 42 * (1 - s / 72 * (1 - s / 110)))
    else:
        cubic = (angle - math.sin(angle)) / (s * angle)
    return _sinc(angle), 0.5 * half * half, cubic


def _sinc(angle):
    """sinθ/θ."""
    return math.sin(angle) / angle if angle > 0.0 else 1.0


def exp_so3(theta):
    """Rotation (3, 3) of the rotation vector `theta` (3,) [rad]."""
    a, b, _ = _coefficients(math.sqrt(np.dot(theta, theta)))
    s = skew(theta)
    return np.eye(3) + a * s + b * (s @ s)


def right_tangent(theta):
    """T(Θ) (3, 3) of `theta` (3,) [rad]: δΦ = T δΘ where exp(Θ̃) exp(δΦ~) = exp((Θ + δΘ)~)."""
    _, b, c = _coefficients(math.sqrt(np.dot(theta, theta)))
    s = skew(theta)
    return np.eye(3) - b * s + c * (s @ s)


def quaternion(rotation):
    """Unit quaternion (4,) as (w, x, y, z) with w >= 0 of `rotation` (3, 3).

    The largest of the four components is found first and the others are divided by it (Shepperd), so nothing
    cancels. At half a turn, where w = 0 leaves the sign open, the first nonzero component is made positive.
    """
    r = np.asarray(rotation, dtype=float).tolist()      # plain numbers: arrays of four are slower than the arithmetic
    diagonal = r[0][0], r[1][1], r[2][2]
    trace = sum(diagonal)
    if trace >= max(diagonal):
        q = [1.0 + trace, r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]]
    else:
        i = diagonal.index(max(diagonal))
        j, m = (i + 1) % 3, (i + 2) % 3
        q = [r[m][j] - r[j][m], 0.0, 0.0, 0.0]
        q[1 + i] = 1.0 + r[i][i] - r[j][j] - r[m][m]
        q[1 + j] = r[i][j] + r[j][i]
        q[1 + m] = r[i][m] + r[m][i]
    first = next((part for part in q if part), 1.0)
    return np.array(q) / math.copysign(math.hypot(*q), first)


def log_so3(rotation):
    """Rotation vector (3,) [rad] with length in [0, π] of `rotation` (3, 3).

    Computed from the quaternion, so that neither a very small angle nor one close to π loses digits.
    """
    q = quaternion(rotation)
    sine = math.sqrt(np.dot(q[1:], q[1:]))
    if sine < 1e-150:   # sine/w would underflow; the limit of the factor below
        return 2.0 * q[1:]
    return 2.0 * math.atan2(sine, q[0]) / sine * q[1:]


def cayley(theta):
    """Rotation (3, 3) of the Cayley vector `theta` (3,) [-]."""
    s = skew(theta)
    return np.eye(3) + (s + 0.5 * (s @ s)) / (1.0 + 0.25 * np.dot(theta, theta))


def cayley_vector(rotation):
    """Cayley vector (3,) [-] of `rotation` (3, 3); at half a turn, where it has no limit, very long but finite."""
    q = quaternion(rotation)
    return 2.0 / max(q[0], 1e-9) * q[1:]


def cayley_rate(theta):
    """dΘ/dΦ (3, 3) of the Cayley vector `theta` (3,) [-] with respect to a rotation δΦ from the right."""
    return np.eye(3) + 0.5 * skew(theta) + 0.25 * np.outer(theta, theta)


def rotation_from_axis_angle(axis, angle):
    """Rotation (3, 3) by `angle` [rad] about `axis` (3,), of any nonzero length.

    Raises SceneError when the axis has no direction.
    """
    axis = np.asarray(axis, dtype=float)
    length = np.linalg.norm(axis)
    if axis.shape != (3,) or not (np.isfinite(length) and length > 0.0):
        raise SceneError(
            f"rotation axis {axis.tolist()} has no direction: it must be three finite numbers, not all zero; "
            "give for example (0, 0, 1) for a rotation about the vertical"
        )
    return exp_so3(angle / length * axis)


def initial_rotation(described):
    """Rotation (3, 3) of a body of a scene at the start. Raises SceneError as `rotation_from_axis_angle`."""
    if not described.rotation:
        return np.eye(3)
    return rotation_from_axis_angle(described.rotation[:3], np.radians(described.rotation[3]))


@njit(cache=True)
def turned(x, axis, angle):
    """The tuple x (3,) turned about a unit `axis` (3,) by `angle` [rad], by Rodrigues' formula."""
    c, s = math.cos(angle), math.sin(angle)
    along = (1.0 - c) * (axis[0] * x[0] + axis[1] * x[1] + axis[2] * x[2])
    return (c * x[0] + s * (axis[1] * x[2] - axis[2] * x[1]) + along * axis[0],
            c * x[1] + s * (axis[2] * x[0] - axis[0] * x[2]) + along * axis[1],
            c * x[2] + s * (axis[0] * x[1] - axis[1] * x[0]) + along * axis[2])
