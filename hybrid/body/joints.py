"""Joints of two bodies, or of a body and the ground: rows of constraints, their gradients and second derivatives.

    point      c_a + s_a - c_b - s_b = 0                        s = R r          ball, hinge, weld
    direction  u_a · w_b = 0                                    two of a hinge, three of a weld
    distance   |d| - L = 0, or L - |d| >= 0                     d = c_a + s_a - c_b - s_b      rod, line
    angle      θ - lower >= 0, upper - θ >= 0, θ - θ_n (friction)      θ = atan2(p_a · q_b, p_a · p_b)     hinge
               (with the multiple of 2π that brings it closest to θ_n, that before the increment)

A row φ with its multiplier λ adds the forces λ ∂φ/∂q to both bodies. λ has bounds: none where φ = 0 always, λ >= 0 of a stop
or a line, |λ| <= M of friction. With t = λ - k φ, k any stiffness,

    lower < t < upper:  φ = 0          else:  λ = the bound that t is beyond

which is complementarity without a penalty. Unknowns of the pair: (δc_a, δφ_a, δc_b, δφ_b), R <- exp(δφ~) R.

| symbol | meaning                                                     | shape | unit |
|--------|-------------------------------------------------------------|-------|------|
| r      | joined point, from the centre in the body frame             | (3,)  | m    |
| u, w   | unit vectors of body frames                                 | (3,)  | -    |
| p, q   | unit vectors across the axis, q_b = axis × p_b              | (3,)  | -    |
| φ, λ   | values of the rows and their multipliers                    | (n,)  | m or rad, N or N m |

Equations: FORMULATION (55) to (58).
"""

from dataclasses import dataclass

import numpy as np

from hybrid.body.attitude import skew

GROUND = (np.zeros(3), np.eye(3))   # pose


