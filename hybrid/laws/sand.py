"""Parameters of sand from its relative density (Brinkgreve, Engin & Engin 2010; FORMULATION (20)).

With Dr in percent: E50ref = 0.6 MPa Dr, φ = 28 + 0.125 Dr, ψ = max(0, -2 + 0.125 Dr), m = 0.7 - Dr/320,
γ_dry = 15 + 0.04 Dr, γ_buoyant = 19 + 0.016 Dr - 9.81 kN/m³; ν = 0.25, c = 0.3 kPa, K0 = 1 - sin φ.
Stiffness follows the initial horizontal stress: E = E50ref (K0 σ_v / 100 kPa)^m.

Equations: FORMULATION (20).
"""

from hybrid.scene.defaults import STANDARD_GRAVITY
from hybrid.scene.soil import NUMBERS

REFERENCE_PRESSURE = 100e3


def sand(relative_density, buoyant=False):
    """Parameters [SI, degrees] as a dict with the names of a scene's material.

    Density under water is the buoyant unit weight divided by g, which gives the right weight without the inertia of
    the pore water.
    """
    weight = 19 + 0.016 * relative_density - STANDARD_GRAVITY if buoyant else 15 + 0.04 * relative_density
    return {
        "density": weight * 1e3 / STANDARD_GRAVITY,
        "reference_young": 0.6e6 * relative_density,
        "stiffness_exponent": 0.7 - relative_density / 320,
        "poisson": 0.25,
        "friction_angle": 28 + 0.125 * relative_density,
        "dilation_angle": max(0.0, -2 + 0.125 * relative_density),
        "cohesion": 300.0,
    }


def material_values(material):
    """Material parameters by name: the preset of the relative density, overridden by what the scene gives."""
    values = sand(material.relative_density, material.buoyant) if material.relative_density is not None else {}
    given = {name: getattr(material, name) for name in NUMBERS if getattr(material, name) is not None}
    if "young" in given:
        values.pop("reference_young", None)
    return {**values, **given, "cone": material.cone}


def stiffness_from_stress(reference_young, exponent, horizontal_stress):
    """Young's modulus [Pa] at a horizontal effective stress [Pa, compression positive]."""
    return reference_young * (horizontal_stress / REFERENCE_PRESSURE) ** exponent
