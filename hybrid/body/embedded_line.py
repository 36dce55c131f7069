"""Pull line whose lower end runs through soil from the mudline to a body: force and angle at the shackle in closed form.

Along a line without weight the soil bears with Q across it and rubs with μ Q along it; s runs from the shackle to the
mudline:

    T dθ/ds = -Q      dT/ds = μ Q      dz/ds = -sin θ      =>      T = T_m exp(μ (θ_m - θ))

    T_m exp(μ θ_m) [ G(θ_a) - G(θ_m) ] = ∫_0^z Q dz      G(θ) = -exp(-μ θ) (cos θ + μ sin θ) / (1 + μ²)

For small angles this is T_a (θ_a² - θ_m²) = 2 z Q (Neubecker & Randolph, J. Geotech. Eng. 121 (1995) 787-803).

| symbol   | meaning                                                                       | unit |
|----------|-------------------------------------------------------------------------------|------|
| z        | depth of the shackle below the mudline                                        | m    |
| T, θ     | tension, and angle above the horizontal; a: at the shackle, m: at the mudline | N, - |
| Q        | bearing on a metre of line, (q0 + q1 z) min(1, z/b)                           | N/m  |
| b        | bearing width of the line                                                     | m    |

The line is elastic between its ends, T_m = k (l - l0) with l their distance, and leaves the mudline towards its far end.
θ_a is at most a right angle: soil that would bend it farther carries the rest. Above the mudline the line is straight.

Equations: FORMULATION (37a).
"""

import math
from dataclasses import dataclass

import numpy as np

from hybrid.body.attitude import skew
from hybrid.body.line import line_force

BISECTIONS = 60     # of the angle at the shackle, to round-off
STEEPEST = 0.5 * math.pi
SHALLOW = 0.02      # angle [-] below which a line is not drawn: it comes up to the mudline asymptotically


@dataclass(frozen=True)
class LineSoil:
    """mudline [m], height of the ground; bearing q0 [N/m] and gradient q1 [N/m²] of it with the depth; width b [m]; friction
    μ [-] along the line over bearing."""

    mudline: float
    bearing: float
    gradient: float
    width: float
    friction: float

    def __str__(self):
        start = f"{self.bearing:.4g} N/m" if self.bearing else ""
        rise = f"{self.gradient:.4g} N/m a metre of depth" if self.gradient else ""
        return (f"bearing of {' and '.join(filter(None, (start, rise)))}, width {self.width:.3g} m, friction "
                f"{self.friction:g}, below z = {self.mudline:g} m")

    def load(self, depth):
        """(∫ Q dz [N], Q [N/m]) at a depth [m]."""
        q0, q1, b = self.bearing, self.gradient, self.width
        z = min(depth, b)
        total, q = (0.5 * q0 + q1 * z / 3) * z**2 / b, (q0 + q1 * z) * z / b
        if depth > b:
            total, q = total + q0 * (depth - b) + 0.5 * q1 * (depth**2 - b**2), q0 + q1 * depth
        return total, q


def shackle(tension, angle, load, friction):
    """(Tension [N], angle [-]) at the shackle for those at the mudline; load: ∫ Q dz [N] down to its depth."""
    def carried(steep):
        return tension * math.exp(friction * angle) * (_g(steep, friction) - _g(angle, friction))

    low, high = angle, STEEPEST
    if carried(high) > load:
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if carried(middle) < load else (low, middle)
    return tension * math.exp(friction * (angle - high)), high


def line_ends(position, rotation, attachment, target, length, stiffness, soil):
    """Pull [N] and angle [-] at the mudline, tension [N] and angle at the shackle, of a line through soil (LineSoil);
    arguments as those of `line_force`."""
    place = position + rotation @ attachment
    span, depth = place - target, soil.mudline - place[2]
    across, pull = math.hypot(span[0], span[1]), max(0.0, stiffness * (math.sqrt(span @ span) - length))
    if depth <= 0.0 or pull == 0.0 or across <= 1e-9 * length:      # straight, as in `embedded_line_force`
        angle = math.atan2(-span[2], across)
        return pull, angle, pull, angle
    angle = math.atan2(max(0.0, target[2] - soil.mudline), across)
    return pull, angle, *shackle(pull, angle, soil.load(depth)[0], soil.friction)


def shape_in_soil(pull, angle, depth, soil):
    """Places (n, 2) of a line: distance from the shackle and height [m], from there up to where it is flatter than SHALLOW
    or reaches the mudline, for a pull [N] and angle [-] there; dx = dz / tan θ."""
    z = np.linspace(depth, 0.0, 200)
    steep = np.array([shackle(pull, angle, soil.load(each)[0], soil.friction)[1] for each in z])
    z, steep = z[steep > SHALLOW], steep[steep > SHALLOW]
    cotangent = 1.0 / np.tan(steep)
    x = np.concatenate([[0.0], np.cumsum(-0.5 * np.diff(z) * (cotangent[1:] + cotangent[:-1]))])
    return np.column_stack([x, soil.mudline - z])


def _g(angle, friction):
    return -math.exp(-friction * angle) * (math.cos(angle) + friction * math.sin(angle)) / (1 + friction**2)


def embedded_line_force(position, rotation, attachment, target, length, stiffness, soil):
    """Tension at the shackle, residual, tangent and energy of a line through soil (LineSoil); arguments and results as those
    of `line_force`. Its energy is zero: the work of the pull is that on the body (`hybrid.step.work`)."""
    arm = rotation @ attachment
    place = position + arm
    tension, residual, tangent, _ = line_force(position, rotation, attachment, target, length, stiffness)
    depth = soil.mudline - place[2]
    span = place - target
    across = math.hypot(span[0], span[1])
    if tension == 0.0 or depth <= 0.0 or across <= 1e-9 * length:
        return tension, residual, tangent, 0.0
    load, q = soil.load(depth)
    rise = max(0.0, target[2] - soil.mudline)
    angle = math.atan2(rise, across)
    pull, steep = shackle(tension, angle, load, soil.friction)
    flat = np.array([-span[0] / across, -span[1] / across, 0.0])
    up, sine, cosine = np.array([0.0, 0.0, 1.0]), math.sin(steep), math.cos(steep)

    # derivatives by the place of the shackle (3,)
    d_tension = stiffness * span / math.sqrt(span @ span)
    d_angle = rise / (rise**2 + across**2) * flat
    share = load / tension
    d_steep = np.zeros(3)
    if steep < STEEPEST:
        d_steep = (-q * up - share * d_tension
                   - (soil.friction * load - tension * math.sin(angle)) * d_angle) / (pull * sine)
    d_pull = pull / tension * d_tension - soil.friction * pull * (d_steep - d_angle)
    d_flat = -(np.diag([1.0, 1.0, 0.0]) - np.outer(flat, flat)) / across
    by_point = -(np.outer(cosine * flat + sine * up, d_pull) + pull * np.outer(cosine * up - sine * flat, d_steep)
                 + pull * cosine * d_flat)
    force = -pull * (cosine * flat + sine * up)

    jacobian = np.hstack((np.eye(3), -skew(arm)))
    tangent = jacobian.T @ by_point @ jacobian
    tangent[3:, 3:] += skew(force) @ skew(arm)
    return pull, jacobian.T @ force, tangent, 0.0
