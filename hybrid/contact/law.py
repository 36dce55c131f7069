"""Law of contact at points against the surface of a body: penalty, friction, adhesion and a bond.

    y = R^T (x_c - c)      y - y_s = g N      p = ε_N (g_0 - g) > 0
    z = y - y_anchor       g_t = P z,  P = I - N N^T
    stick  |ε_T g_t| <= μ p :  f = -p N + ε_T g_t
    slip   otherwise        :  f = -p N + μ p s,  s = g_t/|g_t|

(FORMULATION (38) to (41); the seed paper's eqs 3-6), all in the body frame. f is the residual of the penalty, minus the
force on the contact point. The normal turns with y on a curved face, at an edge and at a vertex; with G = ∂N/∂y,

    M = ∂g_t/∂y = P - (N·z) G - N (G^T z)^T
    normal ∂f/∂y = ε_N N (∂g/∂y)^T - p G
    stick  + ε_T M                        slip  + μp/|g_t| (I - s s^T) M - μ ε_N s (∂g/∂y)^T

| symbol     | meaning                                             | in the kernels                      | unit |
|------------|-----------------------------------------------------|-------------------------------------|------|
| g, y_s     | signed gap and closest point of the surface         | ClosestPoints.gap, .closest_point   | m    |
| N, ∂g/∂y   | outward normal and gradient of the gap              | N, dgap of `body.closest`           | -    |
| G          | ∂N/∂y                                               | G of `body.closest.gap_geometry`    | 1/m  |
| p          | pressure                                            | p                                   | N    |
| ε_N, ε_T   | normal and tangential penalty                       | ClosedPoints.stiffness, eps_t       | N/m  |
| μ          | coefficient of friction                             | Coulomb.mu                          | -    |
| y_anchor   | where the tangential spring has no force            | ClosedPoints.anchor                 | m    |
| g_t, s     | tangential gap and its direction                    | g_t, s                              | m, - |

With an interface of clay (contact/interface.py, FORMULATION (40a)) the limit of the shear is L = min(μ p, α s_u a), and
bonded points pull, p >= -T; where p = -T or L = α s_u a the derivatives of p and L vanish.

On a plane face G = 0. The anchor is history in the body frame: it is objective, and it does not change when a contact
point passes from one triangle to the next. The anchor of a point that closes in this step is its predicted
first-contact point (contact/first_contact.py). Without friction (μ = 0) neither anchor nor tangential law is evaluated.

The force of a step acts over the whole step, also on a contact point that closes in the course of it. The friction work of a
slipping point therefore counts its path from the start of the step.
"""

import math
from typing import NamedTuple

import numpy as np

from hybrid.body.closest import gap_geometry
from hybrid.contact.interface import RAMP, PlaceLimits, shear_limit, work_to_break
from hybrid.runtime.jit import njit

NOWHERE = np.zeros(0, bool)


class ClosedPoints(NamedTuple):
    """Points that the law is evaluated at, body frame: y, anchor (m, 3) [m]; origin (m, 3) [m], where the path begins
    along which friction does work in this step; stiffness (m,) ε_N [N/m]; rest (m,) [m] gap without force; limits:
    PlaceLimits; sticking (m,) bool as in ContactPoints, steady (m,) bool whose pressure does not change with the gap, empty
    for none."""

    y: np.ndarray
    anchor: np.ndarray
    origin: np.ndarray
    stiffness: np.ndarray
    rest: np.ndarray
    limits: PlaceLimits
    sticking: np.ndarray = NOWHERE
    steady: np.ndarray = NOWHERE


class Coulomb(NamedTuple):
    """Coefficient of friction μ, inf where adhesion alone limits the shear, and ratio ε_T/ε_N of the penalties."""

    mu: float
    ratio: float


class ContactResponse(NamedTuple):
    """Output of the law, body frame: force (m, 3) [N], tangent (m, 3, 3) [N/m] and of it turning and ramp (m, 3, 3), slip
    (m,) bool, anchor (m, 3) [m] after the step, side (m, 3) N, energy and dissipated (m,) [J], opened (m,) bool."""

    force: np.ndarray
    tangent: np.ndarray
    turning: np.ndarray
    ramp: np.ndarray
    slip: np.ndarray
    anchor: np.ndarray
    side: np.ndarray
    energy: np.ndarray
    dissipated: np.ndarray
    opened: np.ndarray

    @classmethod
    def empty(cls, m):
        return cls(np.empty((m, 3)), np.empty((m, 3, 3)), np.empty((m, 3, 3)), np.zeros((m, 3, 3)), np.zeros(m, np.bool_),
                   np.empty((m, 3)), np.empty((m, 3)), np.zeros(m), np.zeros(m), np.zeros(m, np.bool_))


