"""Inertia of one rigid body under any scheme of `hybrid.scheme`, with its exact tangent.

    Θ = log(R_n^T R)      (Δc, Θ), (v, W), (v̇, Ẇ)  follow the scheme's rule for increment, rate and second rate
    residual = [ m v̇ ,  R τ ]        τ = J Ẇ + W × J W

| symbol | meaning                                                      | shape  | unit         |
|--------|--------------------------------------------------------------|--------|--------------|
| c, R   | trial centre of mass and rotation (body frame to space)      | (3,), (3, 3) | m, -   |
| v, v̇   | velocity and acceleration of the centre, in space            | (3,)   | m/s, m/s²    |
| W, Ẇ   | spin and spin rate, in the body frame                        | (3,)   | rad/s, rad/s² |
| Θ      | rotation of this step, in the body frame                     | (3,)   | rad          |
| J      | inertia about the centre, in the body frame                  | (3, 3) | kg m²        |
| τ      | moment of inertia forces about the centre, in the body frame | (3,)   | N m          |
| π, ṗ   | angular momentum R J W and its rate R τ, in space            | (3,)   | N m s, N m   |
| M, G   | ∂v̇/∂Δu and ∂v/∂Δu of the scheme                              | -      | 1/s², 1/s    |

The unknowns are (δc, δφ) with c <- c + δc and R <- exp(δφ~) R, so δφ is a spatial vector; in the body frame it is
δΦ = R^T δφ. With the right tangent, δΘ = T^-1 δΦ, the tangent is (Simo and Wong 1991, sec. 4)

    K = [ M J + G (W̃ J - (J W)~) ] T^-1                   δ(R τ) = ( R K R^T - (R τ)~ ) δφ

**Energy-momentum.** The rotation is Cayley's, R_n^T R = cay(Θ), with Θ = Δt (W_n + W)/2, and the angular momentum
changes by the mean of the moments at both ends, π - π_n = Δt (ṗ_n + ṗ)/2. Equilibrium is solved at the end only, so

    ṗ = 2 (π - π_n)/Δt - ṗ_n            Ẇ = J^-1 (R^T ṗ - W × J W)

and Ẇ carries ṗ from step to step. Its tangent, with G = 2/Δt and δΘ = D δΦ, is δṗ = G (G R J D R^T - π~) δφ.
(W + W_n)/2 is along Θ, so R_n^T R does not change it, and the kinetic energy changes by Δt (W + W_n)/2 · R_n^T times
the mean moment: without a moment it is constant. A constant force F on an arm r of the body has the mean moment
(r_n + r)/2 × F, and a Cayley rotation moves the arm by R_n Θ × (r_n + r)/2: the work of F equals the gain of kinetic
energy exactly, and a heavy top keeps its energy. (With the exponential map the first holds and the second does not.)

Sources: J. C. Simo and K. K. Wong, Int. J. Numer. Meth. Engng 31 (1991) 19-52 (both families and their tangents);
D. Lewis and J. C. Simo, J. Nonlinear Sci. 4 (1994) 253-299 (with the Cayley map).

Frozen during a step: the committed BodyState, m and J. The rotation of a step must stay clearly below π, because the
logarithm cannot distinguish θ from θ - 2π: `rotation_angle` returns it.

Equations: FORMULATION (32) to (34), (36).
"""

from dataclasses import replace

import numpy as np

from hybrid.body.attitude import cayley_rate, cayley_vector, log_so3, right_tangent, skew


def updated(inertia, state, position, rotation, dt, scheme):
    """BodyState at the end of the step from committed `state` to trial `position` (3,) [m] and `rotation` (3, 3).

    inertia (3, 3) [kg m²] about the centre in the body frame; dt [s]. The target of a pull line is unchanged.
    """
    cayley = scheme.rotation == "cayley"
    theta = (cayley_vector if cayley else log_so3)(state.rotation.T @ rotation)
    increment = np.concatenate((position - state.position, theta))
    before = np.concatenate((state.velocity, state.spin))
    gain, second, algorithmic = scheme.advance(
        increment, before, np.concatenate((state.acceleration, state.spin_rate)), state.algorithmic, dt)
    rate = before + gain
    new = replace(state, position=position, rotation=rotation, velocity=rate[:3], acceleration=second[:3],
                  spin=rate[3:], spin_rate=second[3:], algorithmic=algorithmic)
    return replace(new, spin_rate=_spin_rate_of_mean_moment(inertia, state, new, dt)) if cayley else new


