"""Contact forces that oscillate: a scheme that does not damp keeps what an impact has set off in the finest cells.

The force then oscillates about its mean from step to step, as contact opens and closes. The warning is given when, over
the last STEPS steps, the root mean square deviation of the force from a straight line exceeds LIMIT times its mean and
the force changes its direction at least REVERSALS times, or when contact is lost LOSSES times in the last LONG steps: a
stiff contact is closed for single steps only.

Without inertia the force on a body that is driven evenly scatters where a step has more than one answer: sand of φ = 30 to
45° and ψ = 0 or 5° under a strip, beyond failure, 8 cells in half of it, gave loads 4 to 30 % apart by two ways of
shortening Newton's updates, both converged, and scattered by 4 to 7 % from step to step; ψ = φ by less than 3 %.
"""

import numpy as np

from hybrid.monitors.monitor import Monitor

STEPS, REVERSALS = 12, 5
LONG, LOSSES = 48, 3
SCATTER, TURNS = 0.04, 4    # without inertia, with so many reversals; 0.02 and less in clay, in soil that dilates, of cones
LIMIT = 0.6     # half of that is the most in runs of anchors with cells of 0.2 m, 0.53 with 0.4 m


class ForceOscillation(Monitor):
    """Warns once for each body that its contact force oscillates."""

    def __init__(self, model, state):
        super().__init__(model, state)
        self._forces = {}       # body -> magnitudes of its contact force in the last LONG steps [N]
        self._rates = {}        # body -> its driven rates [m/s, rad/s] in the last step without inertia

    def warnings(self, view):
        """Body, deviation, limit and remedy."""
        if not view.scheme.inertia:
            yield from self._scatter(view)
        if view.scheme.damps or not view.scheme.inertia:
            return
        for b, body, _, contact in view.bodies:
            if self.given(b):
                continue
            forces = self._forces.setdefault(b, [])
            forces.append(float(np.linalg.norm(contact.resultant[:3])))
            del forces[:-LONG]
            if found := _found(forces):
                yield b, (f"the contact force on {body.name} oscillates: up to t = {view.state.time:.4g} s {found}. Only "
                          "its mean is reliable. Leave out time.scheme, as the default damps, or use a lower "
                          "body.penalty")


    def _scatter(self, view):
        """The same of bodies that have been driven evenly in the last STEPS steps, without inertia."""
        for b, body, motion, contact in view.bodies:
            rates = np.concatenate([motion.velocity, motion.spin])[body.driven].tolist()
            if not any(rates) or self.given(b) or not view.model.soil.law.plastic or view.model.soil.held:
                continue
            if not np.allclose(rates, self._rates.get(b, [np.inf] * len(rates)), rtol=1e-6, atol=0.0):
                self._rates[b], self._forces[b] = rates, []
            forces = self._forces[b]
            forces.append(float(np.linalg.norm(contact.resultant[:3])))
            del forces[:-STEPS]
            deviation, reversals = scatter(forces) if len(forces) == STEPS else (0.0, 0)
            if deviation > SCATTER and reversals >= TURNS:
                yield b, (f"the contact force on {body.name}, which is driven evenly, scatters: up to t = "
                          f"{view.state.time:.4g} s it deviates by {deviation:.0%} from one step to the next (root mean "
                          f"square, last {STEPS} steps), limit {SCATTER:.0%}. Take means over several steps: a step may "
                          "have more than one answer where soil dilates far less than its friction angle, or where it "
                          "parts from the body and comes back")


def _found(forces):
    """What is found in the last forces [N], with its limit, as a clause; empty where nothing is."""
    deviation, reversals = oscillation(forces[-STEPS:]) if len(forces) >= STEPS else (0.0, 0)
    if deviation > LIMIT and reversals >= REVERSALS:
        return (f"it deviates by {deviation:.0%} from its mean (root mean square, last {STEPS} steps), limit "
                f"{LIMIT:.0%}, and reverses {reversals} times")
    in_contact = np.array(forces) > 0.0
    losses = np.count_nonzero(in_contact[:-1] & ~in_contact[1:])
    return f"contact is lost {losses} times in {len(forces)} steps, limit {LOSSES - 1}" if losses >= LOSSES else ""


def oscillation(forces):
    """(Root mean square deviation from a straight line over the mean [-], number of reversals) of forces (n,) [N]."""
    forces, step = np.array(forces), np.arange(len(forces))
    if not forces.any():
        return 0.0, 0
    deviation = forces - np.polyval(np.polyfit(step, forces, 1), step)
    reversals = np.count_nonzero(np.diff(np.sign(np.diff(forces))))
    return float(np.sqrt(np.mean(deviation**2)) / forces.mean()), reversals


def scatter(forces):
    """(Root mean square of what alternates in forces (n,) [N], over their mean [-], number of reversals): second differences
    over √6, which is the deviation of independent ones, and next to nothing of a smooth curve."""
    forces = np.array(forces)
    if not forces.any():
        return 0.0, 0
    return float(np.sqrt(np.mean(np.diff(forces, 2) ** 2) / 6.0) / forces.mean()), oscillation(forces)[1]
