"""Joints in one increment: their rows and multipliers in the bodies' block of the equations.

    | K_ww - C  -Gᵀ s | | δw |       | R_w - Gᵀ λ |        λ = s μ      C = ∂(Gᵀ λ)/∂w
    |   -s G     -c   | | δμ |  = -  |   -s φ     |        a row at a bound of λ has  k δμ = -(λ - bound) k/s  instead

s = k, times a length r for rows of angles, with k a stiffness of the bodies, so that all entries are in N/m. Rows that
others imply, such as those along components that guides hold, are left out and have λ = 0; friction between bodies that
guides turn stays at its bound. Rows of friction, which may stick where a stop acts along them too, have c = CREEP k, all
others c = 0.

Multipliers are forces at the end of the increment. Newmark's scheme without damping makes them oscillate, so scenes with
joints need one that damps. Velocities that rows allow, and impulses: `hybrid.step.joint_rates`. The rows of joints are
followed by those of guided points (`hybrid.body.point_guides`).

Source: M. Arnold and O. Brüls, Multibody Syst. Dyn. 18 (2007) 185-202 (generalised alpha with multipliers).

Equations: FORMULATION (55) to (58), (53b).
"""

from dataclasses import dataclass

import numpy as np

from hybrid.body.joints import GROUND, Joint
from hybrid.body.point_guides import PointGuide
from hybrid.runtime.comm import largest
from hybrid.state import JointState

CREEP = 1e-9        # of sticking friction
IMPLIED = 1e-8      # share of a row that others leave over, below which it is implied by them
DRIVEN = 1e-12      # [rad] of a hinge in an increment, from which guides turn it
EXACT = 1e-3        # a tolerance of 1e-4 means 1e-7 radii, or rad
RELEASED = 1e-9     # difference of λ from its bound, relative to the largest λ,
FINE = 1e-4         # or to the force of an error of this size, so that 1e-50 N in a slack rope are within round-off


@dataclass(frozen=True)
class JointStep:
    """Joints as they are frozen during an increment.

    joints: constraints of the model; columns: (J, 12) places among the bodies' m unknowns, -1 of components that are none
    before: (J,) [rad, m] angles at its start, and where guided points should be at its end; way: (J,) [m] that these go
    kept: (n,) bool rows that are not implied; bounds: (n, 2); scale: (n,) s [N/m, N]
    stiffness: k [N/m]; length: (n,) [m, rad] that errors are relative to; size: m
    """

    joints: tuple[Joint | PointGuide, ...]
    columns: np.ndarray
    before: np.ndarray
    way: np.ndarray
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
        pairs = [poses_of(joint, poses) for joint in self.joints]
        rows = [joint.rows(pair, angle) for joint, pair, angle in zip(self.joints, pairs, self.before)]
        values = np.concatenate([value for value, _ in rows])
        trial = multipliers - self.scale**2 / self.stiffness * values
        low, high = self.bounds.T
        active = (trial > low) & (trial < high) & self.kept
        driven = _friction(self.bounds) & ~self.kept & (np.abs(values) > DRIVEN)
        bound = np.where(self.kept, np.clip(trial, low, high), 0.0)
        bound[driven] = np.where(values > 0.0, low, high)[driven]
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

    def holding(self):
        """Joints at points, rods and taut lines."""
        return [joint for joint, rows in zip(self.step.joints, self.step.slices()) if not isinstance(joint, PointGuide)
                and (joint.at_point or joint.length is not None and self.active[rows].all())]

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
        allowed = self.step.scale * self.step.length * EXACT
        missed = np.abs(np.where(self.active, self.residual() / allowed, 0.0)).max(initial=0.0)
        beyond = np.abs(self.multipliers - self.target).max(initial=0.0)
        largest = np.maximum(np.abs(self.multipliers), FINE * allowed).max(initial=0.0)
        return max(missed, 1.0 if beyond > RELEASED * largest else 0.0)

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
        guided = any(isinstance(joint, PointGuide) for joint in self.step.joints)
        return JointState(self.multipliers.copy(), self.active.copy(), self.values.copy() if guided else None)

    def guides(self):
        """[(PointGuide, its force [N] on the body)]."""
        return [(joint, float(self.multipliers[rows.start])) for joint, rows in zip(self.step.joints, self.step.slices())
                if isinstance(joint, PointGuide)]

    def work_of_guides(self, before):
        """[(PointGuide, its work [J] in the increment)]; before: multipliers (n,) at its start."""
        found = zip(self.step.joints, self.step.slices(), self.step.way)
        return [(joint, float(0.5 * (before[rows.start] + self.multipliers[rows.start]) * way)) for joint, rows, way in found
                if isinstance(joint, PointGuide)]

    def dissipated(self):
        """Work [J] against friction in the increment."""
        rows = _friction(self.step.bounds)
        return -float(self.multipliers[rows] @ self.values[rows])


def _friction(bounds):
    return np.isfinite(bounds[:, 0]) & np.isfinite(bounds[:, 1])


