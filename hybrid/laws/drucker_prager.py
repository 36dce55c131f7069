"""Drucker-Prager: a circular cone through one meridian of the Mohr-Coulomb pyramid (FORMULATION (19)), non-associated.

    f = √J2(s) + η p - ξ c(α)        flow potential √J2 + η̄ p        p = tr τ / 3, tension positive

`cone` names the meridian of the Mohr-Coulomb pyramid that the cone passes through:

    "compression"   η = 6 sinφ / √3(3 - sinφ)    ξ = 6 cosφ / √3(3 - sinφ)    strongest, circumscribes the pyramid
    "extension"     the same with 3 + sinφ                                    inner edges
    "plane strain"  η = 3 tanφ / √(9 + 12 tan²φ) ξ = 3 / √(9 + 12 tan²φ)      same collapse load in plane strain

η̄ is η of the dilation angle; equal angles are associated flow. The cohesion hardens or softens linearly with the
equivalent plastic strain, c(α) = max(c0 + H α, c_r). Softening localises in bands one cell wide, so its results depend
on the cells. Return and tangent are those of `hybrid.laws.cone`.

Equations: FORMULATION (19).
"""

import numpy as np

from hybrid.laws.cone import Cone

CONES = ("compression", "extension", "plane strain")


def cone_constants(angle, cone):
    """(η, ξ) of the cone matched to a Mohr-Coulomb friction (or dilation) angle [degrees]."""
    sin, cos, tan = np.sin(np.radians(angle)), np.cos(np.radians(angle)), np.tan(np.radians(angle))
    if cone == "plane strain":
        root = np.sqrt(9 + 12 * tan**2)
        return 3 * tan / root, 3 / root
    sign = {"compression": -1, "extension": 1}[cone]
    return 6 * sin / (np.sqrt(3) * (3 + sign * sin)), 6 * cos / (np.sqrt(3) * (3 + sign * sin))


class DruckerPrager(Cone):
    """Values per point, scalars or (n,) arrays: angles [degrees], cohesion [Pa], hardening dc/dα [Pa], floor [Pa]."""

    def __init__(self, young, poisson, friction_angle, dilation_angle, cohesion, cone="compression", hardening=0.0,
                 residual_cohesion=0.0):
        eta, xi = cone_constants(friction_angle, cone)
        strength, slope, residual = (xi * np.asarray(a, float) for a in (cohesion, hardening, residual_cohesion))
        super().__init__(young, poisson, eta, cone_constants(dilation_angle, cone)[0], strength, 1.0, slope, residual)
