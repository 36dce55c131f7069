"""Limits of the soil's points, cells and laws."""

import numpy as np

from hybrid.laws.cone import UNLIMITED
from hybrid.scene.material import of_layer

POISSON = 0.45      # from which soil without F-bar locks: locking, locking_cells


def crossing(scene, model):
    """Standard shape functions: the force jumps where a point crosses a face of cells."""
    if scene.soil.basis == "mpm" and not model.soil.held:
        yield ('soil.basis = "mpm": stresses are wrong by their own size once points cross cells; right only for soil '
               'that moves by less than a cell. Set soil.basis = "gimp"')


def domains(scene, model):
    """Domains of points that do not follow the soil when it is stretched, or when it has turned."""
    meaning = {
        "none": "they overlap where soil is squeezed and part where it is drawn out: stresses wrong by 4 % at a "
                "stretch of 1.5, and no equilibrium at 2.5",
        "stretch": "they widen the wrong way once soil has turned: stresses wrong by 1 % of the weight from 60 "
                   "degrees on",
        "diagonal": "they collapse as soil turns: stresses wrong by 1 % of the weight after 30 degrees, 9 % after "
                    "90"}.get(scene.soil.domain)
    if meaning and scene.soil.basis == "gimp" and not model.soil.held:
        yield f'soil.domain = "{scene.soil.domain}": {meaning}. Set soil.domain = "moments"'


def locking(scene, model):
    """Soil that hardly changes its volume does not bend."""
    nu = _poisson(model.soil.law)
    if nu >= POISSON - 1e-9 and not (scene.soil.fbar or model.soil.held):
        yield (f"soil.material.poisson = {nu:g}: without F-bar such soil locks, limit {POISSON:g}; a beam of 4 cells "
               "through its height sags 12 % too little at 0.45, 39 % at 0.49, 86 % at 0.4999. Set soil.fbar = true, "
               "with a little soil.ghost = 0.0033 where it flows")


def flow(scene, model):
    """Plastic flow that keeps its volume locks as soil does that hardly changes it."""
    law = model.soil.law
    if model.soil.held or scene.soil.fbar or not (law.plastic and hasattr(law, "parameters")):
        return
    eta, strength = law.parameters[:, 2], law.parameters[:, 4]
    if np.any((eta == 0.0) & (strength < UNLIMITED)):
        yield ('soil.material.law = "von-mises": flow that keeps its volume locks without F-bar, and loads at collapse '
               "come out too high: of a footing by 14 % with 8 cells in half its width, 23 % with 4 and 39 % with 2, "
               "limit 5 %. Set soil.fbar = true and a little soil.ghost = 0.0033")


def softening(scene, model):
    """Softening gathers in one row of cells."""
    law = model.soil.law
    if model.soil.held or not getattr(law, "hardens", False) or law.parameters[:, 6].min() >= 0.0:
        return
    at = int(np.argmin(law.parameters[:, 6]))
    strength, slope, residual = law.parameters[at, [4, 6, 7]]
    cell = model.soil.grid.smallest_cell
    modulus = min(m.hardening or 0.0 for m in materials(scene.soil))
    yield (f"soil.material.hardening = {modulus:g} Pa: softening, limit 0, gathers in bands one cell wide; strength is "
           f"gone after a slip of {(strength - residual) / -slope * cell:.2g} m in cells of {cell:g} m, and of half as "
           "much in cells half as large. Choose hardening for this size of cells, and change it in proportion to them")


def materials(soil):
    """soil.material and those of the layers of a described soil."""
    return [soil.material, *(of_layer(soil.material, layer) for layer in soil.layers)]


def _poisson(law):
    """Largest Poisson's ratio of a law's points; 0 of a user's law, which does not tell."""
    parameters = getattr(law, "parameters", None)
    if parameters is None or not len(parameters):
        return 0.0
    bulk, shear = parameters[:, 0], parameters[:, 1]
    return float(((3 * bulk - 2 * shear) / (6 * bulk + 2 * shear)).max())


LIMITS = (crossing, domains, locking, flow, softening)
