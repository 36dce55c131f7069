"""Bearing of soil on a pull line that cuts through it, from the material of the scene (Neubecker & Randolph):

    clay    Q = Nc s_u b          sand    Q = Nq γ z b          b = 2.5 d of a chain, d of a wire
"""

from dataclasses import replace

import numpy as np

from hybrid.body.embedded_line import LineSoil
from hybrid.body.symmetry import copies
from hybrid.laws.sand import material_values
from hybrid.scene.soil import as_clay, ends

CHAIN = 2.5     # bearing widths in the diameter of its bars
CLAY = 11.0     # Nc, of the 8.5 to 14 that are used


def line_through_soil(scene, described, body, mirrors):
    """The body, with the soil that its pull line cuts through where the scene gives that line a diameter; of a body in
    planes of symmetry, `mirrors`, its part of the line is modelled."""
    pull, soil = described.pull, scene.soil
    if pull is None or pull.diameter is None:
        return body
    material = as_clay(soil.material)
    values, width = material_values(material), pull.diameter * (CHAIN if pull.chain else 1.0)
    if material.law == "von-mises":
        factor = CLAY if pull.bearing_factor is None else pull.bearing_factor
        start, gradient = values["strength"], values.get("strength_gradient", 0.0)
    else:
        angle = np.radians(values["friction_angle"])
        factor = pull.bearing_factor or np.exp(np.pi * np.tan(angle)) * np.tan(np.pi / 4 + angle / 2) ** 2
        start, gradient = 0.0, values["density"] * np.linalg.norm(scene.gravity)
    factor /= copies(mirrors)
    _, top = ends(soil, scene.grid)
    return replace(body, line=replace(body.line, soil=LineSoil(
        top, factor * start * width, factor * gradient * width, width, pull.line_friction)))
