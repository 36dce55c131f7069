"""What a step may have failed from, when the soil itself is not to blame, and what helps.

The numbers are those at which `hybrid.study.failure` has seen runs fail: cases cuts, stretch and weightless.
"""

import numpy as np

from hybrid.soil.domains import cells_wide

CUT = 1e-4      # of the mass of a full node: nodes that carry less have stopped runs
DRAWN = 0.9     # cells that a domain is wide, next to which soil parts,
STRETCHED = 1.05    # if it is stretched at all


def likely(step, evaluation):
    """Text to add to what is told of a failed `step` and its last `evaluation`, if there is one."""
    if step.soil is None:
        return ""
    soil, text = step.model.soil, ""
    left, noise = evaluation and evaluation.norms.get("soil [N]"), rounding(soil, step.pattern.size)
    if left and left < noise:
        text = (f". What is left, {left:.2g} N, is rounding of the stiffness, limit {noise:.2g} N: the forces acting "
                "are too small beside it. Set a looser solver.tolerance, or a lower modulus")
    if step.model.scheme.inertia:
        return text
    mass = step.soil.mass[step.pattern.free.any(axis=1)]
    least = mass.min() / mass.max() if mass.size else 1.0
    if least < CUT and not soil.ghost_factor:
        text += (f". A node of a cell hardly filled carries {least:.1g} of the mass of a full one, limit {CUT:g} "
                 "without inertia: set soil.ghost = 0.033")
    return text + ". Without inertia, this is also how soil ends that cannot carry its load"


def rounding(soil, unknowns):
    """Norm [N] of the forces on so many unknowns that strains of a few times the precision of numbers make."""
    parameters = getattr(soil.law, "parameters", None)
    modulus = soil.law.young if parameters is None else np.maximum(soil.law.young, parameters[:, 0])
    stiffness = np.max(modulus * soil.constants.volume ** (2 / 3), initial=0.0)
    return 10 * np.finfo(float).eps * stiffness * np.sqrt(unknowns)


def drawn_out(model, points):
    """Texts (none or one) about `points` that are stretched until they may part."""
    soil = model.soil
    if model.scheme.inertia or soil.held:
        return ()
    wide = cells_wide(soil.constants.half_width, points.deformation, points.position, soil.grid.axes)
    widest = np.where(np.linalg.norm(points.deformation, axis=2) > STRETCHED, wide, 0.0).max()
    if widest < DRAWN:
        return ()
    return (f"Soil is stretched so far that a point would be {widest:.2g} cells wide, limit {DRAWN:g}, and may part: "
            "give it a larger soil.points_per_axis",)
