"""Joints in one increment: their rows and multipliers in the bodies' block of the equations.

    | K_ww - C  -Gᵀ s | | δw |       | R_w - Gᵀ λ |        λ = s μ      C = ∂(Gᵀ λ)/∂w
    |   -s G     -c   | | δμ |  = -  |   -s φ     |        a row that is at a bound of λ has  k δμ = -(λ - bound) k/s  instead

s = k, times a length r for rows of angles, with k a stiffness of the bodies, so that all entries are in N/m. Rows that the
others imply, such as those along components that guides hold, are left out: their λ is zero. c = CREEP k for rows of
friction, which may stick where a stop acts along them too, else 0.

Multipliers are forces at the end of the increment. Newmark's scheme without damping makes them oscillate, so scenes with joints
need one that damps. Where a stop, a line or friction engages, the velocity along it vanishes at once: an impulse M dv = Gᵀ p with
G v = 0 afterwards, without rebound, whose loss of kinetic energy is work "stop".

Source: M. Arnold and O. Brüls, Multibody Syst. Dyn. 18 (2007) 185-202 (generalised alpha with multipliers).

Equations: FORMULATION (55) to (59).
"""

from dataclasses import dataclass, replace

import numpy as np

from hybrid.body.joints import GROUND, Joint
from hybrid.runtime.comm import largest
from hybrid.state import JointState

CREEP = 1e-9        # of sticking friction
IMPLIED = 1e-8      # share of a row that others leave over, below which it is implied by them
EXACT = 1e-3        # a tolerance of 1e-4 means 1e-7 radii, or rad
RELEASED = 1e-9     # difference of λ from its bound, relative to the largest λ


@dataclass(frozen=True)
class JointStep:
    """Joints as they are frozen during an increment.

    joints: those of the model; columns: (J, 12) places among the bodies' m unknowns, -1 of components that are none
    before: (J,) [rad] angles at its start; kept: (n,) bool rows that are not implied; bounds: (n, 2); scale: (n,) s [N/m, N]
    stiffness: k [N/m]; length: (n,) [m, rad] that errors are relative to; size: m
    """

    joints: tuple[Joint, ...]
    columns: np.ndarray
    before: np.ndarray
    kept: np.ndarray
    bounds: np.ndarray
    scale: np.ndarray
    stiffness: float
    length: np.ndarray
    size: int

    def slices(self):
        """Slice of the rows of each joint."""
        first = 0
        for joint in self.joints:
            yield slice(first, first := first + len(joint.bounds))

    def evaluate(self, poses, multipliers):
        """JointTerms at poses of the bodies and multipliers (n,)."""
        pairs = [_poses_of(joint, poses) for joint in self.joints]
        rows = [joint.rows(pair, angle) for joint, pair, angle in zip(self.joints, pairs, self.before)]
        values = np.concatenate([value for value, _ in rows])
        trial = multipliers - self.scale**2 / self.stiffness * values
        low, high = self.bounds.T
        active = (trial > low) & (trial < high) & self.kept
        bound = np.where(self.kept, np.clip(trial, low, high), 0.0)
        return JointTerms(self, pairs, values, [gradient for _, gradient in rows], multipliers, active,
                          np.where(active, multipliers, bound))


