"""The soil's terms in the equations of one increment: FORMULATION (1), its first row.

    R_u = f_int + m a - m b + Σ contact        on the free nodal unknowns        [N]

b are all loads on the points, gravity included.
"""

from dataclasses import dataclass

import numpy as np

from hybrid.runtime import comm
from hybrid.runtime.timing import phase
from hybrid.soil import closing
from hybrid.soil.lost_points import list_points
from hybrid.soil.model import INSIDE_OUT, NO_STRESS, Refusal, SoilTrial

ROUNDING = 1e-14  # relative, of positions and increments: forces that this alone explains are not residual
STILL = 1e-9    # cells that a force moves a point by in an increment: none


@dataclass(frozen=True)
class SoilTerms:
    """Terms at trial displacements: the trial of the soil, `Scheme.advance` of the nodes, and forces (N, 3) [N] by
    name, of which "contact" is added by the bodies. Of a Refusal, only contact."""

    trial: SoilTrial | Refusal
    rates: tuple
    forces: dict


def begin(model, state, dt, workspace):
    """SoilStep of an increment of `dt` [s] from a committed State; workspace: a SoilWorkspace. Raises StepError as
    `Soil.begin` does."""
    soil = model.soil
    load = model.loads.on_points(state.time + dt, soil.constants.position)
    gravity = np.linalg.norm(model.loads.on_bodies(state.time + dt))
    touching = [contact.point[contact.touching & (contact.point >= 0)] for contact in state.contacts]
    points = closing.shared(state.points, soil, gravity, dt,
                            np.concatenate([np.zeros(0, np.int64), *touching]))
    return soil.begin(points, load, workspace)


def evaluate(step, displacement, keep=None):
    """SoilTerms of this process's points at nodal increments (N, 3) [m]; keep: an earlier SoilTrial that stays valid."""
    with phase("soil"):
        trial = step.model.soil.evaluate(step.soil, displacement, keep)
    contact = np.zeros_like(displacement)
    if isinstance(trial, Refusal):
        return SoilTerms(trial, (), {"contact": contact})
    rates = step.model.scheme.advance(displacement, *step.soil.history, step.dt)
    return SoilTerms(trial, rates, {
        "internal": trial.force, "weight": -step.soil.weight, "inertia": step.soil.mass[:, None] * rates[1],
        "contact": contact})


def refusal(terms):
    """Refusal of any process, in all of them; None where each has a SoilTrial. Processes wait for one another here, after
    soil and contact: no one of them is the slowest in both."""
    own = terms.trial if isinstance(terms.trial, Refusal) else Refusal("")
    reasons = "", NO_STRESS, INSIDE_OUT
    reason = reasons[int(comm.largest([reasons.index(own.reason)]))]
    points = np.asarray(own.points if own.reason == reason else (), np.int64)
    return Refusal(f"{reason} {list_points(points)}", points) if reason else None


def add_up(grid, terms, with_contact):
    """Give nodes the forces of the points of all processes, in one exchange: in place."""
    if grid.nodes is None:
        return
    forces = [terms.forces[name] for name in ("internal", "contact")[:1 + with_contact]]
    every = grid.summed(np.concatenate(forces, axis=1))
    for i, force in enumerate(forces):
        force[:] = every[:, 3 * i:3 * i + 3]


def residual(step, terms, displacement, springs):
    """Residual (n,) [N] on the free unknowns, norms [N] of the internal forces and of the residual, and the error, which
    is relative to the largest of the terms.

    The terms include the internal forces that the increment starts with, `Step.reference`: where soil loses its contact
    without inertia, all other terms vanish. The round-off of the stiffness is no error without any external force, nor where
    it moves nothing: the forces of weightless soil that comes to rest are as small.

    springs: [N/m] stiffness of the contact, by body.
    """
    free, grid = step.pattern.free, step.model.soil.grid
    own = grid.own_unknowns(free)
    parts = [force[free] for force in terms.forces.values()]
    left = sum(parts)
    norms = {name: comm.norm(part[own]) for name, part in zip(terms.forces, parts)}
    norm, scale = comm.norm(left[own]), max(step.reference, *norms.values())
    inertia = step.model.scheme.mass_factor(step.dt) * comm.norm((step.soil.mass[:, None] * displacement)[free][own])
    noise = ROUNDING * (inertia + np.abs(grid.extent).max() * sum(springs))
    of_stiffness = step.model.soil.roundoff_force(grid.count_unknowns(free))
    nothing = STILL * grid.smallest_cell * comm.minimum(step.model.soil.constants.mass)
    if of_stiffness <= nothing * step.model.scheme.mass_factor(step.dt) or not any(
            value for name, value in norms.items() if name != "internal"):
        noise += of_stiffness
    return left, norms["internal"], norm, max(norm - noise, 0.0) / scale if scale > 0 else 0.0


def add_tangent(step, trial, error, elastic):
    """Fill the soil block with stiffness and inertia; error: relative residual at the trial; elastic: share [-] of the
    elastic tangent in the stiffness of soil that yields."""
    pattern, values = step.pattern, step.system.values
    with phase("assemble"):
        step.model.soil.fill_stiffness(step.soil, trial, pattern, values, error, elastic)
        mass = np.repeat(step.soil.mass[:, None], 3, axis=1)[pattern.free]
        own = step.model.soil.grid.own_unknowns(pattern.free)     # each process adds its own nodes' mass
        values[pattern.diagonal[own]] += step.model.scheme.mass_factor(step.dt) * mass[own]
