"""Von Mises: undrained clay of the shear strength s_u, a cone without friction (FORMULATION (19)).

    f = √J2(s) - ξ s_u(α)        s_u(α) = max(s_u0 + H α, s_r)        associated flow, no plastic volume change

`cone` names the state in which the strength is that of Tresca with the same s_u, as for Drucker-Prager with φ = 0:

    "compression", "extension"   ξ = 2/√3    triaxial, |σ1 - σ3| = 2 s_u
    "plane strain"               ξ = 1       plane strain and simple shear, τ = s_u

In terms of the uniaxial yield stress, σ_y = √3 ξ s_u. Return and tangent are those of `hybrid.laws.cone`.

Equations: FORMULATION (19).
"""

from hybrid.laws.cone import Cone
from hybrid.laws.drucker_prager import cone_constants

BEARING = 6.0       # pressure that clay bears under a base, over s_u


class VonMises(Cone):
    """Values per point, scalars or (n,) arrays: strength s_u, hardening ds_u/dα and floor of softening, all [Pa]."""

    def __init__(self, young, poisson, strength, cone="compression", hardening=0.0, residual_strength=0.0):
        _, xi, _ = cone_constants(0.0, 0.0, cone)
        super().__init__(young, poisson, 0.0, 0.0, strength, 1.0, hardening, residual_strength, xi=xi)