@dataclass(frozen=True)
class JointTerms:
    """Rows at trial poses: values φ (n,), gradients [(n_j, 12)], multipliers λ (n,), active (n,) bool where φ = 0 is asked
    for, target (n,) the bounds of the others."""

    step: JointStep
    pairs: list
    values: np.ndarray
    gradients: list
    multipliers: np.ndarray
    active: np.ndarray
    target: np.ndarray

    def on_body(self, number):
        """Residual (6,) [N, N m] of all joints on a body: minus their force and moment about its centre."""
        total = np.zeros(6)
        for joint, rows, gradient in zip(self.step.joints, self.step.slices(), self.gradients):
            for side, body in enumerate(joint.bodies):
                if body == number:
                    total -= (self.multipliers[rows] @ gradient)[6 * side:6 * side + 6]
        return total

    def forces(self):
        """[(6,)] force [N] and moment [N m] about the joined point on the first body of each joint."""
        found = []
        for joint, pair, rows, gradient in zip(self.step.joints, self.pairs, self.step.slices(), self.gradients):
            force, moment = np.split((self.multipliers[rows] @ gradient)[:6], 2)
            found.append(np.concatenate([force, moment - np.cross(pair[0][1] @ joint.points[0], force)]))
        return found

    def residual(self):
        """(n,) [N] in the rows of the multipliers."""
        s, k = self.step.scale, self.step.stiffness
        creep = np.where(_friction(self.step.bounds), CREEP, 0.0) * k / s * self.multipliers
        return np.where(self.active, -s * self.values - creep, (self.multipliers - self.target) * k / s)

    def opened(self):
        """Largest value [m or rad] of the rows that should be zero."""
        return np.abs(self.values[self.active]).max(initial=0.0)

    def error(self):
        """Largest error, relative to what `solver.tolerance` = 1 would allow."""
        missed = self.residual() / (self.step.scale * self.step.length * EXACT)
        missed = np.abs(np.where(self.active, missed, 0.0)).max(initial=0.0)
        beyond = np.abs(self.multipliers - self.target).max(initial=0.0)
        return max(missed, 1.0 if beyond > RELEASED * np.abs(self.multipliers).max(initial=0.0) else 0.0)

    def add_tangent(self, ww):
        """Add the joints to the bodies' block (m + n, m + n)."""
        s, k, m = self.step.scale, self.step.stiffness, self.step.size
        for joint, pair, rows, gradient, columns in zip(
                self.step.joints, self.pairs, self.step.slices(), self.gradients, self.step.columns):
            own = columns >= 0
            places = columns[own]
            ww[np.ix_(places, places)] -= joint.curvature(pair, self.multipliers[rows])[np.ix_(own, own)]
            number = m + np.arange(rows.start, rows.stop)
            ww[np.ix_(places, number)] -= gradient[:, own].T * s[rows]
            active = self.active[rows]
            ww[np.ix_(number[active], places)] -= s[rows][active, None] * gradient[active][:, own]
        n = m + np.arange(len(s))
        creep = np.where(_friction(self.step.bounds), -CREEP * k, 0.0)
        ww[n, n] += np.where(self.active, creep, k)

    def state(self):
        """JointState at the end of the increment."""
        return JointState(self.multipliers.copy(), self.active.copy())

    def dissipated(self):
        """Work [J] against friction in the increment."""
        rows = _friction(self.step.bounds)
        return -float(self.multipliers[rows] @ self.values[rows])


def _friction(bounds):
    return np.isfinite(bounds[:, 0]) & np.isfinite(bounds[:, 1])


def _poses_of(joint, poses):
    return tuple(GROUND if body is None else poses[body] for body in joint.bodies)


def begin_joints(model, state, dt):
    """JointStep of an increment of `dt` [s], None without joints."""
    if not model.joints:
        return None
    poses = [(motion.position, motion.rotation) for motion in state.bodies]
    columns, size = _columns(model)
    bounds, angular, radius = _rows_of(model)
    stiffness = max(model.scheme.mass_factor(dt) * max(body.mass.mass for body in model.bodies),
                    largest(model.soil.law.young) * model.soil.grid.smallest_cell
                    if not (model.soil.held and model.scheme.inertia) else 0.0)
    gradients = _gradients(model.joints, columns, size, poses)
    return JointStep(
        model.joints, columns, np.array([joint.angle(_poses_of(joint, poses)) if joint.turning else 0.0
                                         for joint in model.joints]),
        _independent(gradients / np.where(angular, 1.0, radius)[:, None], bounds), bounds,
        stiffness * np.where(angular, radius, 1.0), stiffness, np.where(angular, 1.0, radius), size)


def _columns(model):
    """(J, 12) places of the joints' components among the bodies' unknowns, -1 of others, and their number."""
    first, places = 0, []
    for body in model.bodies:
        own = np.full(6, -1)
        own[body.free] = first + np.arange(np.count_nonzero(body.free))
        first += np.count_nonzero(body.free)
        places.append(own)
    none = np.full(6, -1)
    return np.array([np.concatenate([none if b is None else places[b] for b in joint.bodies]) for joint in model.joints]), first


def _rows_of(model):
    """Bounds (n, 2), angular (n,) bool and a length (n,) [m] of the first body of all rows."""
    joints = model.joints
    return (np.concatenate([joint.bounds for joint in joints]), np.concatenate([joint.angular for joint in joints]),
            np.concatenate([np.full(len(joint.bounds), model.bodies[joint.bodies[0]].radius) for joint in joints]))


