"""Inertia of one rigid body under Newmark's rule, with its exact tangent.

    a = (Δc - Δt v_n)/(βΔt²) - (1/(2β) - 1) a_n             v = v_n + Δt[(1-γ) a_n + γ a]
    A = (Θ  - Δt W_n)/(βΔt²) - (1/(2β) - 1) A_n             W = W_n + Δt[(1-γ) A_n + γ A]
    residual = [ m a ,  R τ ]        τ = J A + W × J W      Θ = log(R_n^T R)

| symbol | meaning                                                      | shape  | unit         |
|--------|--------------------------------------------------------------|--------|--------------|
| c, R   | trial centre of mass and rotation (body frame to space)      | (3,), (3, 3) | m, -   |
| v, a   | velocity and acceleration of the centre, in space            | (3,)   | m/s, m/s²    |
| W, A   | spin and spin rate, in the body frame                        | (3,)   | rad/s, rad/s² |
| Θ      | rotation of this step, in the body frame, |Θ| < π            | (3,)   | rad          |
| J      | inertia about the centre, in the body frame                  | (3, 3) | kg m²        |
| τ      | moment of inertia forces about the centre, in the body frame | (3,)   | N m          |

The unknowns are (δc, δφ) with c <- c + δc and R <- exp(δφ~) R, so δφ is a vector of space; in the body
frame it is δΦ = R^T δφ. As R^T δΘ enters through the right tangent, δΘ = T^-1 δΦ, the tangent is (Simo and
Wong 1991, sec. 4)

    K = [ J/(βΔt²) + γ/(βΔt) (W̃ J - (J W)~) ] T^-1           δ(R τ) = ( R K R^T - (R τ)~ ) δφ

Frozen during a step: the committed BodyState, m and J. A step must turn the body by less than half a turn,
because the logarithm cannot tell Θ from Θ - 2π; contact and pull line ask for far smaller steps than that.
"""

import numpy as np

from hybrid.body.attitude import log_so3, right_tangent, skew


def _newmark(increment, rate, second, dt, beta, gamma):
    """Rate and second rate at the end of a step that moved by `increment`; all (3,)."""
    new_second = (increment - dt * rate) / (beta * dt * dt) - (0.5 / beta - 1.0) * second
    return rate + dt * ((1.0 - gamma) * second + gamma * new_second), new_second


def updated(state, position, rotation, dt, beta, gamma):
    """Rates at the end of the step from committed `state` to trial `position` (3,) [m] and `rotation` (3, 3).

    Returns (velocity, acceleration, spin, spin_rate), each (3,): the first two in space [m/s, m/s²], the
    last two in the body frame [rad/s, rad/s²].
    """
    velocity, acceleration = _newmark(
        position - state.position, state.velocity, state.acceleration, dt, beta, gamma)
    turn = log_so3(state.rotation.T @ rotation)
    spin, spin_rate = _newmark(turn, state.spin, state.spin_rate, dt, beta, gamma)
    return velocity, acceleration, spin, spin_rate


def inertia_residual(mass, inertia, state, position, rotation, dt, beta, gamma):
    """Inertia force and moment of one body, and their derivative.

    mass [kg]; inertia (3, 3) [kg m²] about the centre in the body frame; state the committed BodyState;
    position (3,) and rotation (3, 3) the trial motion; dt [s]. Returns residual (6,) = [force N, moment
    about the centre N m], both in space, and tangent (6, 6) with respect to (δc, δφ), δφ spatial. It is not
    symmetric.
    """
    _, acceleration, spin, spin_rate = updated(state, position, rotation, dt, beta, gamma)
    turn = log_so3(state.rotation.T @ rotation)
    momentum = inertia @ spin
    moment = rotation @ (inertia @ spin_rate + np.cross(spin, momentum))

    by_turn = inertia / (beta * dt * dt)
    by_turn = by_turn + gamma / (beta * dt) * (skew(spin) @ inertia - skew(momentum))
    by_angle = by_turn @ np.linalg.inv(right_tangent(turn))

    residual = np.concatenate((mass * acceleration, moment))
    tangent = np.zeros((6, 6))
    tangent[:3, :3] = mass / (beta * dt * dt) * np.eye(3)
    tangent[3:, 3:] = rotation @ by_angle @ rotation.T - skew(moment)
    return residual, tangent
