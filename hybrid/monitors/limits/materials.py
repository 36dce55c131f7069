"""Material of the soil at a height, and whether clay stays attached to a body."""

from dataclasses import replace

import numpy as np

from hybrid.laws.sand import material_values
from hybrid.laws.user import is_of_user
from hybrid.monitors.limits.start import top_of
from hybrid.runtime.comm import maximum
from hybrid.scene.soil import FRICTIONAL, NUMBERS, as_clay, of_layer, within

CLAY, SAND = "von-mises", FRICTIONAL
STRIP = 5.14        # N_c of clay
UNBROKEN = 20.0     # of s_u: a tension that clay, which bears 12 s_u around a body, never reaches


def law_at(scene, soil, height):
    """Name of the law of the soil at a height [m]: that of its layer, or of soil.material."""
    return material_at(scene, soil, height).law


def material_at(scene, soil, height):
    """Material of the soil at a height [m], above the top that of the top, with the values of its relative density: that of
    its layer, or soil.material; clay with the keys of von Mises' law."""
    top, material = top_of(soil), scene.soil.material
    height = min(height, top)
    for layer in scene.soil.layers:
        low, end = within(layer, -np.inf, top)
        if height >= low and (height < end or height == end == top):
            material = of_layer(material, layer)
            break
    values = {name: value for name, value in material_values(material).items() if name in NUMBERS}
    return as_clay(replace(material, **values))


def prandtl(angle):
    """N_c [-] of a weightless strip on soil with a friction angle [deg] (Prandtl 1921)."""
    slope = np.tan(np.radians(angle))
    return (np.exp(np.pi * slope) * np.tan(np.radians(45.0 + 0.5 * angle)) ** 2 - 1.0) / slope


def weight_factor(angle):
    """N_γ [-] of a rough strip on soil with a friction angle [deg] (M. Hjiaj, A. V. Lyamin and S. W. Sloan, Int. J. Solids
    Struct. 42 (2005) 1681-1704)."""
    slope = np.tan(np.radians(angle))
    return float(np.exp((np.pi + 3.0 * np.pi**2 * slope) / 6.0) * slope ** (0.4 * np.pi))


def strip_pressure(material, width, gravity):
    """Pressure [Pa] that a Material carries under a strip of a `width` [m]; gravity [m/s²]."""
    if material.law == CLAY or not material.friction_angle:
        return STRIP * (material.strength or material.cohesion or 0.0)
    angle = material.friction_angle
    return (0.5 * gravity * material.density * width * weight_factor(angle) + (material.cohesion or 0.0) * prandtl(angle))


def stays_attached(body, soil):
    """Whether clay never breaks away from a body."""
    tension = body.interface.tension if body.interface is not None else 0.0
    if is_of_user(soil.law) or np.isinf(tension):
        return np.isinf(tension)
    return tension > UNBROKEN * maximum(np.where(soil.law.undrained, soil.law.shear_strength(0.0), 0.0), 0.0)
