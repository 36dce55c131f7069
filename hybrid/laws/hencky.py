"""Hencky elasticity: a linear law between principal Kirchhoff stress and logarithmic strain (FORMULATION (14)).

    τ_i = K tr ε + 2 G dev(ε)_i          ψ = ½ K (tr ε)² + G dev ε : dev ε

Equations: FORMULATION (14).
"""

import copy

import numpy as np

from hybrid.laws import Response
from hybrid.runtime.jit import njit, prange

BULK, SHEAR = 0, 1      # columns of `parameters`


class Hencky:
    """Elastic law with Young's modulus [Pa] and Poisson's ratio per point, scalars or (n,) arrays."""

    plastic = False
    symmetric = True
    hardens = False

    def __init__(self, young, poisson):
        young, poisson = np.broadcast_arrays(np.atleast_1d(np.asarray(young, float)), poisson)
        self.young = np.array(young)
        self.parameters = np.column_stack([young / (3 * (1 - 2 * poisson)), young / (2 * (1 + poisson))])

    @property
    def undrained(self):
        """(n,) bool, points of clay: none of elastic soil."""
        return np.zeros(len(self.parameters), bool)

    @property
    def opens(self):
        """(n,) bool, points that open under tension: none of elastic soil."""
        return np.zeros(len(self.parameters), bool)

    @property
    def rows(self):
        """(n, 1 + k) Young's modulus and parameters of each point."""
        return np.column_stack([self.young, self.parameters])

    def with_rows(self, rows):
        """The same law for other points, given by their rows."""
        other = copy.copy(self)
        other.young, other.parameters = rows[:, 0].copy(), rows[:, 1:].copy()
        return other

    def respond(self, strain, plastic_strain=None):
        """Response to (n, 3) principal strains; there is no history."""
        stress, tangent = np.empty_like(strain), np.empty((len(strain), 3, 3))
        _respond(strain, self.parameters, stress, tangent)
        return Response(stress, strain, tangent)

    def energy(self, elastic):
        """Stored energy per initial volume (n,) [J/m³]."""
        return stored(elastic, self.parameters)

    def strain(self, stress):
        """Elastic strain (n, 3) that carries principal stresses (n, 3)."""
        bulk, shear = self.parameters[:, [BULK]], self.parameters[:, [SHEAR]]
        mean = stress.mean(axis=1, keepdims=True)
        return mean / (3 * bulk) + (stress - mean) / (2 * shear)


def stored(elastic, parameters):
    """ψ = ½ K (tr ε)² + G dev ε : dev ε, with K and G in the first two columns of `parameters`."""
    trace = elastic.sum(axis=1)
    deviator = elastic - trace[:, None] / 3
    return 0.5 * parameters[:, BULK] * trace**2 + parameters[:, SHEAR] * np.sum(deviator**2, axis=1)


@njit(cache=True, parallel=True)
def _respond(strain, parameters, stress, tangent):
    for p in prange(len(strain)):
        bulk, shear = parameters[p, BULK], parameters[p, SHEAR]
        trace = strain[p, 0] + strain[p, 1] + strain[p, 2]
        for i in range(3):
            stress[p, i] = (bulk - 2 * shear / 3) * trace + 2 * shear * strain[p, i]
            for j in range(3):
                tangent[p, i, j] = bulk - 2 * shear / 3 + (2 * shear if i == j else 0.0)
