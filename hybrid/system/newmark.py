"""Newmark's rule for translations, and what it becomes when a scene has no inertia.

    a = (Δu - Δt v_n) / (β Δt²) - (1/(2β) - 1) a_n          v = v_n + Δt [(1-γ) a_n + γ a]
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Newmark:
    """β, γ; `inertia` False leaves out every mass term, so that time is only the order of events."""

    beta: float = 0.25
    gamma: float = 0.5
    inertia: bool = True

    def mass_factor(self, dt):
        """∂a/∂Δu [1/s²]."""
        return 1 / (self.beta * dt**2) if self.inertia else 0.0

    def acceleration(self, increment, velocity, acceleration, dt):
        """a at the end of the step [m/s²]."""
        if not self.inertia:
            return 0.0 * increment
        return (increment - dt * velocity) / (self.beta * dt**2) - (0.5 / self.beta - 1) * acceleration

    def velocity_gain(self, increment, velocity, acceleration, new_acceleration, dt):
        """v - v_n [m/s]; without inertia the mean velocity of the step replaces the old one."""
        if not self.inertia:
            return increment / dt - velocity
        return dt * ((1 - self.gamma) * acceleration + self.gamma * new_acceleration)
