"""Constitutive laws in principal logarithmic strain (FORMULATION (10)), one per file.

The interface of a law, of a user's law too:

    young                                          (n,) [Pa] Young's modulus, which contact stiffness follows
    plastic                                        whether the law has plastic strain
    respond(strain, plastic_strain) -> Response    strain (n, 3) trial principal logarithmic strain,
                                                   plastic_strain (n,) accumulated up to the committed state
    energy(elastic) -> (n,)                        [J/m³ of initial volume] stored by principal elastic strain (n, 3)
    strain(stress) -> (n, 3)                       elastic strain that carries principal stress (n, 3) at the start

What else a law states; `hybrid.laws.user.CheckedLaw` does so for a user's law, with the values in brackets:

    symmetric     whether all tangents are symmetric                                          (False)
    opens         (n,) bool, points that open under tension                                   (False)
    parameters    (n, k) constants of each point, K and G [Pa] first (`hybrid.laws.cone`)     (None)
    hardens       whether the strength changes with plastic strain                            (False)
    undrained     (n,) bool, points of clay                                                   (False)

A law is isotropic and keeps no state: it is evaluated many times a step, at trial strains that may be rejected. The
history of a point is its elastic strain, from which the trial strain is made, and one number, the accumulated
equivalent plastic strain

    α = Σ Δα      Δα = √(2/3 e:e)      e = dev (ε_trial - ε_elastic)

which the soil accumulates over accepted increments (`plastic_increment`). A law that hardens uses α + Δα with this same
Δα; any other law ignores α. In principal Kirchhoff stress and logarithmic strain, return mapping at large deformation
has the same form as at small strain.

A user's law needs no change here: `hybrid.laws.user` shows how it is given and `hybrid.laws.check` tests it. A law with
linear elasticity can derive from `hybrid.laws.hencky.Hencky` and define `respond` alone.

Equations: FORMULATION (10).
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Response:
    """Response of a law at all points. The tangent is a new array, which the caller may change.

    stress: (n, 3) principal Kirchhoff stress [Pa]
    elastic: (n, 3) principal elastic logarithmic strain after the return
    tangent: (n, 3, 3) d stress_i / d trial strain_j [Pa]
    opened: (n,) volume strain that was returned to the apex of a cone, or None: soil then opens for good
    failed: (n,) bool, points without a valid response, or None if there are none. The increment is then halved; the
    other fields are not used at these points.
    """

    stress: np.ndarray
    elastic: np.ndarray
    tangent: np.ndarray
    failed: np.ndarray | None = None
    opened: np.ndarray | None = None


def plastic_increment(strain, elastic):
    """Equivalent deviatoric plastic strain √(2/3 e:e) (n,) of a return from trial to elastic strain, both (n, 3)."""
    x, y, z = (strain - elastic).T    # each by itself: sums along an axis of three are slow
    mean = (x + y + z) / 3
    return np.sqrt(2 / 3 * ((x - mean) ** 2 + (y - mean) ** 2 + (z - mean) ** 2))
