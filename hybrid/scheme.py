"""Time integration: one rule for soil nodes, the centre of a body and its rotation in the body frame.

FORMULATION (26) to (27b):

    a_{n+1} = (Δu - Δt v_n)/(βΔt²) - (1/(2β) - 1) a_n           v_{n+1} = v_n + Δt [(1-γ) a_n + γ a_{n+1}]
    (1-αf) v̇_{n+1} + αf v̇_n = (1-αm) a_{n+1} + αm a_n

Equilibrium holds with v̇ at the end of the step for every scheme, so forces are never averaged over a step.

| symbol   | meaning                                                       | soil, rotation     | unit             |
|----------|---------------------------------------------------------------|--------------------|------------------|
| Δu       | increment of the step: displacement or rotation vector Θ      | (N, 3), (3,)       | m, rad           |
| v, v̇     | rate and its true time derivative                             | (N, 3), (3,)       | m/s, m/s²        |
| a        | algorithmic acceleration: v̇ of about (αf - αm) Δt earlier      | (N, 3), (3,)       | m/s², rad/s²     |
| ρ∞       | spectral radius for frequencies far above 1/Δt                | -                  | -                |

| scheme            | αm, αf                    | γ, β                        | order         | high frequencies |
|-------------------|---------------------------|-----------------------------|---------------|------------------|
| newmark           | 0, 0: a is v̇              | given, else 1/2, 1/4        | 2 for γ = 1/2 | damped for γ > 1/2 |
| generalised_alpha | (2ρ∞-1)/(ρ∞+1), ρ∞/(ρ∞+1) | ½ + αf - αm, ¼ (γ + ½)²     | 2             | times ρ∞ a step  |
| energy_momentum   | 0, 0                      | 1/2, 1/4, Cayley rotations  | 2             | kept             |

Only generalised alpha carries a besides v̇. Where it is not known yet, at the start or after a stage with another
scheme, a = v̇. The error of that is O(Δt); it changes v once by O(Δt²), so the scheme stays of second order.

What generalised alpha takes from the forces is p, by the trapezoidal rule, and v follows over the next increments (27b):

    p = v + (½ - αf) Δt (a - v̇)                 p_{n+1} - p_n = Δt (v̇_n + v̇_{n+1})/2

So where Δt changes, a - v̇ changes in inverse proportion (`following`): p stays, and no impulse counts for more or less
than it is. The change of v is O(Δt²) here too. `hybrid.body.motion` describes rotations with energy-momentum.

The default of scenes is generalised alpha with ρ∞ = 0: the only one of these that is of second order and never lets
contact throw a body back faster than it came, however short the contact (DESIGN.md). Bodies that are near nothing they
could touch have ρ∞ = 0.5, which keeps their motion.

Sources: J. Chung and G. M. Hulbert, J. Appl. Mech. 60 (1993) 371-375 (the parameters); M. Arnold and O. Brüls,
Multibody Syst. Dyn. 18 (2007) 185-202 (the form with a); O. Brüls and A. Cardona, J. Comput. Nonlinear Dyn. 5 (2010)
031002 (the same rule on rotations).
"""

import cmath
from dataclasses import dataclass, replace
from typing import Literal

DAMPED = 0.4    # ρ∞ from which on contact rings: bodies and soil throw each other back faster than they came
IN_FLIGHT = 0.5     # ρ∞ of bodies in flight by default; with 0.7, 18 steps in a period of a pendulum gain energy


