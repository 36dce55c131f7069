"""Energy of a committed state and the balance of a run: FORMULATION (51).

    stored = kinetic + elastic + potential + contact springs + line
    stored(t) - stored(0) + plastic + friction + ghost + left + stop = work of pull, drive and load + error

Ghost is the work of the ghost penalty, which resists increments and stores nothing. Kinetic energy is that of points and
bodies, none in a quasi-static scene; the energy that the transfer between points and grid loses is part of the error.
Drive is the work of guides: of driven components, and of the impulse when a stage holds a body that moves or drives one
that rests. Stop, of scenes with joints, is the kinetic energy lost where stops and lines engage. Load is the work of all
loads but the whole of gravity (`hybrid.step.loads`, `hybrid.body.guides`). Left is the energy of points that become inactive
(`hybrid.soil.lost_points`), of soil that a moving grid leaves behind, and what is lost where it merges points
(`hybrid.step.moving_grid`).
"""

import numpy as np

from hybrid.body import rigid
from hybrid.runtime.comm import total

STORED = ("kinetic", "elastic", "potential", "contact", "line")
WORKS = ("plastic", "friction", "ghost", "pull", "drive", "load", "left")


def energies(model, state, evaluation=None):
    """Dict of energies and works [J]; contact and line energy come from the evaluation that led to `state`."""
    soil, points = model.soil, state.points
    out = dict.fromkeys(STORED, 0.0)
    inertia = model.scheme.inertia
    if not soil.held:
        out |= soil_energies(model, points)
    for body, motion in zip(model.bodies, state.bodies, strict=True):
        out["kinetic"] += rigid.kinetic_energy(body, motion) * inertia
        out["potential"] -= body.mass.mass * float(motion.position @ model.gravity)
    if evaluation is not None:
        out["contact"] = sum(terms.contact.energy for terms in evaluation.bodies)
        if evaluation.pairs:
            out["contact"] += evaluation.pairs.energy
        out["line"] = sum(terms.trial.line_energy for terms in evaluation.bodies)
    stop = {"stop": state.work["stop"]} if "stop" in state.work else {}
    return out | {name: state.work.get(name, 0.0) for name in WORKS} | stop


def soil_energies(model, points):
    """Kinetic, elastic and potential energy [J] of points, but for inactive ones."""
    soil, mass = model.soil, points.of_active(model.soil.constants.mass)
    kinetic = 0.5 * float(total(mass * np.sum(points.velocity**2, axis=1)))
    return {"kinetic": kinetic * model.scheme.inertia, "elastic": soil.stored_energy(points),
            "potential": -float(total(mass * ((points.position - soil.constants.position) @ model.gravity)))}


def balance_error(now, start):
    """Energy that the balance does not account for [J], from `energies` now and at the start."""
    stored = sum(now[name] - start[name] for name in STORED)
    lost = sum(now[name] for name in ("plastic", "friction", "ghost", "left"))
    lost += now.get("stop", 0.0)
    return stored + lost - sum(now[name] for name in ("pull", "drive", "load"))