def poses_of(joint, poses):
    return tuple(GROUND if body is None else poses[body] for body in joint.bodies)


def begin_joints(model, state, dt):
    """JointStep of an increment of `dt` [s], None without joints and guided points."""
    if not model.constraints:
        return None
    poses = [motion.pose for motion in state.bodies]
    columns, size = columns_of(model)
    bounds, angular, radius = rows_of(model)
    stiffness = max(model.scheme.mass_factor(dt) * max(body.mass.mass for body in model.bodies),
                    largest(model.soil.law.young) * model.soil.grid.smallest_cell
                    if not (model.soil.held and model.scheme.inertia) else 0.0)
    way = np.array([dt * joint.guide.during(state.time, dt)[0] if isinstance(joint, PointGuide) else 0.0
                    for joint in model.constraints])
    return JointStep(
        model.constraints, columns, _before(model, state, poses) + way, way, kept_rows(model, poses), bounds,
        stiffness * np.where(angular, radius, 1.0), stiffness, np.where(angular, 1.0, radius), size)


def _before(model, state, poses):
    """(J,) angles [rad] of hinges, and where guided points should be [m] at the start of an increment."""
    missed, first, found = state.joints.missed, 0, []
    for joint in model.constraints:
        pair = poses_of(joint, poses)
        if isinstance(joint, PointGuide):
            found.append(joint.coordinate(pair) - (0.0 if missed is None else missed[first]))
        else:
            found.append(joint.angle(pair) if joint.turning else 0.0)
        first += len(joint.bounds)
    return np.array(found)


def kept_rows(model, poses):
    """(n,) bool, rows that are not implied by others."""
    columns, size = columns_of(model)
    bounds, angular, radius = rows_of(model)
    gradients = gradients_of(model.constraints, columns, size, poses)
    return independent(gradients / np.where(angular, 1.0, radius)[:, None], bounds)


def implied_guides(model, bodies):
    """PointGuides of a model whose rows are implied by others at the poses of its BodyStates."""
    if not model.guides:
        return []
    kept = kept_rows(model, [motion.pose for motion in bodies])
    return [guide for guide, there in zip(model.guides, kept[-len(model.guides):]) if not there]


def rates_of_guides(model, state, dt):
    """(b, 6) rates of the bodies [m/s, rad/s] by which guided points of a model without inertia go their way, with the
    least displacement; None where there are none."""
    if model.scheme.inertia or not model.guides:
        return None
    poses, (columns, size) = [motion.pose for motion in state.bodies], columns_of(model)
    radius = np.concatenate([[1.0] * 3 + [1.0 / body.radius] * 3 for body in model.bodies])[
        np.concatenate([body.free for body in model.bodies])]
    gradient = gradients_of(model.constraints, columns, size, poses) * radius
    always = ~np.isfinite(rows_of(model)[0]).any(axis=1)
    asked = np.concatenate([[joint.guide.during(state.time, dt)[0]] if isinstance(joint, PointGuide)
                            else np.zeros(len(joint.bounds)) for joint in model.constraints])
    return model.of_bodies(radius * np.linalg.lstsq(gradient[always], asked[always], rcond=1e-12)[0])


def columns_of(model):
    """(J, 12) places of the constraints' components among the bodies' unknowns, -1 of others, and their number."""
    places, none = model.component_places, np.full(6, -1)
    return np.array([np.concatenate([none if b is None else places[b] for b in joint.bodies])
                     for joint in model.constraints]), model.body_slices[-1].stop


def rows_of(model):
    """Bounds (n, 2), angular (n,) bool and a length (n,) [m] of the first body of all rows."""
    joints = model.constraints
    return (np.concatenate([joint.bounds for joint in joints]), np.concatenate([joint.angular for joint in joints]),
            np.concatenate([np.full(len(joint.bounds), model.bodies[joint.bodies[0]].radius) for joint in joints]))


def gradients_of(joints, columns, size, poses):
    """(n, m) ∂φ/∂w by the bodies' unknowns."""
    found = []
    for joint, places in zip(joints, columns):
        _, gradient = joint.rows(poses_of(joint, poses))
        own = np.zeros((len(gradient), size))
        own[:, places[places >= 0]] = gradient[:, places >= 0]
        found.append(own)
    return np.concatenate(found)


def independent(gradients, bounds):
    """(n,) bool, rows that are not implied by rows without bounds, taken in their order."""
    kept, basis = np.zeros(len(bounds), bool), np.zeros((0, gradients.shape[1]))
    for number in sorted(range(len(bounds)), key=lambda i: np.isfinite(bounds[i]).any()):
        row = left = gradients[number]
        for _ in range(2):      # Gram-Schmidt once more, against round-off
            left = left - (basis @ left) @ basis
        kept[number] = np.linalg.norm(left) > IMPLIED * max(np.linalg.norm(row), IMPLIED)
        if kept[number] and not np.isfinite(bounds[number]).any():
            basis = np.vstack([basis, left / np.linalg.norm(left)])
    return kept
