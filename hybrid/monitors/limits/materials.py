"""Material of the soil at a height, and whether clay stays attached to a body."""

from dataclasses import replace

import numpy as np

from hybrid.laws.sand import material_values
from hybrid.laws.user import is_of_user
from hybrid.monitors.limits.start import top_of
from hybrid.runtime.comm import maximum
from hybrid.scene.soil import FRICTIONAL, NUMBERS, as_clay, of_layer, within

CLAY, SAND = "von-mises", FRICTIONAL
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


def stays_attached(body, soil):
    """Whether clay never breaks away from a body."""
    tension = body.interface.tension if body.interface is not None else 0.0
    if is_of_user(soil.law) or np.isinf(tension):
        return np.isinf(tension)
    return tension > UNBROKEN * maximum(np.where(soil.law.undrained, soil.law.shear_strength(0.0), 0.0), 0.0)