def _gradients(joints, columns, size, poses):
    """(n, m) ∂φ/∂w by the bodies' unknowns."""
    found = []
    for joint, places in zip(joints, columns):
        _, gradient = joint.rows(_poses_of(joint, poses))
        own = np.zeros((len(gradient), size))
        own[:, places[places >= 0]] = gradient[:, places >= 0]
        found.append(own)
    return np.concatenate(found)


def _independent(gradients, bounds):
    """(n,) bool, rows that are not implied by rows without bounds, taken in their order."""
    kept, basis = np.zeros(len(bounds), bool), []
    for number in sorted(range(len(bounds)), key=lambda i: np.isfinite(bounds[i]).any()):
        row, left = gradients[number], gradients[number].copy()
        for _ in range(2):      # Gram-Schmidt once more, against round-off
            for one in basis:
                left = left - (one @ left) * one
        kept[number] = np.linalg.norm(left) > IMPLIED * max(np.linalg.norm(row), IMPLIED)
        if kept[number] and not np.isfinite(bounds[number]).any():
            basis.append(left / np.linalg.norm(left))
    return kept


# ------------------------------------------------------------------ velocities and accelerations that joints allow


def start(model):
    """JointState before the first step, None without joints."""
    if not model.joints:
        return None
    n = sum(len(joint.bounds) for joint in model.joints)
    return JointState(np.zeros(n), np.zeros(n, bool))


def consistent(model, bodies, joints, active):
    """(bodies, JointState, kinetic energy lost [J]) with velocities that active rows (n,) bool allow and the accelerations
    that go on with them.

    Impulses and forces act along the rows only, so that what else acts on the bodies need not be known.
    """
    columns, size = _columns(model)
    poses = [(motion.position, motion.rotation) for motion in bodies]
    rows = np.flatnonzero(active)
    g = _gradients(model.joints, columns, size, poses)[rows]
    response = np.linalg.solve(_masses(model, bodies, size), g.T)
    flexibility = g @ response
    along = _rates_of_rows(model.joints, bodies)[rows]
    impulse = np.linalg.lstsq(flexibility, along, rcond=1e-12)[0]
    loss = 0.5 * float(along @ impulse)
    bodies = _with_rates(model, bodies, -response @ impulse, "velocity", "spin")
    if any(motion.algorithmic is not None for motion in bodies):    # has its own share of an impulse
        shown = [replace(motion, acceleration=motion.algorithmic[:3], spin_rate=motion.algorithmic[3:]) for motion in bodies]
        lag = _second_rates_of_rows(model.joints, shown)[rows]
        shown = _with_rates(model, shown, -response @ np.linalg.lstsq(flexibility, lag, rcond=1e-12)[0],
                            "acceleration", "spin_rate")
        bodies = [replace(motion, algorithmic=np.concatenate([other.acceleration, other.spin_rate]))
                  for motion, other in zip(bodies, shown)]
    second = _second_rates_of_rows(model.joints, bodies)[rows]
    force = np.linalg.lstsq(flexibility, second, rcond=1e-12)[0]
    bodies = _with_rates(model, bodies, -response @ force, "acceleration", "spin_rate")
    multipliers = joints.multipliers.copy()
    multipliers[rows] -= force
    return bodies, replace(joints, multipliers=multipliers), loss


def engages(step, terms):
    """Whether stops, lines or friction engage in an increment, with an impulse. step: Step; terms: its JointTerms or None."""
    if terms is None or not step.model.scheme.inertia:
        return False
    bounded = np.isfinite(terms.step.bounds).any(axis=1)
    return bool((terms.active & bounded & ~step.state.joints.active).any())


def engaged(step, terms, bodies, joints):
    """(bodies, JointState, work [J]) at the end of an increment, after the impulses of stops, lines and friction that engage
    in it. step: Step; terms: its JointTerms; bodies, joints: of the new state."""
    if not engages(step, terms):
        return bodies, joints, 0.0
    return *consistent(step.model, bodies, joints, terms.active)[:2], _energy_along(step, terms)