def _gyroscopic(inertia, spin):
    """W × J W (3,) [N m], in the body frame."""
    return skew(spin) @ (inertia @ spin)


def own_moment(inertia, state):
    """|J Ẇ| + |W × J W| [N m] of a BodyState."""
    return float(np.linalg.norm(inertia @ state.spin_rate) + np.linalg.norm(_gyroscopic(inertia, state.spin)))


def momentum_rate(inertia, state):
    """ṗ = R (J Ẇ + W × J W) (3,) [N m], in space."""
    return state.rotation @ (inertia @ state.spin_rate + _gyroscopic(inertia, state.spin))


def _spin_rate_of_mean_moment(inertia, old, new, dt):
    """Ẇ (3,) at the end of an energy-momentum step that led to the spin and rotation of `new`."""
    gain = new.rotation @ inertia @ new.spin - old.rotation @ inertia @ old.spin
    rate = 2.0 / dt * gain - momentum_rate(inertia, old)
    return np.linalg.solve(inertia, new.rotation.T @ rate - _gyroscopic(inertia, new.spin))


def inertia_residual(mass, inertia, state, position, rotation, dt, scheme):
    """Inertia force and moment of one body, and their derivative.

    mass [kg]; inertia (3, 3) [kg m²] about the centre in the body frame; state the committed BodyState;
    position (3,) and rotation (3, 3) the trial motion; dt [s]. Returns residual (6,) = [force N, moment
    about the centre N m], both in space, and tangent (6, 6) with respect to (δc, δφ), δφ spatial. It is not
    symmetric.
    """
    new = updated(inertia, state, position, rotation, dt, scheme)
    moment = momentum_rate(inertia, new)
    tangent = np.zeros((6, 6))
    tangent[:3, :3] = mass * scheme.mass_factor(dt) * np.eye(3)
    by_rotation = _by_cayley_rotation if scheme.rotation == "cayley" else _by_rotation
    tangent[3:, 3:] = by_rotation(inertia, state, new, moment, dt, scheme)
    return np.concatenate((mass * new.acceleration, moment)), tangent


def _by_rotation(inertia, old, new, moment, dt, scheme):
    """∂ṗ/∂φ (3, 3) [N m] with the exponential map."""
    theta = log_so3(old.rotation.T @ new.rotation)
    by_rotation = scheme.mass_factor(dt) * inertia
    by_rotation = by_rotation + scheme.rate_factor(dt) * (skew(new.spin) @ inertia - skew(inertia @ new.spin))
    return new.rotation @ by_rotation @ np.linalg.inv(right_tangent(theta)) @ new.rotation.T - skew(moment)


def _by_cayley_rotation(inertia, old, new, moment, dt, scheme):
    """∂ṗ/∂φ (3, 3) [N m] of energy-momentum."""
    factor = scheme.rate_factor(dt)
    by_rotation = inertia @ cayley_rate(cayley_vector(old.rotation.T @ new.rotation))
    momentum = new.rotation @ inertia @ new.spin
    return factor * (factor * new.rotation @ by_rotation @ new.rotation.T - skew(momentum))


def rotation_angle(inertia, state, position, rotation, dt, scheme):
    """Rotation [rad] of the step, or that of a step with the spin at its end if that is larger: near π the logarithm
    may have missed a turn, and the spin then shows it."""
    angle = np.linalg.norm(log_so3(state.rotation.T @ rotation))
    if not scheme.inertia:
        return angle
    return max(angle, dt * np.linalg.norm(updated(inertia, state, position, rotation, dt, scheme).spin))


def free_spin_rate(inertia, rotation, spin, free):
    """Spin rate (3,) [rad/s²] of a body on which only the guides of its held rotations act; free (3,) bool, rotations
    about the spatial axes. Zero if it spins about a principal axis."""
    axes = rotation.T[:, free]      # free axes, in the body frame
    return -axes @ np.linalg.solve(axes.T @ inertia @ axes, axes.T @ _gyroscopic(inertia, spin))