@dataclass(frozen=True)
class Joint:
    """Constants of a joint.

    bodies: numbers of the two bodies, None for the ground as the second; points: (2, 3) [m] in their frames, of the ground
    in space; pairs: ((u_a, w_b), ...) of directions that stay perpendicular; at_point: whether the points coincide
    length: [m] of a rod or line, None of others; slack: whether it is a line
    turning: (p_a, p_b, q_b) of a hinge, None of others; limits: (lower, upper) [rad] or None; friction: [N m]
    """

    name: str
    bodies: tuple
    points: np.ndarray
    at_point: bool
    pairs: tuple = ()
    length: float | None = None
    slack: bool = False
    turning: tuple | None = None
    limits: tuple | None = None
    friction: float = 0.0

    @property
    def bounds(self):
        """(n, 2) bounds of the multipliers [N, N m]."""
        always, positive = (-np.inf, np.inf), (0.0, np.inf)
        rows = [always] * (3 * self.at_point + len(self.pairs))
        rows += [positive if self.slack else always] * (self.length is not None)
        rows += [positive] * (2 * (self.limits is not None))
        return np.array(rows + [(-self.friction, self.friction)] * (self.friction > 0)).reshape(-1, 2)

    @property
    def angular(self):
        """(n,) bool, rows that are angles."""
        kinds = [False] * (3 * self.at_point) + [True] * len(self.pairs) + [False] * (self.length is not None)
        return np.array(kinds + [True] * len(self._angles()))

    def angle(self, poses):
        """Angle [rad] of a hinge at two poses."""
        a, p, q = self._directions(poses)
        return float(np.arctan2(a @ q, a @ p))

    def _directions(self, poses):
        (_, turn_a), (_, turn_b) = poses
        return turn_a @ self.turning[0], turn_b @ self.turning[1], turn_b @ self.turning[2]

    def _span(self, poses):
        """(arms (2, 3), d (3,)) [m]."""
        arms = np.array([turn @ point for (_, turn), point in zip(poses, self.points)])
        return arms, poses[0][0] + arms[0] - poses[1][0] - arms[1]

    def rows(self, poses, before=0.0):
        """φ (n,) and ∂φ/∂q (n, 12) at two poses; before: angle [rad] at the start of the increment."""
        arms, span = self._span(poses)
        jacobian = _point_jacobian(arms)
        values, gradients = [], []
        if self.at_point:
            values, gradients = list(span), list(jacobian)
        for u, w in self.pairs:
            u, w = poses[0][1] @ u, poses[1][1] @ w
            values.append(u @ w)
            gradients.append(_of_turns(np.cross(u, w)))
        if self.length is not None:
            sign, distance = (-1.0 if self.slack else 1.0), np.linalg.norm(span)
            values.append(sign * (distance - self.length))
            gradients.append(sign * (span / distance) @ jacobian)
        angles = self._angles()
        if angles:
            turned = self.angle(poses) - before
            theta, (by_turn, _) = before + turned - 2 * np.pi * np.round(turned / (2 * np.pi)), self._turning(poses)
            for sign, at in angles:
                values.append(sign * (theta - (before if at is None else at)))
                gradients.append(sign * _of_turns(by_turn))
        return np.array(values), np.array(gradients)

    def _angles(self):
        """[(sign, angle [rad] at which the row is zero, None for that before the increment)] of the rows of the angle."""
        rows = [] if self.limits is None else [(1.0, self.limits[0]), (-1.0, self.limits[1])]
        return rows + [(1.0, None)] * (self.friction > 0)

    def curvature(self, poses, multipliers):
        """∂(Σ λ ∂φ/∂q)/∂q (12, 12) [N/m, N, N m] with fixed multipliers (n,)."""
        arms, span = self._span(poses)
        out, left = np.zeros((12, 12)), list(multipliers)
        if self.at_point:
            _add_arms(out, arms, np.array(left[:3]))
            left = left[3:]
        for u, w in self.pairs:
            _add_turns(out, left.pop(0) * _change_of_cross(poses[0][1] @ u, poses[1][1] @ w))
        if self.length is not None:
            force = left.pop(0) * (-1.0 if self.slack else 1.0)
            distance = np.linalg.norm(span)
            along, jacobian = span / distance, _point_jacobian(arms)
            out += jacobian.T @ (force / distance * (np.eye(3) - np.outer(along, along))) @ jacobian
            _add_arms(out, arms, force * along)
        if left:
            total = sum(sign * one for (sign, _), one in zip(self._angles(), left))
            _add_turns(out, total * self._turning(poses)[1])
        return out

    def _turning(self, poses):
        """∂θ/∂φ_a (3,), which is -∂θ/∂φ_b, and its derivative (3, 6) by (φ_a, φ_b)."""
        a, p, q = self._directions(poses)
        c, s = a @ p, a @ q
        by_c, by_s = np.cross(a, p), np.cross(a, q)
        square = c * c + s * s
        slope = (c * by_s - s * by_c) / square
        dc, ds = np.concatenate([by_c, -by_c]), np.concatenate([by_s, -by_s])
        change = (np.outer(by_s, dc) + c * _change_of_cross(a, q) - np.outer(by_c, ds) - s * _change_of_cross(a, p)
                  - np.outer(slope, 2.0 * (c * dc + s * ds))) / square
        return slope, change


def _point_jacobian(arms):
    """∂d/∂q (3, 12)."""
    return np.hstack([np.eye(3), -skew(arms[0]), -np.eye(3), skew(arms[1])])


def _of_turns(slope):
    """(12,) gradient of a row by rotations, `slope` (3,) by that of the first body."""
    return np.concatenate([np.zeros(3), slope, np.zeros(3), -slope])


def _change_of_cross(u, w):
    """∂(u × w)/∂(φ_a, φ_b) (3, 6) of u on the first body and w on the second."""
    return np.hstack([skew(w) @ skew(u), -skew(u) @ skew(w)])


def _add_turns(out, change):
    """Add the derivative (3, 6) of a moment on the first body, and its reaction."""
    turns = np.r_[3:6, 9:12]
    out[np.ix_(range(3, 6), turns)] += change
    out[np.ix_(range(9, 12), turns)] -= change


def _add_arms(out, arms, force):
    """Add the derivative of the moments s × F of a constant force on both arms."""
    out[3:6, 3:6] += skew(force) @ skew(arms[0])
    out[9:12, 9:12] -= skew(force) @ skew(arms[1])


def connected(numbers, joints):
    """The `numbers` of bodies, a set, and those of all that joints connect with them, over any others but the ground."""
    while True:
        more = {n for joint in joints if numbers.intersection(joint.bodies) for n in joint.bodies if n is not None}
        if more <= numbers:
            return numbers
        numbers = numbers | more
