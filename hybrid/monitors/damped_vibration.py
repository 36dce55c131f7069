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
LASTS = 0.1
WORKS = ("plastic", "friction", "ghost", "pull", "drive", "load")
REGULAR = 1.5       # longest over shortest time between them
ALIKE = 1.5         # what is lost over what the scheme takes from an oscillator, at most, or the other way round
SHORTEST = 2.0      # steps in a true period that are looked at
FAINT = 1e-5        # of the energy: less is what the tolerance of Newton's method leaves
RESOLVED = 4.5      # steps in a period: of shorter ones the scheme removes what it is meant to


def lost_by(scheme, period):
    """Share of its swing that an oscillator loses in a `period` [steps] as the scheme has it, longer than it is."""
    steps = np.geomspace(SHORTEST, 2.0 * period, 200)
    seen = [2.0 * np.pi / abs(np.angle(_after_a_step(scheme, each))) for each in steps]
    return 1.0 - abs(_after_a_step(scheme, np.interp(period, seen, steps))) ** period


def _after_a_step(scheme, steps):
    """Factor, a complex number, by which a step of a scheme changes the motion of an oscillator with so many steps in its
    period (Chung & Hulbert, J. Appl. Mech. 60 (1993) 371-375)."""
    w = (2.0 * np.pi / steps) ** 2
    # u, v Δt, a Δt² at the end of a step from those at its begin; rows: balance of momentum, u, v
    alpha_f, alpha_m, beta, gamma = scheme.alpha_f, scheme.alpha_m, scheme.beta, scheme.gamma
    after = np.array([[w * (1.0 - alpha_f), 0.0, 1.0 - alpha_m], [1.0, 0.0, -beta], [0.0, 1.0, -gamma]])
    before = np.array([[-w * alpha_f, 0.0, -alpha_m], [1.0, 1.0, 0.5 - beta], [0.0, 1.0, 1.0 - gamma]])
    values = np.linalg.eigvals(np.linalg.solve(after, before))
    return max(values, key=lambda value: (abs(value.imag) > 0.0, abs(value)))


class DampedVibration(Monitor):
    """Warns once that a regular vibration loses LOST of its swing in a period."""

    def __init__(self, model, state):
        super().__init__(model, state)
        self._works, self._spent = {}, 0.0      # [J] works, and the sum of their changes
        # (step, kinetic energy, error of the balance, that sum [J]) of the last two steps
        self._last = []
        self._peaks = []        # and of the last maxima of the kinetic energy
        self._touching = None   # number of bodies that touch the soil

    def warnings(self, view):
        """Swing lost, steps in a period, limit and remedy."""
        scheme = view.scheme
        if not view.keeps_energy or not scheme.damps or view.model.soil.held or self.given("damped"):
            return
        self._follow(view)
        if len(self._peaks) < PEAKS:
            return
        step, kinetic, error, spent = np.array(self._peaks).T
        gaps, left = np.diff(step), np.clip(1.0 + np.diff(error) / kinetic[:-1], 0.0, 1.0)
        period, lost = 2.0 * gaps.mean(), 1.0 - np.prod(left) ** (1.0 / len(gaps))
        stored = kinetic.max() + view.energy.get("elastic", 0.0) + view.energy.get("contact", 0.0)
        regular = (kinetic[1:] > LASTS * kinetic[:-1]).all() and gaps.max() <= REGULAR * gaps.min()
        regular = regular and kinetic[0] > FAINT * stored
        # and neither jerks of soil that flows nor a vibration that is forced
        regular = regular and (np.diff(spent) < -np.diff(error)).all()
        known = lost_by(scheme, period)         # else it is lost elsewhere, as where contact opens and closes
        alike, lost = known / ALIKE < lost < ALIKE * known, min(lost, known)
        if regular and period >= RESOLVED and lost > LOST and alike:
            yield "damped", (
                f"the time integration damps a vibration with {period:.2g} steps in a period: up to t = "
                f"{view.state.time:.4g} s it loses {lost:.0%} of its swing in each, limit {LOST:.0%}, and takes "
                "longer. That is of use where soil is to settle; where the vibration counts, use half the time.step, or "
                "time.spectral_radius = 0.5")

    def _follow(self, view):
        """Note a maximum of the kinetic energy at the last step; begin afresh where bodies touch or leave the soil."""
        touching = sum(anywhere([len(contact)]) for contact in view.contacts)
        if touching != self._touching:
            self._last, self._peaks, self._touching = [], [], touching
        self._spent += sum(abs(view.energy[name] - self._works.get(name, 0.0)) for name in WORKS)
        self._works = {name: view.energy[name] for name in WORKS}
        now = view.state.step, view.energy["kinetic"], view.energy["error"], self._spent
        if len(self._last) == 2 and self._last[0][1] < self._last[1][1] >= now[1]:
            self._peaks = [*self._peaks, self._last[1]][-PEAKS:]
        self._last = [*self._last, now][-2:]
