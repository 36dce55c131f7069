"""Willam-Warnke section: a cone on both meridians of the Mohr-Coulomb pyramid, smooth and convex between them.

    f = g(θ, e) √J2(s) + η p - ξ c(α)        e = (3 - sinφ) / (3 + sinφ)        flow potential √J2 + η̄ p

η and ξ are those of triaxial compression (`hybrid.laws.drucker_prager`). In extension g = 1/e makes them those of the
extension meridian, since both shrink by e. The potential is circular, with the dilation angle of triaxial compression;
flow is therefore not associated where e < 1. The cohesion hardens or softens as that of Drucker-Prager. Section, return
and tangent are those of `hybrid.laws.cone`.
"""

import numpy as np

from hybrid.laws.cone import Cone
from hybrid.laws.drucker_prager import cone_constants


class WillamWarnke(Cone):
    """Values per point, scalars or (n,) arrays: angles [degrees], cohesion [Pa], hardening dc/dα [Pa], floor [Pa]."""

    def __init__(self, young, poisson, friction_angle, dilation_angle, cohesion, hardening=0.0, residual_cohesion=0.0):
        eta, xi = cone_constants(friction_angle, "compression")
        sin = np.sin(np.radians(friction_angle))
        strength, slope, residual = (xi * np.asarray(a, float) for a in (cohesion, hardening, residual_cohesion))
        super().__init__(young, poisson, eta, cone_constants(dilation_angle, "compression")[0], strength,
                         (3 - sin) / (3 + sin), slope, residual)
