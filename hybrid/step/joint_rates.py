"""Velocities and accelerations that joints and guided points allow, and the impulses by which they change.

    M (v_+ - v_-) = Gᵀ p      G v_+ = D'        M (a_+ - a_-) = Gᵀ f      G a_+ + v·(∂G/∂q) v = D''

D', D'' are the rates of guided points, zero in the rows of joints. Where a stop, a line or friction engages, the velocity
along it vanishes at once, without rebound; the loss of kinetic energy is work "stop". A guided point has the rates of its
table at the start of every increment; the gain of kinetic energy, p·(G v_- + D')/2 in each row, is work of the drive.

Equations: FORMULATION (59), (53b).
"""

from dataclasses import replace

import numpy as np

from hybrid.body import rigid
from hybrid.state import JointState
from hybrid.step.joint_terms import columns_of, gradients_of, independent, kept_rows, poses_of, rows_of
from hybrid.step.work import drive_name

AT_REST = 1e-12     # [rad/s] of a hinge
SHORTER = 0.5       # of the last increment: a shorter one begins with velocities along the joints


def start(model):
    """JointState before the first step, None without joints."""
    if not model.constraints:
        return None
    n = sum(len(joint.bounds) for joint in model.constraints)
    return JointState(np.zeros(n), np.zeros(n, bool))


def consistent(model, bodies, joints, active, driven=None):
    """(bodies, JointState, gains (n,) of kinetic energy [J]) with velocities that active rows (n,) bool allow and the
    accelerations that go on with them. driven: rates and second rates (2, n) of guided points, None where none are.

    Impulses and forces act along the rows only, so that what else acts on the bodies need not be known.
    """
    columns, size = columns_of(model)
    poses = [motion.pose for motion in bodies]
    rows, gains = np.flatnonzero(active), np.zeros(len(active))
    asked, asked_second = (np.zeros(len(active)),) * 2 if driven is None else driven
    g = gradients_of(model.constraints, columns, size, poses)[rows]
    response = np.linalg.solve(_masses(model, bodies, size), g.T)
    flexibility = g @ response
    along = (rates_of_rows(model.constraints, bodies) - asked)[rows]
    impulse = np.linalg.lstsq(flexibility, along, rcond=1e-12)[0]
    gains[rows] = -impulse * (0.5 * along + asked[rows])
    bodies = _with_rates(model, bodies, -response @ impulse, "velocity", "spin")
    if any(motion.algorithmic is not None for motion in bodies):    # has its own share of an impulse
        shown = [replace(motion, acceleration=motion.algorithmic[:3], spin_rate=motion.algorithmic[3:]) for motion in bodies]
        lag = (second_rates_of_rows(model.constraints, shown) - asked_second)[rows]
        shown = _with_rates(model, shown, -response @ np.linalg.lstsq(flexibility, lag, rcond=1e-12)[0],
                            "acceleration", "spin_rate")
        bodies = [replace(motion, algorithmic=np.concatenate([other.acceleration, other.spin_rate]))
                  for motion, other in zip(bodies, shown)]
    second = (second_rates_of_rows(model.constraints, bodies) - asked_second)[rows]
    force = np.linalg.lstsq(flexibility, second, rcond=1e-12)[0]
    bodies = _with_rates(model, bodies, -response @ force, "acceleration", "spin_rate")
    multipliers = joints.multipliers.copy()
    multipliers[rows] -= force
    return bodies, replace(joints, multipliers=multipliers), gains


# ------------------------------------------------------------------ stops, lines, friction


def engages(step, terms):
    """Whether stops, lines or friction engage in an increment, with an impulse. step: Step; terms: its JointTerms or
    None."""
    if terms is None or not step.model.scheme.inertia:
        return False
    bounded = np.isfinite(terms.step.bounds).any(axis=1)
    return bool((terms.active & bounded & ~step.state.joints.active).any())


def engaged(step, terms, bodies, joints):
    """(bodies, JointState, work [J]) at the end of an increment, after the impulses of stops, lines and friction that engage
    in it. step: Step; terms: its JointTerms; bodies, joints: of the new state."""
    if not engages(step, terms):
        return bodies, joints, 0.0
    driven = _driven(step.model, step.state.time, step.dt, 0.5)
    return *consistent(step.model, bodies, joints, terms.active, driven and driven[:2])[:2], _energy_along(step, terms)


