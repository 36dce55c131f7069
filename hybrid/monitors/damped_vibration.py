"""Vibrations that the time integration damps although the steps resolve them, which is no error where soil is to settle.

A scheme that removes in some steps what it cannot resolve takes energy from slow vibrations as well. A column of soil under
sudden gravity, the default scheme, share of its swing lost in a period:

| steps in a period  | 5    | 16   | 32  |
|--------------------|------|------|-----|
| lost               | 67 % | 12 % | 2 % |
| period too long by | 36 % | 5 %  | 1 % |

The kinetic energy of a vibration has two maxima in a period. From one to the next, what the balance of energy lacks is
what the scheme took.
"""

import numpy as np

from hybrid.monitors.monitor import Monitor
from hybrid.runtime.comm import anywhere

LOST = 0.1          # of a swing, in a period
PEAKS = 4           # maxima of the kinetic energy in a row, each at least LASTS times the one before
LASTS = 0.2
REGULAR = 1.5       # longest over shortest time between them
RESOLVED = 10.0     # steps in a period: of shorter ones the scheme removes what it is meant to


class DampedVibration(Monitor):
    """Warns once that a regular vibration loses LOST of its swing in a period."""

    def __init__(self, model, state):
        super().__init__(model, state)
        # (step, kinetic energy, error of the balance, dissipated work [J]) of the last two steps,
        self._last = []
        self._peaks = []        # and of the last maxima of the kinetic energy
        self._touching = None   # number of bodies that touch the soil

    def warnings(self, view):
        """Swing lost, steps in a period, limit and remedy."""
        scheme = view.scheme
        if not scheme.inertia or scheme.first_order or not scheme.damps or view.model.soil.held or self.given("damped"):
            return
        self._follow(view)
        if len(self._peaks) < PEAKS:
            return
        step, kinetic, error, spent = np.array(self._peaks).T
        gaps, left = np.diff(step), np.clip(1.0 + np.diff(error) / kinetic[:-1], 0.0, 1.0)
        period, lost = 2.0 * gaps.mean(), 1.0 - np.prod(left) ** (1.0 / len(gaps))
        regular = (kinetic[1:] > LASTS * kinetic[:-1]).all() and gaps.max() <= REGULAR * gaps.min()
        regular = regular and (np.diff(spent) < -np.diff(error)).all()      # and not jerks of soil that flows
        if regular and period >= RESOLVED and lost > LOST:
            yield "damped", (
                f"the time integration damps a vibration with {period:.2g} steps in a period: up to t = "
                f"{view.state.time:.4g} s it loses {lost:.0%} of its swing in each, limit {LOST:.0%}, and takes longer. "
                "Where soil is to settle that is of use; where the vibration counts, use half the time.step, or "
                "time.spectral_radius = 0.8")

    def _follow(self, view):
        """Note a maximum of the kinetic energy at the last step; begin afresh where bodies touch or leave the soil."""
        touching = sum(anywhere([len(contact)]) for contact in view.contacts)
        if touching != self._touching:
            self._last, self._peaks, self._touching = [], [], touching
        spent = sum(view.energy[name] for name in ("plastic", "friction", "ghost"))
        now = view.state.step, view.energy["kinetic"], view.energy["error"], spent
        if len(self._last) == 2 and self._last[0][1] < self._last[1][1] >= now[1]:
            self._peaks = [*self._peaks, self._last[1]][-PEAKS:]
        self._last = [*self._last, now][-2:]
