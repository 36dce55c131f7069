"""Mohr-Coulomb's section, with its corners rounded off: FORMULATION (18a).

    f = g(θ) √J2(s) + η p - ξ c(α)           straight between the meridians of compression and extension
    Δε_p = Δγ (s / 2√J2 + η̄ 1 / 3)           η̄ = η̄_c / g(θ, ē)

It is the pyramid of Mohr and Coulomb, but within ω = 1° of the meridians, where its strength is up to 1 % less: there f has no
derivative, and soil that is compressed evenly from its sides would have two tangents. Flow is along the deviator as in
`hybrid.laws.willam_warnke`, so the return has a closed form, and soil that shears in a plane has the strength of its φ whatever
the stress along the third axis. Where Willam and Warnke's arc bulges beyond the pyramid there, by 21 to 24 % of the strength of
soil of 20 to 33° with ψ = φ, limit loads are that much too high.

Equations: FORMULATION (18a).
"""

import numpy as np

from hybrid.laws.cone import Cone
from hybrid.laws.drucker_prager import cone_constants
from hybrid.laws.willam_warnke import meridian_ratio

CORNER = np.radians(1.0)    # ω; a strip and a passive wall take as many iterations from 0.25 to 2.5°


class MohrCoulomb(Cone):
    """Values per point, scalars or (n,) arrays: angles [degrees], cohesion [Pa], hardening dc/dα [Pa], floor [Pa]."""

    def __init__(self, young, poisson, friction_angle, dilation_angle, cohesion, hardening=0.0, residual_cohesion=0.0):
        eta, xi, flow = cone_constants(friction_angle, dilation_angle, "compression")
        strength, slope, residual = (xi * np.asarray(a, float) for a in (cohesion, hardening, residual_cohesion))
        super().__init__(young, poisson, eta, flow, strength, meridian_ratio(friction_angle), slope, residual,
                         meridian_ratio(dilation_angle), CORNER)
