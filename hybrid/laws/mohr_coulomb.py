"""Mohr-Coulomb's section, with its corners rounded off: FORMULATION (18a).

    f = g(θ) √J2(s) + η p - ξ c(α)           straight between the meridians of compression and extension
    Δε_p = Δγ (s / 2√J2 + η̄ 1 / 3)           η̄ = η̄_c / g(θ, ē)

It is the pyramid of Mohr and Coulomb, but within ω = 1° of the meridians, where its strength is up to 1 % less: there f
has no derivative, and soil that is compressed evenly from its sides would have two tangents. Flow is along the deviator
as in `hybrid.laws.willam_warnke`, so the return has a closed form, and soil that shears in a plane has the strength of
its φ whatever the stress along the third axis. Willam and Warnke's arc bulges beyond the pyramid there: at the same
mean stress its strength is 4 to 14 % higher for φ from 45 to 9°, the unconfined strength of soil of 20° 16 %, and a
bearing load 37 %.

Equations: FORMULATION (18a).
"""

import numpy as np

from hybrid.laws.willam_warnke import WillamWarnke

class MohrCoulomb(WillamWarnke):
    """The cone on the same meridians with straight sides between them; values as of that."""

    corner = np.radians(1.0)    # ω; a strip and a passive wall take as many iterations from 0.25 to 2.5°
