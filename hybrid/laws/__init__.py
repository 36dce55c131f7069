"""Constitutive laws in principal logarithmic strain, one per file.

A law is an object with

    parameters                                     (n, k) array, one row per point
    respond(strain) -> Response                    strain (n, 3) trial principal logarithmic strain
    energy(elastic) -> (n,) [J/m³ of initial volume]
    symmetric                                      True when the tangent is symmetric for every state

Working in principal Kirchhoff stress and logarithmic strain keeps the small-strain format of a return mapping at
large deformation (formulation section 3).
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Response:
    """Answer of a law at all points.

    stress: (n, 3) principal Kirchhoff stress [Pa]
    elastic: (n, 3) principal elastic logarithmic strain after the return
    tangent: (n, 3, 3) d stress_i / d trial strain_j [Pa]
    """

    stress: np.ndarray
    elastic: np.ndarray
    tangent: np.ndarray
