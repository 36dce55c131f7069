"""The yield function of a Cone, which the program needs nowhere: its return ends where this is zero."""

import numpy as np

from hybrid.laws.cone import CORNER, ETA, RATIO, _section


def yield_function(law, stress, plastic_strain=0.0):
    """f (n,) [Pa] at principal stresses (n, 3) [Pa] and accumulated plastic strain (n,)."""
    eta, ratio, corner = law.parameters.T[[ETA, RATIO, CORNER]]
    mean = stress.mean(axis=1)
    deviator = stress - mean[:, None]
    norm = np.sqrt(np.sum(deviator**2, axis=1))
    g = np.array([_section(*one)[0] for one in zip(deviator, norm, ratio, corner)])
    return g * norm / np.sqrt(2) + eta * mean - law.cohesion(plastic_strain)
