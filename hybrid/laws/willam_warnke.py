"""Willam-Warnke section: a cone on both meridians of the Mohr-Coulomb pyramid, smooth and convex (FORMULATION (18)).

    f = g(θ, e) √J2(s) + η p - ξ c(α)        e = (3 - sinφ) / (3 + sinφ)
    Δε_p = Δγ (s / 2√J2 + η̄ 1 / 3)           η̄ = η̄_c / g(θ, ē)        ē = (3 - sinψ) / (3 + sinψ)

η, ξ and η̄_c are those of triaxial compression (`hybrid.laws.drucker_prager`). In extension g = 1/e makes them those of
the extension meridian, where they are smaller by e, and η̄_c by ē: strength and dilation angle are right on both. With
one η̄ for all θ, plastic flow near extension would gain energy where η̄ > e η, as with ψ = φ. Flow is along the
deviator, so for e < 1 it is associated in its volume change only. The cohesion hardens or softens as that of
Drucker-Prager. Section, return and tangent are those of `hybrid.laws.cone`.

Equations: FORMULATION (18).
"""

import numpy as np

from hybrid.laws.cone import Cone
from hybrid.laws.drucker_prager import cone_constants


def meridian_ratio(angle):
    """Extension to compression meridian of Mohr-Coulomb at a friction (or dilation) angle [degrees]."""
    sin = np.sin(np.radians(angle))
    return (3 - sin) / (3 + sin)


class WillamWarnke(Cone):
    """Values per point, scalars or (n,) arrays: angles [degrees], cohesion [Pa], hardening dc/dα [Pa], floor [Pa]."""

    corner = 0.0    # ω of the arc

    def __init__(self, young, poisson, friction_angle, dilation_angle, cohesion, hardening=0.0, residual_cohesion=0.0):
        eta, xi, flow = cone_constants(friction_angle, dilation_angle, "compression")
        super().__init__(young, poisson, eta, flow, cohesion, meridian_ratio(friction_angle), hardening, residual_cohesion,
                         meridian_ratio(dilation_angle), self.corner, xi)
