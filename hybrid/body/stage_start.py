"""State of a body where a stage begins: loads and lines that begin or end to act, guides that engage or release
components."""

from dataclasses import replace

import numpy as np

from hybrid.body import guides, motion, rigid


def begin_loads(body, state, time, scheme, gravity):
    """`state` after the loads of another stage begin to act at a `time` [s], with so much more `gravity` (3,) [m/s²]."""
    if not body.loads and state.load is None and not gravity.any():
        return state
    now = -guides.load_on(body.loads, state.rotation, time)[0]
    change = now - (np.zeros(6) if state.load is None else state.load) - rigid.weight(body, state.rotation, gravity)
    return replace(_under(body, state, change, scheme), load=now if body.loads else None)


def begin_line(body, state, change, scheme):
    """`state` after the pull line begins to act, `change` = 1, or ceases to, -1, and the work [J] by which that changes the
    energy of the line: what it has stored leaves with its far end."""
    if not change or body.line is None or state.target is None:
        return state, 0.0
    _, residual, _, energy = rigid.pull_of(body.line, *state.pose, state.target)
    return _under(body, state, -change * residual, scheme), change * energy


def _under(body, state, change, scheme):
    """`state` with a force and moment `change` (6,) [N, N m] more: free components accelerate by it from the start of the
    next step, and guides of the others take it."""
    new = accelerated(body, state, change) if scheme.inertia else state
    return replace(new, reaction=None if state.reaction is None else state.reaction - np.where(body.free, 0.0, change))


def release_guides(body, state):
    """`state` after guides release the components that are free from now on: the reaction they had accelerates the
    body from the start of the next step.

    Without it the scheme would start from zero acceleration, half a step late.
    """
    if state.reaction is None or not np.any(state.reaction[body.free]):
        return state
    return replace(accelerated(body, state, -state.reaction), reaction=np.where(body.free, 0.0, state.reaction))


def engage_guides(body, state, gravity, scheme, joined=False):
    """`state` after guides engage a body, and the work [J] of the impulse that brings it to their rates.

    A reaction that is not known yet, as at the start of a run, is set to what balances weight and inertia. Of a joined
    body it stays unknown where there are any, as joints bear a part.
    """
    if body.free.all():
        return state, 0.0
    new = rigid.impose_guide_rates(body, state)
    impulse_work = rigid.kinetic_energy(body, new) - rigid.kinetic_energy(body, state) if scheme.inertia else 0.0
    if state.reaction is None and not (joined and (scheme.inertia or gravity.any())):
        rates = np.zeros(6)
        if scheme.inertia:
            rates = np.concatenate([body.mass.mass * new.acceleration,
                                    motion.momentum_rate(body.mass.inertia, new)])
        new = replace(new, reaction=np.where(body.free, 0.0, rates + rigid.weight(body, state.rotation, gravity)))
    return new, impulse_work


def force_between(body, before, after):
    """Force and moment (6,) [N, N m] by which a body accelerates more in the state `after` than in the one `before`."""
    turning = after.rotation @ (body.mass.inertia @ (after.spin_rate - before.spin_rate))
    return np.concatenate([body.mass.mass * (after.acceleration - before.acceleration), turning])


def count_from_start(body, state, change, scheme, dt):
    """`state` at the end of an increment of `dt` [s] at whose start forces began to act, and by whose end what answers them
    has changed by a force and moment `change` (6,) [N, N m]: as if it had done so at the start. FORMULATION (27c)."""
    begun = acceleration(body, state, change)
    gained, _, algorithmic = scheme.advance(np.zeros(6), np.zeros(6), begun, begun, dt)
    return replace(state, velocity=state.velocity + gained[:3], spin=state.spin + gained[3:],
                   algorithmic=state.algorithmic + algorithmic)


def accelerated(body, state, load):
    """`state` with the accelerations of free components that a force and moment `load` (6,) [N, N m] adds."""
    added = acceleration(body, state, load)
    return replace(
        state, acceleration=state.acceleration + added[:3], spin_rate=state.spin_rate + added[3:],
        algorithmic=None if state.algorithmic is None else state.algorithmic + added)


def acceleration(body, state, load):
    """(6,) [m/s²; rad/s², body frame] of free components by a force and moment `load` (6,) [N, N m]."""
    force, moment = np.split(np.where(body.free, load, 0.0), 2)
    axes, inertia = state.rotation.T[:, body.free[3:]], body.mass.inertia     # free axes, in the body frame
    spin_rate = axes @ np.linalg.solve(axes.T @ inertia @ axes, axes.T @ (state.rotation.T @ moment))
    return np.concatenate([force / body.mass.mass, spin_rate])