def _energy_along(step, terms):
    """Kinetic energy [J] along the active rows when they engage: that at the start of the increment and what the forces then
    acting add to it on the way, ½ wᵀ S^-1 w + Δφᵀ S^-1 w', with S = G M^-1 Gᵀ, w = dφ/dt and w' = d²φ/dt²."""
    model, bodies, rows = step.model, step.state.bodies, np.flatnonzero(terms.active)
    poses = [(motion.position, motion.rotation) for motion in bodies]
    before = terms.step.evaluate(poses, terms.multipliers).values[rows]
    g = _gradients(model.joints, terms.step.columns, terms.step.size, poses)[rows]
    flexibility = g @ np.linalg.solve(_masses(model, bodies, terms.step.size), g.T)
    rate, second = _rates_of_rows(model.joints, bodies)[rows], _second_rates_of_rows(model.joints, bodies)[rows]
    impulse, force = np.linalg.lstsq(flexibility, np.array([rate, second]).T, rcond=1e-12)[0].T
    return float(0.5 * rate @ impulse + (terms.values[rows] - before) @ force)


def begin_stage(model, bodies, joints):
    """(bodies, JointState, kinetic energy lost [J]) at the start of a stage: what guides hold or release by then may let
    joined bodies move otherwise."""
    if not model.joints:
        return bodies, joints, 0.0
    columns, size = _columns(model)
    bounds, _, radius = _rows_of(model)
    gradients = _gradients(model.joints, columns, size, [(motion.position, motion.rotation) for motion in bodies])
    always = ~np.isfinite(bounds).any(axis=1)
    active = _independent(gradients, bounds) & (always | joints.active)
    return consistent(model, bodies, joints, active) if model.scheme.inertia else (bodies, joints, 0.0)


def velocity_against(model, bodies):
    """[(Joint, largest rate of its rows without bounds [m/s, rad/s])]."""
    rates, first, found = _rates_of_rows(model.joints, bodies) if model.joints else [], 0, []
    for joint in model.joints:
        own = rates[first:first + len(joint.bounds)][~np.isfinite(joint.bounds).any(axis=1)]
        first += len(joint.bounds)
        found.append((joint, float(np.abs(own).max(initial=0.0))))
    return found


def _masses(model, bodies, size):
    """(m, m) mass matrix of the bodies' unknowns."""
    out, first = np.zeros((size, size)), 0
    for body, motion in zip(model.bodies, bodies):
        full = np.zeros((6, 6))
        full[:3, :3] = body.mass.mass * np.eye(3)
        full[3:, 3:] = motion.rotation @ body.mass.inertia @ motion.rotation.T
        count = np.count_nonzero(body.free)
        out[first:first + count, first:first + count] = full[np.ix_(body.free, body.free)]
        first += count
    return out


def _with_rates(model, bodies, change, translation, rotation):
    """Bodies whose rates of the named kind change by (m,) on the unknowns."""
    found, first = [], 0
    for body, motion in zip(model.bodies, bodies):
        count = np.count_nonzero(body.free)
        full = np.zeros(6)
        full[body.free] = change[first:first + count]
        first += count
        own = np.concatenate([full[:3], motion.rotation.T @ full[3:]])
        found.append(replace(motion, **{translation: getattr(motion, translation) + own[:3],
                                        rotation: getattr(motion, rotation) + own[3:]}))
    return found


def _spatial(joint, bodies, translation, rotation):
    """(12,) rates of a joint's two bodies in space."""
    return np.concatenate([np.zeros(6) if b is None else np.concatenate(
        [getattr(bodies[b], translation), bodies[b].rotation @ getattr(bodies[b], rotation)]) for b in joint.bodies])


def _rates_of_rows(joints, bodies):
    """(n,) dφ/dt."""
    poses = [(motion.position, motion.rotation) for motion in bodies]
    return np.concatenate([joint.rows(_poses_of(joint, poses))[1] @ _spatial(joint, bodies, "velocity", "spin")
                           for joint in joints])


def _second_rates_of_rows(joints, bodies):
    """(n,) d²φ/dt² = G a + v·(∂G/∂q) v."""
    poses, found = [(motion.position, motion.rotation) for motion in bodies], []
    for joint in joints:
        pair, rate = _poses_of(joint, poses), _spatial(joint, bodies, "velocity", "spin")
        _, gradient = joint.rows(pair)
        bent = np.array([rate @ joint.curvature(pair, one) @ rate for one in np.eye(len(gradient))])
        found.append(gradient @ _spatial(joint, bodies, "acceleration", "spin_rate") + bent)
    return np.concatenate(found)