def _energy_along(step, terms):
    """Kinetic energy [J] along the active rows when they engage: that at the start of the increment and what the forces then
    acting add to it on the way, ½ wᵀ S^-1 w + Δφᵀ S^-1 w', with S = G M^-1 Gᵀ, w = dφ/dt and w' = d²φ/dt²."""
    model, bodies, rows = step.model, step.state.bodies, np.flatnonzero(terms.active)
    poses = [motion.pose for motion in bodies]
    before = terms.step.evaluate(poses, terms.multipliers).values[rows]
    g = gradients_of(model.constraints, terms.step.columns, terms.step.size, poses)[rows]
    flexibility = g @ np.linalg.solve(_masses(model, bodies, terms.step.size), g.T)
    rate, second = rates_of_rows(model.constraints, bodies), second_rates_of_rows(model.constraints, bodies)
    driven = _driven(model, step.state.time, step.dt, -0.5)
    if driven is not None:
        rate, second = rate - driven[0], second - driven[1]
        before = np.where(driven[2][rows], terms.values[rows], before)      # these go their way
    impulse, force = np.linalg.lstsq(flexibility, np.array([rate, second]).T[rows], rcond=1e-12)[0].T
    return float(0.5 * rate[rows] @ impulse + (terms.values[rows] - before) @ force)


# ------------------------------------------------------------------ stages and guided points


def begin_stage(model, bodies, joints, same=False):
    """(bodies, JointState, kinetic energy lost [J]) at the start of a stage: what guides hold or release by then may let
    joined bodies move otherwise, but not where they go on as before, the `same`. Rows of guided points are added;
    `engage_guides` brings them to their rates."""
    if not model.constraints:
        return bodies, None, 0.0
    lost, bare = 0.0, replace(model, guides=())
    if model.joints:
        joints = JointState(*(values[:_count(model.joints)] for values in (joints.multipliers, joints.active)))
        gradients = gradients_of(model.joints, *columns_of(bare), [motion.pose for motion in bodies])
        bounds, _, _ = rows_of(bare)
        active = independent(gradients, bounds) & (~np.isfinite(bounds).any(axis=1) | joints.active)
        if model.scheme.inertia and not same:
            before = bodies
            bodies, joints = with_friction(bare, *consistent(bare, before, joints, active)[:2], active)
            # not p·G v of the rows: what they do to driven components is borne by the guides
            lost = -sum(float(rigid.impulse_work(*one).sum()) for one in zip(model.bodies, before, bodies))
    if model.guides:
        joints = JointState(np.zeros(0), np.zeros(0, bool)) if joints is None or not model.joints else joints
        more = np.zeros(_count(model.guides))
        joints = JointState(np.concatenate([joints.multipliers, more]), np.concatenate([joints.active, more > 0]))
    return bodies, joints, lost


def with_friction(model, bodies, joints, active):
    """(bodies, JointState) whose accelerations are those with the friction of hinges that turn, and of those at rest that
    begin to. active: (n,) bool, rows that `consistent` has satisfied.

    Friction of a hinge that turns is at its bound; at rest it is what keeps the hinge so, up to that bound. It is found by
    rows that stick and are given their bound where they would need more.
    """
    bounds, rates = rows_of(model)[0], rates_of_rows(model.constraints, bodies)
    friction = np.isfinite(bounds).all(axis=1) & ~active
    most, turns = np.where(friction, bounds[:, 1], 0.0), friction & (np.abs(rates) > AT_REST)
    given, sticks = np.where(turns, -np.sign(rates) * most, joints.multipliers), friction & ~turns
    found = bodies, joints
    for _ in range(1 + np.count_nonzero(friction)):
        moved = _pushed(model, bodies, np.where(friction & ~sticks, given - joints.multipliers, 0.0))
        pushed = replace(joints, multipliers=np.where(friction & ~sticks, given, joints.multipliers))
        found = consistent(model, moved, pushed, active | sticks)[:2]
        beyond = sticks & (np.abs(found[1].multipliers) > most * (1.0 + 1e-9))
        if not beyond.any():
            break
        given = np.where(beyond, np.sign(found[1].multipliers) * most, given)
        sticks &= ~beyond
    return found


def _pushed(model, bodies, multipliers):
    """Bodies accelerated by `multipliers` (n,) [N, N m] of the rows, as well."""
    if not multipliers.any():
        return bodies
    columns, size = columns_of(model)
    gradients = gradients_of(model.constraints, columns, size, [motion.pose for motion in bodies])
    change = np.linalg.solve(_masses(model, bodies, size), gradients.T @ multipliers)
    return _accelerated(model, bodies, change)


def _accelerated(model, bodies, change):
    """Bodies whose accelerations, the algorithmic ones too, change by (m,) on the unknowns."""
    found = _with_rates(model, bodies, change, "acceleration", "spin_rate")
    return [motion if motion.algorithmic is None else replace(motion, algorithmic=motion.algorithmic + np.concatenate(
        [motion.acceleration - old.acceleration, motion.spin_rate - old.spin_rate])) for motion, old in zip(found, bodies)]


def released(model, state, guides):
    """`state` after a stage with other `guides` of points: what they pushed with accelerates bodies from the start of the
    next step, as in `stage_start.release_guides`."""
    if state.joints is None or not model.scheme.inertia:
        return state
    before = replace(model, joints=(), guides=guides)
    poses = [motion.pose for motion in state.bodies]
    columns, size = columns_of(before)
    force = gradients_of(guides, columns, size, poses).T @ state.joints.multipliers[-len(guides):]
    change = -np.linalg.solve(_masses(model, state.bodies, size), force)
    return replace(state, bodies=_accelerated(before, state.bodies, change))