@njit(cache=True)
def contact_law(points, closest, coulomb, tree, out):
    """The law of the module's head at every closed point."""
    # unpacked once, because each access in the loop would count references
    y, y_anchor, origin, stiffness, rest, limits, sticking, steady = points
    gap, triangle, feature, closest_point, weights = closest
    shear, tension, _ = limits
    force, tangent, turning, ramp, slip, anchor, side, energy, dissipated, opened = out
    M, g_t, t, K, bonds = np.empty((3, 3)), np.empty(3), np.empty(3), np.empty((3, 3)), len(tension) > 0
    for n in range(len(y)):
        eps_n, eps_t = stiffness[n], coulomb.ratio * stiffness[n]
        p, slope, bonded = eps_n * (rest[n] - gap[n]), eps_n, bonds and tension[n] > 0.0
        p = p if bonded else max(p, 0.0)    # of one that just touches
        slope = 0.0 if len(steady) and steady[n] else slope
        energy[n] = 0.5 * p * p / eps_n
        if bonded and p < -tension[n]:
            energy[n] = work_to_break(tension[n], p, eps_n)
            p, slope, opened[n] = -tension[n], 0.0, True
        N, dgap, G = gap_geometry(y[n], closest_point[n], weights[n], gap[n], triangle[n], feature[n], tree)
        for i in range(3):
            side[n, i], anchor[n, i], force[n, i] = N[i], y_anchor[n, i], -p * N[i]
            for j in range(3):
                turning[n, i, j] = -p * G[i][j]
                tangent[n, i, j] = slope * N[i] * dgap[j] + turning[n, i, j]
        if coulomb.mu > 0.0:
            limit, change = shear_limit(p, slope, coulomb.mu, n, shear, bonded)
            _tangential_gap(y[n], y_anchor[n], N, G, g_t, M)
            size = math.sqrt(g_t[0] * g_t[0] + g_t[1] * g_t[1] + g_t[2] * g_t[2])
            slip[n] = not (eps_t * size <= limit or len(sticking) and sticking[n])
            if slip[n]:
                s = g_t[0] / size, g_t[1] / size, g_t[2] / size
                _slip(limit, size, change, dgap, s, M, t, K)
                dissipated[n] = limit * _slipped(y[n], origin[n], s, limit / eps_t)
                energy[n] += 0.5 * limit * limit / eps_t
                for i in range(3):
                    anchor[n, i] = y[n, i] - s[i] * (limit / eps_t)
                    for j in range(3):
                        ramp[n, i, j] = -change * s[i] * dgap[j] if change >= RAMP * slope else 0.0
            elif limit > 0.0 or p >= 0.0:       # one that only just touches would stick
                _stick(eps_t, g_t, M, t, K)
                energy[n] += 0.5 * eps_t * size * size
            else:
                t[:], K[:] = 0.0, 0.0       # pulled, without shear strength
            for i in range(3):
                force[n, i] += t[i]
                for j in range(3):
                    tangent[n, i, j] += K[i, j]
        if opened[n]:
            dissipated[n] += energy[n]
            energy[n] = 0.0


@njit(cache=True)
def _tangential_gap(y, y_anchor, N, G, g_t, M):
    """Fill g_t (3,) = P z, z = y - y_anchor, and M (3, 3) = ∂g_t/∂y."""
    z = y[0] - y_anchor[0], y[1] - y_anchor[1], y[2] - y_anchor[2]
    z_n = N[0] * z[0] + N[1] * z[1] + N[2] * z[2]
    for i in range(3):
        g_t[i] = z[i] - z_n * N[i]
        for j in range(3):
            Gz = G[0][j] * z[0] + G[1][j] * z[1] + G[2][j] * z[2]
            M[i, j] = (1.0 if i == j else 0.0) - N[i] * N[j] - z_n * G[i][j] - N[i] * Gz


@njit(cache=True)
def _stick(eps_t, g_t, M, t, K):
    """Fill t (3,) = ε_T g_t and K (3, 3) = ∂t/∂y."""
    for i in range(3):
        t[i] = eps_t * g_t[i]
        for j in range(3):
            K[i, j] = eps_t * M[i, j]


@njit(cache=True)
def _slip(limit, size, slope, dgap, s, M, t, K):
    """Fill t (3,) = L s and K (3, 3) = ∂t/∂y. limit: L [N]; size: |g_t| [m]; slope: -∂L/∂g [N/m]; dgap: ∂g/∂y."""
    for i in range(3):
        t[i] = limit * s[i]
        for j in range(3):
            sM = s[0] * M[0, j] + s[1] * M[1, j] + s[2] * M[2, j]
            K[i, j] = limit / size * (M[i, j] - s[i] * sM) - slope * s[i] * dgap[j]


@njit(cache=True)
def _slipped(y, origin, s, held):
    """Length [m] of the path from `origin` along s, less the elongation `held` [m] of the tangential spring."""
    return -held + s[0] * (y[0] - origin[0]) + s[1] * (y[1] - origin[1]) + s[2] * (y[2] - origin[2])
