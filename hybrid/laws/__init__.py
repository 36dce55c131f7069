"""Constitutive laws in principal logarithmic strain, one per file. The contract of a law, the user's own too:

    young                                          (n,) [Pa] Young's modulus, which contact stiffness follows
    plastic                                        False when the strain never flows
    symmetric                                      whether all tangents are; of a user's law nobody asks
    respond(strain, plastic_strain) -> Response    strain (n, 3) trial principal logarithmic strain,
                                                   plastic_strain (n,) accumulated up to the committed state
    energy(elastic) -> (n,)                        [J/m³ of initial volume] stored by principal elastic strain (n, 3)
    strain(stress) -> (n, 3)                       elastic strain that carries principal stress (n, 3) at the start

A law is isotropic and keeps nothing between calls: it is asked many times a step, at strains that may be rejected. All
history is the elastic strain, from which trial strains are made, and one number, the accumulated equivalent plastic
strain

    α = Σ Δα      Δα = √(2/3 e:e)      e = dev (ε_trial - ε_elastic)

which the soil adds up from the responses it accepts (`plastic_increment`). A law that hardens takes α + Δα with this
same Δα; one that does not ignores it. Working in principal Kirchhoff stress and logarithmic strain keeps the
small-strain format of a return mapping at large deformation (formulation section 3).

A law of one's own needs no change here: `hybrid.laws.user` tells how it is given, `hybrid.laws.check` tests it. Whoever
keeps linear elasticity derives from `hybrid.laws.hencky.Hencky` and writes `respond` alone.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Response:
    """Answer of a law at all points. The tangent is an array of its own, which the caller may change.

    stress: (n, 3) principal Kirchhoff stress [Pa]
    elastic: (n, 3) principal elastic logarithmic strain after the return
    tangent: (n, 3, 3) d stress_i / d trial strain_j [Pa]
    failed: (n,) bool, points at which the law has no answer, or None when it has one everywhere. The increment is then
    halved; what the other fields hold at these points is never used.
    """

    stress: np.ndarray
    elastic: np.ndarray
    tangent: np.ndarray
    failed: np.ndarray | None = None


def plastic_increment(strain, elastic):
    """Equivalent deviatoric plastic strain √(2/3 e:e) (n,) of a return from trial to elastic strain, both (n, 3)."""
    x, y, z = (strain - elastic).T    # each by itself: sums along an axis of three are slow
    mean = (x + y + z) / 3
    return np.sqrt(2 / 3 * ((x - mean) ** 2 + (y - mean) ** 2 + (z - mean) ** 2))
