"""Energy of a committed state and the balance of a run.

    stored = kinetic + elastic + potential + contact springs + line
    stored(t) - stored(0) + plastic + friction + left = work of pull, drive and load + error

Kinetic energy is that of points and bodies, none in a quasi-static scene; what the transfer between points and grid
loses shows in the error. Drive is the work of guides: of driven components, and of the jolt when a stage holds a body
that moves or sets off one that rests. Load is all but the whole of gravity (`hybrid.system.loads`). Left is what soil
takes with it that a travelling grid leaves behind or joins to larger points (`hybrid.travel`).
"""

import numpy as np

from hybrid.body import rigid
from hybrid.reductions import total

STORED = ("kinetic", "elastic", "potential", "contact", "line")
WORKS = ("plastic", "friction", "pull", "drive", "load", "left")


def energies(model, state, evaluation=None):
    """Dict of energies and works [J]; contact and line energy come from the evaluation that led to `state`."""
    soil, points = model.soil, state.points
    out = dict.fromkeys(STORED, 0.0)
    inertia = model.scheme.inertia
    if not soil.held:
        out |= of_soil(model, points)
    for body, motion in zip(model.bodies, state.bodies):
        out["kinetic"] += rigid.kinetic_energy(body, motion) * inertia
        out["potential"] -= body.mass.mass * float(motion.position @ model.gravity)
    if evaluation is not None:
        out["contact"] = sum(c.energy for c in evaluation.contacts)
        out["line"] = sum(t.line_energy for t in evaluation.body_trials)
    return out | {name: state.work.get(name, 0.0) for name in WORKS}


def of_soil(model, points):
    """Kinetic, elastic and potential energy [J] of points."""
    soil, mass = model.soil, model.soil.constants.mass
    kinetic = 0.5 * float(total(mass * np.sum(points.velocity**2, axis=1)))
    return {"kinetic": kinetic * model.scheme.inertia, "elastic": soil.stored_energy(points),
            "potential": -float(total(mass * ((points.position - soil.constants.position) @ model.gravity)))}


def balance_error(now, start):
    """Energy that the balance does not account for [J], from `energies` now and at the start."""
    stored = sum(now[name] - start[name] for name in STORED)
    return stored + now["plastic"] + now["friction"] + now["left"] - now["pull"] - now["drive"] - now["load"]


class Gain:
    """Says once each when there is energy out of nothing, and when a step loses most of it without being asked to, as
    happens where an impact falls into one step."""

    LIMIT = 0.25    # of the most that ever was kinetic, elastic and in contact springs
    LOSS = 0.5      # of the same, in one step; 0.3 is the most in 200 runs whose steps resolve contact

    def __init__(self):
        self._said, self._lost, self._held, self._before = False, False, 0.0, 0.0

    def notes(self, time, energy, damped=False):
        """Texts (none or one) about the state at `time` [s]; energy: `energies` with their "error"; damped: whether the
        scheme is meant to lose some, or time is only the order of events."""
        gain, loss = energy["error"], self._before - energy["error"]
        self._before = gain
        self._held = held = max(self._held, energy["kinetic"] + energy["elastic"] + energy["contact"])
        if not self._said and gain > self.LIMIT * held > 0:
            self._said = True
            return (f"energy out of nothing: at t = {time:.4g} s there are {gain:.3g} J too many, {gain / held:.0%} of "
                    f"what moves, soil and contact hold (limit {self.LIMIT:.0%}). {_REMEDY}",)
        if not self._lost and not damped and loss > self.LOSS * held > 0:
            self._lost = True
            return (f"energy into nothing: in the step to t = {time:.4g} s {loss:.3g} J are lost, {loss / held:.0%} of "
                    f"what moves, soil and contact hold (limit {self.LOSS:.0%}). {_REMEDY}",)
        return ()


_REMEDY = ("Contact comes and goes faster than the step resolves; use a smaller time.step, time.accuracy = 1e-3, a "
           "lower body.penalty, or a scheme that damps")