def along_joints(model, state, dt):
    """`state` at the start of an increment of `dt` [s] that is much shorter than the last one: with velocities that joints
    allow. They are off by what is of second order in that one, and to undo it in this one would take accelerations that no
    force causes, so that no increment were short enough for time.accuracy. Where points are guided `engage_guides` does
    so."""
    if not model.joints or model.guides or not model.scheme.inertia or dt > SHORTER * state.increment:
        return state
    always = ~np.isfinite(rows_of(model)[0]).any(axis=1)
    active = kept_rows(model, [motion.pose for motion in state.bodies]) & (always | state.joints.active)
    bodies, joints, _ = consistent(model, state.bodies, state.joints, active)
    return replace(state, bodies=bodies, joints=joints)


def engage_guides(model, state, dt):
    """`state` at the start of an increment of `dt` [s] in which guided points have the rates of their tables; the work of
    the impulses is work of the drive."""
    if not model.guides or not model.scheme.inertia:
        return state
    always = ~np.isfinite(rows_of(model)[0]).any(axis=1)
    active = kept_rows(model, [motion.pose for motion in state.bodies]) & (
        always | state.joints.active)
    bodies, joints, gains = consistent(model, state.bodies, state.joints, active, _driven(model, state.time, dt, -0.5)[:2])
    work = dict(state.work)
    work["drive"] = work.get("drive", 0.0) + float(gains.sum())
    for guide, gain in zip(model.guides, gains[-len(model.guides):]):
        name = drive_name(model.bodies[guide.bodies[0]], guide.name)
        work[name] = work.get(name, 0.0) + float(gain)
    return replace(state, bodies=bodies, joints=joints, work=work)


def _driven(model, time, dt, after):
    """Rates and second rates (2, n) of all rows `after` so many times dt from the middle of an increment, and which rows are
    those of guides; None without guided points."""
    if not model.guides:
        return None
    found = [np.zeros((3, _count(model.joints)))]
    for guide in model.guides:
        rate, second = guide.guide.during(time, dt)
        found.append(np.array([[rate + after * dt * second], [second], [1.0]]))
    rates, seconds, guided = np.hstack(found)
    return rates, seconds, guided > 0.0


def _count(joints):
    return sum(len(joint.bounds) for joint in joints)


def velocity_against(model, bodies):
    """[(Joint, largest rate of its rows without bounds [m/s, rad/s])]."""
    rates, first, found = rates_of_rows(model.joints, bodies) if model.joints else [], 0, []
    for joint in model.joints:
        own = rates[first:first + len(joint.bounds)][~np.isfinite(joint.bounds).any(axis=1)]
        first += len(joint.bounds)
        found.append((joint, float(np.abs(own).max(initial=0.0))))
    return found


# ------------------------------------------------------------------ masses and rates


def _masses(model, bodies, size):
    """(m, m) mass matrix of the bodies' unknowns."""
    out = np.zeros((size, size))
    for body, motion, own in zip(model.bodies, bodies, model.body_slices):
        full = np.zeros((6, 6))
        full[:3, :3] = body.mass.mass * np.eye(3)
        full[3:, 3:] = motion.rotation @ body.mass.inertia @ motion.rotation.T
        out[own, own] = full[np.ix_(body.free, body.free)]
    return out


def _with_rates(model, bodies, change, translation, rotation):
    """Bodies whose rates of the named kind change by (m,) on the unknowns."""
    found = []
    for motion, full in zip(bodies, model.of_bodies(change)):
        own = np.concatenate([full[:3], motion.rotation.T @ full[3:]])
        found.append(replace(motion, **{translation: getattr(motion, translation) + own[:3],
                                        rotation: getattr(motion, rotation) + own[3:]}))
    return found


def _spatial(joint, bodies, translation, rotation):
    """(12,) rates of a joint's two bodies in space."""
    return np.concatenate([np.zeros(6) if b is None else np.concatenate(
        [getattr(bodies[b], translation), bodies[b].rotation @ getattr(bodies[b], rotation)]) for b in joint.bodies])


def rates_of_rows(joints, bodies):
    """(n,) dφ/dt."""
    poses = [motion.pose for motion in bodies]
    return np.concatenate([joint.rows(poses_of(joint, poses))[1] @ _spatial(joint, bodies, "velocity", "spin")
                           for joint in joints])


def second_rates_of_rows(joints, bodies):
    """(n,) d²φ/dt² = G a + v·(∂G/∂q) v."""
    poses, found = [motion.pose for motion in bodies], []
    for joint in joints:
        pair, rate = poses_of(joint, poses), _spatial(joint, bodies, "velocity", "spin")
        _, gradient = joint.rows(pair)
        bent = np.array([rate @ joint.curvature(pair, one) @ rate for one in np.eye(len(gradient))])
        found.append(gradient @ _spatial(joint, bodies, "acceleration", "spin_rate") + bent)
    return np.concatenate(found)