@dataclass(frozen=True)
class Scheme:
    """β, γ, αm, αf and the map of rotations. inertia: False leaves out every mass term; time then only orders the
    loads. in_flight: Scheme of bodies that nothing is near (`hybrid.step.flight`), None: this one."""

    beta: float = 0.25
    gamma: float = 0.5
    inertia: bool = True
    alpha_m: float = 0.0
    alpha_f: float = 0.0
    rotation: Literal["exponential", "cayley"] = "exponential"
    in_flight: "Scheme | None" = None

    @classmethod
    def of(cls, time):
        """That of a `hybrid.scene.Time`; stages may replace it by a pair of Newmark's parameters."""
        if not time.inertia:
            return cls(inertia=False)
        if time.scheme == "generalised-alpha":
            return cls.default() if time.spectral_radius is None else cls.generalised_alpha(time.spectral_radius)
        return cls.energy_momentum() if time.scheme == "energy-momentum" else cls.newmark(time.beta, time.gamma)

    @classmethod
    def default(cls):
        """Generalised alpha that damps all that contact sets going, and hardly the motion of bodies in flight."""
        return replace(cls.generalised_alpha(0.0), in_flight=cls.generalised_alpha(IN_FLIGHT))

    @classmethod
    def newmark(cls, beta=None, gamma=None):
        """Newmark's rule, (1/4, 1/2) where nothing is given."""
        return cls().with_pair(beta, gamma)

    @classmethod
    def generalised_alpha(cls, rho):
        """Second order with spectral radius `rho` in [0, 1] at high frequencies; 1 damps nothing."""
        alpha_m, alpha_f = (2 * rho - 1) / (rho + 1), rho / (rho + 1)
        gamma = 0.5 + alpha_f - alpha_m
        return cls(0.25 * (gamma + 0.5) ** 2, gamma, alpha_m=alpha_m, alpha_f=alpha_f)

    @classmethod
    def energy_momentum(cls):
        """Newmark's (1/4, 1/2) with rotations that keep energy and angular momentum."""
        return cls(rotation="cayley")

    def with_pair(self, beta=None, gamma=None):
        """Newmark's rule with a value changed for each one given; the others stay those of this scheme if it is
        Newmark's, and are (1/4, 1/2) otherwise. This scheme itself when nothing is given."""
        given = {name: value for name, value in (("beta", beta), ("gamma", gamma)) if value is not None}
        if not given:
            return self
        other = self.auxiliary or self.rotation == "cayley"
        return replace(Scheme(inertia=self.inertia) if other else self, **given)

    @property
    def auxiliary(self):
        """Whether the scheme carries a besides v̇."""
        return self.inertia and (self.alpha_m != 0.0 or self.alpha_f != 0.0)

    @property
    def first_order(self):
        """Whether its error is of the first order in the step."""
        return self.inertia and self.gamma > 0.5 and not self.auxiliary

    @property
    def spectral_radius(self):
        """ρ∞: share of an oscillation far faster than the step that a step leaves, 1 without inertia."""
        if self.auxiliary:
            return self.alpha_f / (1 - self.alpha_f)
        if not self.inertia:
            return 1.0
        a, b, c = self.beta, self.gamma + 0.5 - 2 * self.beta, self.beta - self.gamma + 0.5
        root = cmath.sqrt(b * b - 4 * a * c)
        return max(abs(-b + root), abs(-b - root)) / (2 * a)    # larger root of a λ² + b λ + c

    @property
    def damps(self):
        """Whether oscillations that the step cannot resolve die out within some steps."""
        return self.spectral_radius < DAMPED

    def mass_factor(self, dt):
        """∂v̇/∂Δu [1/s²] at the end of the step."""
        return (1 - self.alpha_m) / ((1 - self.alpha_f) * self.beta * dt**2) if self.inertia else 0.0

    def rate_factor(self, dt):
        """∂v/∂Δu [1/s] at the end of the step."""
        return self.gamma / (self.beta * dt) if self.inertia else 1.0 / dt

    def advance(self, increment, rate, second, algorithmic, dt):
        """(v_{n+1} - v_n, v̇_{n+1}, a_{n+1}) after a step of `dt` [s] with displacement `increment`.

        rate, second, algorithmic: v_n, v̇_n and a_n, all of one shape; an `algorithmic` of None stands for v̇_n, and is
        returned by schemes that do not carry a. Without inertia v_{n+1} is the mean rate of the step.
        """
        if not self.inertia:
            return increment / dt - rate, 0.0 * increment, None
        old = algorithmic if self.auxiliary and algorithmic is not None else second
        new = (increment - dt * rate) / (self.beta * dt**2) - (0.5 / self.beta - 1) * old
        gain = dt * ((1 - self.gamma) * old + self.gamma * new)
        if not self.auxiliary:
            return gain, new, None
        mean = (1 - self.alpha_m) * new + self.alpha_m * old
        return gain, (mean - self.alpha_f * second) / (1 - self.alpha_f), new

    def following(self, second, algorithmic, ratio):
        """a_n for an increment `ratio` times the one that led to v̇_n and a_n, with the same p."""
        return second + (algorithmic - second) / ratio

    def carried(self, second, algorithmic, other):
        """a_n of this scheme from that of an `other` one, of a smooth motion with v̇_n: v̇ of αf - αm steps earlier."""
        return second + (self.alpha_f - self.alpha_m) / (other.alpha_f - other.alpha_m) * (algorithmic - second)

    def __str__(self):
        if not self.inertia:
            return "none, the scene is quasi-static"
        if self.rotation == "cayley":
            return "energy-momentum"
        if self.auxiliary:
            flight = f", of bodies in flight {self.in_flight.spectral_radius:.3g}" if self.in_flight else ""
            return f"generalised-alpha, spectral radius {self.spectral_radius:.3g}{flight}"
        return f"Newmark, beta = {self.beta:g}, gamma = {self.gamma:g}"
