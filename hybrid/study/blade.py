"""Force of sand on a blade that is dragged through it: limit equilibrium of McKyes and Ali (1977), and Coulomb's wedge.

    P = (γ d² N_γ + c d N_c + q d N_q) w      H = P sin(α + δ)      r = d (cot α + cot β)

    N_γ = r/2d (1 + 2/3 s)/D      N_c = (1 + cot β cot(β + φ)) (1 + s)/D      N_q = r/d (1 + s)/D
    s = r/w √(1 - (d cot α / r)²)      D = cos(α + δ) + sin(α + δ) cot(β + φ)

P acts at the angle δ, tan δ = μ, to the normal of the blade (width w, depth d, rake α); H is the draft. A wedge rises on
a plane at the angle β and meets the surface at a distance r in front of the tip, with a crescent on either side of it,
whose share is s; β is that of the smallest N_γ. Without the crescents (w infinite) P is Coulomb's passive force, with δ =
0 Rankine's. The formulas follow from the equilibrium of the wedge, weight γ d r/2 a width, and of the sectors of the
crescents, weight γ d r²/6 an angle, each pushed in its own direction. McKyes and Ali, J. Terramech. 14 (1977) 43-51.

In plane strain a cone has a friction angle of its own, `hybrid.laws.cone.plane_strain_strength`.
"""

import numpy as np

ANGLES = np.radians(np.linspace(5.0, 80.0, 7501))     # β that are tried


def factors(angle, wall, depth, width=np.inf, rake=90.0):
    """(N_γ, N_c, N_q, r [m]) of a friction angle φ, angle of wall friction δ and rake α [degrees], depth and width [m]."""
    phi, delta, alpha = np.radians([angle, wall, rake])
    beta = ANGLES[ANGLES < np.pi - phi - alpha - delta - 1e-3]      # D > 0
    r = depth * (1 / np.tan(alpha) + 1 / np.tan(beta))
    side = r / width * np.sqrt(np.maximum(0.0, 1 - (depth / r / np.tan(alpha)) ** 2))
    below = np.cos(alpha + delta) + np.sin(alpha + delta) / np.tan(beta + phi)
    weight = r / (2 * depth) * (1 + 2 / 3 * side) / below
    k = np.argmin(weight)
    cohesion = (1 + 1 / (np.tan(beta) * np.tan(beta + phi))) * (1 + side) / below
    return weight[k], cohesion[k], (r / depth * (1 + side) / below)[k], r[k]


def draft(soil, wall, depth, width, swept=0.0):
    """Draft H [N] of an upright blade after it has swept a distance [m].

    soil: (γ [N/m³], c [Pa], φ [degrees]). What it has swept, its depth times that distance, lies on the wedge as an even
    surcharge.
    """
    weight, cohesion, angle = soil
    n_weight, n_cohesion, n_surcharge, r = factors(angle, wall, depth, width)
    surcharge = weight * depth * swept / r
    force = weight * depth**2 * n_weight + cohesion * depth * n_cohesion + surcharge * depth * n_surcharge
    return force * width * np.cos(np.radians(wall))
