"""Contact forces that ring: a scheme that damps nothing keeps what an impact has set off in the finest cells.

The force swings about its mean from step to step, as contact is lost and made again. It is told of where over the last
STEPS steps the force, less a straight line, has a root mean square of LIMIT times its mean and turns TURNS times.
"""

import numpy as np

STEPS, TURNS = 12, 5
LIMIT = 0.6     # half of that is the most in runs of anchors with cells of 0.2 m, 0.53 with 0.4 m


class Ringing:
    """Says once for each body that its contact force rings."""

    def __init__(self):
        self._said, self._forces = set(), {}

    def notes(self, model, state, contacts, scheme):
        """Texts about bodies, by the Contacts that led to `state` with `scheme`."""
        texts = []
        for b, (body, contact) in enumerate(zip(model.bodies, contacts)):
            if b in self._said or scheme.damps or not scheme.inertia:
                continue
            seen = self._forces.setdefault(b, [])
            seen.append(float(np.linalg.norm(contact.force[:3])))
            del seen[:-STEPS]
            swing, turns = _swing(seen) if len(seen) == STEPS else (0.0, 0)
            if swing > LIMIT and turns >= TURNS:
                self._said.add(b)
                texts.append(
                    f"the contact force on {body.name} rings: in the last {STEPS} steps to t = {state.time:.4g} s "
                    f"it swings by {swing:.0%} about its mean, limit {LIMIT:.0%}, and turns {turns} times. Only its "
                    "mean is to be trusted; use a scheme that damps, such as time.beta = 0.5625 and time.gamma = 1, or "
                    "generalised-alpha with time.spectral_radius = 0, or a lower body.penalty")
        return tuple(texts)


def _swing(forces):
    """Root mean square about a straight line over the mean, and how often they turn, of forces (n,)."""
    forces, at = np.array(forces), np.arange(len(forces))
    if not forces.any():
        return 0.0, 0
    away = forces - np.polyval(np.polyfit(at, forces, 1), at)
    turns = np.count_nonzero(np.diff(np.sign(np.diff(forces))))
    return float(np.sqrt(np.mean(away**2)) / forces.mean()), turns
