"""Hencky elasticity with a perfectly plastic, non-associated Drucker-Prager cone, apex included.

    f = √J2(s) + η p - ξ c        flow potential √J2 + η̄ p        p = tr τ / 3, tension positive

Cone return: Δγ = f_tr / (G + K η η̄), s = (1 - GΔγ/√J2_tr) s_tr, p = p_tr - K η̄ Δγ; where that would turn s over, the
stress goes to the apex p = ξ c / η. The algorithmic tangent of the cone is that of de Souza Neto, Perić & Owen,
Computational Methods for Plasticity (2008), section 8.3; at the apex it is zero.

`cone` tells which meridian of the Mohr-Coulomb pyramid the cone passes through:

    "compression"   η = 6 sinφ / √3(3 - sinφ)    ξ = 6 cosφ / √3(3 - sinφ)    strongest, circumscribes the pyramid
    "extension"     the same with 3 + sinφ                                    inner edges
    "plane strain"  η = 3 tanφ / √(9 + 12 tan²φ) ξ = 3 / √(9 + 12 tan²φ)      same collapse load in plane strain
"""

import numpy as np
from numba import njit, prange

from hybrid.laws import Response
from hybrid.laws.hencky import Hencky, stored

CONES = ("compression", "extension", "plane strain")


def cone_constants(angle, cone):
    """(η, ξ) of the cone matched to a Mohr-Coulomb friction (or dilation) angle [degrees]."""
    sin, cos, tan = np.sin(np.radians(angle)), np.cos(np.radians(angle)), np.tan(np.radians(angle))
    if cone == "plane strain":
        root = np.sqrt(9 + 12 * tan**2)
        return 3 * tan / root, 3 / root
    sign = {"compression": -1, "extension": 1}[cone]
    return 6 * sin / (np.sqrt(3) * (3 + sign * sin)), 6 * cos / (np.sqrt(3) * (3 + sign * sin))


class DruckerPrager(Hencky):
    """Elastic constants and strength per point, scalars or (n,) arrays; angles in degrees, cohesion in Pa.

    parameters: (n, 5) columns K, G, η, η̄, ξ c.
    """

    symmetric = False

    def __init__(self, young, poisson, friction_angle, dilation_angle, cohesion, cone="compression"):
        super().__init__(young, poisson)
        eta, xi = cone_constants(friction_angle, cone)
        eta_bar, _ = cone_constants(dilation_angle, cone)
        n = len(self.parameters)
        strength = [np.broadcast_to(a, n) for a in (eta, eta_bar, xi * np.asarray(cohesion, float))]
        self.parameters = np.column_stack([self.parameters, *strength])

    def respond(self, strain):
        """Response to (n, 3) trial principal strains."""
        stress, elastic, tangent = np.empty_like(strain), np.empty_like(strain), np.empty((len(strain), 3, 3))
        _return_map(strain, self.parameters, stress, elastic, tangent)
        return Response(stress, elastic, tangent)

    def energy(self, elastic):
        return stored(elastic, self.parameters)


@njit(cache=True, parallel=True)
def _return_map(strain, parameters, stress, elastic, tangent):
    for p in prange(len(strain)):
        K, G, eta, eta_bar, strength = parameters[p]
        trace = strain[p, 0] + strain[p, 1] + strain[p, 2]
        e0, e1, e2 = strain[p, 0] - trace / 3, strain[p, 1] - trace / 3, strain[p, 2] - trace / 3
        norm = np.sqrt(e0 * e0 + e1 * e1 + e2 * e2)
        root = np.sqrt(2.0) * G * norm  # √J2 of the trial stress
        pressure = K * trace
        excess = root + eta * pressure - strength
        multiplier = excess / (G + K * eta * eta_bar)
        if excess <= 0.0:
            scale, mean = 1.0, pressure
        elif root >= G * multiplier:
            scale, mean = 1.0 - G * multiplier / root, pressure - K * eta_bar * multiplier
        else:
            scale, mean = 0.0, strength / eta
        for i, e in enumerate((e0, e1, e2)):
            stress[p, i] = 2 * G * scale * e + mean
            elastic[p, i] = scale * e + mean / (3 * K)
        _tangent(tangent[p], K, G, eta, eta_bar, multiplier if excess > 0.0 else 0.0, scale, (e0, e1, e2), norm)


@njit(cache=True)
def _tangent(matrix, K, G, eta, eta_bar, multiplier, scale, e, norm):
    if scale == 0.0 and multiplier > 0.0:
        matrix[:] = 0.0
        return
    for i in range(3):
        for j in range(3):
            matrix[i, j] = 2 * G * scale * ((1.0 if i == j else 0.0) - 1 / 3) + K
    if multiplier > 0.0:
        A = 1 / (G + K * eta * eta_bar)
        for i in range(3):
            for j in range(3):
                di, dj = e[i] / norm, e[j] / norm
                matrix[i, j] += (2 * G * (1.0 - scale - G * A) * di * dj - K * K * eta * eta_bar * A
                                 - np.sqrt(2.0) * G * A * K * (eta * di + eta_bar * dj))
