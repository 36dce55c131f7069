"""Drucker-Prager: a circular cone through one meridian of the Mohr-Coulomb pyramid (FORMULATION (19)), non-associated.

    f = √J2(s) + η p - ξ c(α)        flow potential √J2 + η̄ p        p = tr τ / 3, tension positive

`cone` names the meridian of the Mohr-Coulomb pyramid that the cone passes through:

    "compression"   η = 6 sinφ / √3(3 - sinφ)    ξ = 6 cosφ / √3(3 - sinφ)    strongest, circumscribes the pyramid
    "extension"     the same with 3 + sinφ                                    inner edges
    "plane strain"  η = sinφ / (r + η̄ sinφ/3)    ξ = cosφ / (r + η̄ sinφ/3)    exact where the soil flows in plane strain

η̄ is η of associated flow with the dilation angle, in plane strain η̄ = sinψ / √(1 + sin²ψ/3), and r = √(1 - η̄²/3). There
the deviator along the thickness is -2/3 η̄ √J2 once the soil flows, whatever φ is, and η and ξ are those of
Mohr-Coulomb's line in the other two principal stresses. Equal angles are associated flow. The cohesion hardens or softens
linearly with the equivalent plastic strain, c(α) = max(c0 + H α, c_r). Softening localises in bands one cell wide, so its
results depend on the cells. Return and tangent are those of `hybrid.laws.cone`.

Equations: FORMULATION (19).
"""

import numpy as np

from hybrid.laws.cone import Cone


def cone_constants(friction_angle, dilation_angle, cone):
    """(η, ξ, η̄) of the cone matched to Mohr-Coulomb's angles [degrees], scalars or arrays."""
    sin, cos, dilation = (f(np.radians(a)) for f, a in ((np.sin, friction_angle), (np.cos, friction_angle),
                                                        (np.sin, dilation_angle)))
    if cone == "plane strain":
        flow = dilation / np.sqrt(1 + dilation**2 / 3)
        root = np.sqrt(1 - flow**2 / 3) + flow * sin / 3
        return sin / root, cos / root, flow
    sign = {"compression": -1, "extension": 1}[cone]
    root, of_flow = (np.sqrt(3) * (3 + sign * a) for a in (sin, dilation))
    return 6 * sin / root, 6 * cos / root, 6 * dilation / of_flow


class DruckerPrager(Cone):
    """Values per point, scalars or (n,) arrays: angles [degrees], cohesion [Pa], hardening dc/dα [Pa], floor [Pa]."""

    def __init__(self, young, poisson, friction_angle, dilation_angle, cohesion, cone="compression", hardening=0.0,
                 residual_cohesion=0.0):
        eta, xi, flow = cone_constants(friction_angle, dilation_angle, cone)
        super().__init__(young, poisson, eta, flow, cohesion, 1.0, hardening, residual_cohesion, xi=xi)
