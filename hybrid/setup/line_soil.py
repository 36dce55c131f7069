"""Bearing of soil on a pull line that cuts through it, from the material of the scene (Neubecker & Randolph):

    clay    Q = Nc s_u b          sand    Q = Nq γ z b          b = 2.5 d of a chain, d of a wire
"""

from dataclasses import replace

import numpy as np

from hybrid.body.embedded_line import LineSoil
from hybrid.body.symmetry import copies
from hybrid.laws.sand import material_values
from hybrid.runtime.errors import SceneError
from hybrid.scene.soil import as_clay, ends

CHAIN = 2.5     # bearing widths in the diameter of its bars
CLAY = 11.0     # Nc, of the 8.5 to 14 that are used
BURIED = 0.05   # of the depth of the shackle: the far end may lie so much below the ground


def line_through_soil(scene, described, body, motion, mirrors):
    """The body, with the soil that its pull line cuts through where the scene gives that line a diameter; motion: its
    BodyState at the start. Of a body in planes of symmetry, `mirrors`, its part of the line is modelled.

    Raises SceneError where the far end is in the soil: the line is pulled at the mudline, or above it."""
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
    _refuse_buried_end(described, body.line, motion, top)
    return replace(body, line=replace(body.line, soil=LineSoil(
        top, factor * start * width, factor * gradient * width, width, pull.line_friction)))


def _refuse_buried_end(described, line, motion, mudline):
    shackle = motion.position + motion.rotation @ line.attachment
    depth, buried = mudline - shackle[2], mudline - (shackle + line.length * line.direction)[2]
    if buried > BURIED * max(depth, 0.0):
        raise SceneError(
            f"body.pull.direction of {described.name}: the far end of the line, {line.length:g} m from its point, lies "
            f"{buried:.3g} m below the ground at z = {mudline:g} m, limit {BURIED * max(depth, 0.0):.2g} m: a line with a "
            "diameter leaves the soil and is pulled above it. Let direction rise more, or make length longer")
