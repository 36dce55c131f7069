"""The loads at which a quasi-static step failed: the first cause, where forces or moments of a stage push free bodies or
gravity grows."""

import numpy as np

from hybrid.runtime.units import force_unit

ALONG = 1e-6    # of the largest component of a force, from which it has one along the ground
AFTER = ". Set time.inertia = true to follow what moves from then on, as a body that sinks until the soil carries it"


def overloads(step, reason, lost):
    """[(text, whether the load acts at once)] of the loads that a failed `step` without inertia carries; reason: why it
    failed; lost: whether no body has contact, so that loads that lift one exceed nothing."""
    model = step.model
    if model.scheme.inertia:
        return []
    # a body that has flown off, or that nothing holds, rather than soil that yields
    held = step.soil is None
    yields, singular = not held and model.soil.law.plastic, "linear solver" in reason and not held
    found, begin, end = [], step.state.time, step.state.time + step.dt
    for body in model.bodies:
        before, after = (sum((np.concatenate(load.at(time)) for load in body.loads), np.zeros(6)) for time in (begin, end))
        if not body.free[after != 0.0].any() or lost and lifted(step, body):
            continue
        if np.allclose(before, after, rtol=1e-12, atol=0.0):
            if step.state.step == 0 and after[:3].any():    # later it has been carried before
                found.append((_at_once(body.name, after[:3], yields) + _sign(step, body, after[:3]), True))
        elif not singular and (yields or slides(body, after[:3])):
            holds = ("the soil can carry" if yields else "holds the body, which slides or topples" if held else
                     "friction on the elastic soil can carry")
            found.append((f"The load exceeds what {holds}: that on {body.name} had reached "
                          f"{components_of(before)} at t = {begin:.6g} s, the last accepted increment{AFTER * yields}",
                          False))
    share, whole = (np.linalg.norm(acceleration) for acceleration in (model.loads.on_bodies(begin), model.gravity))
    if model.loads.high > model.loads.low and whole > 0.0 and yields and not singular:
        found.append((f"The load exceeds what the soil can carry: gravity had reached {share / whole:.3g} of the whole "
                      f"at t = {begin:.6g} s, the last accepted increment{AFTER}", False))
    return found


def slides(body, force):
    """Whether a force (3,) [N] has a part along the ground in which a body is free, so that friction may be all that
    holds it."""
    return bool((body.free[:2] & (np.abs(force[:2]) > ALONG * np.abs(force).max())).any())


def lifted(step, body):
    """Text about a body whose loads pull it up by more than its weight in a `step`, empty of others and of those that
    hold on to the soil."""
    force = sum((load.at(step.state.time + step.dt)[0] for load in body.loads), np.zeros(3))
    weight = body.mass.mass * step.model.loads.on_bodies(step.state.time + step.dt)
    if force[2] <= max(0.0, -weight[2]) or held_down(body):
        return ""
    return (f"The load on {body.name}, {components_of(force)}, is larger than its weight, {abs(weight[2]):.3g} N, and "
            "lifts it off the soil, where without inertia nothing balances it: z points up, so that a load that presses "
            "down is negative. Change its sign, or let the soil hold on to the body (body.tension), or set time.inertia "
            "= true")


def held_down(body):
    """Whether a line, soil that sticks to it or a guide may keep a body from being lifted."""
    return body.line is not None or not body.free[2] or bool(body.interface and body.interface.tension)


def _at_once(name, force, yields):
    """Text about a constant force (3,) [N] that a run without inertia begins with, on soil that yields or on elastic
    soil."""
    row, carried = ", ".join(f"{value:.6g}" for value in force), ", or it exceeds what the soil can carry" if yields else ""
    message = ", and the message then says how much is carried" if yields else ""
    return (f"The load on {name}, {components_of(force)}, acts at once, and the first step may not find its "
            f"equilibrium{carried}: let the load grow, force = [[0, 0, 0, 0], [T, {row}]] with T the length of the "
            f"stage{message}")


def _sign(step, body, force):
    """Text about a force (3,) [N] that pulls a body up by more than its weight and may have the wrong sign."""
    if not lifted(step, body):
        return ""
    return f". It pulls {body.name} up: z points up, so that fz = {force[2]:.6g} N should be negative if it presses down"


def components_of(load):
    """Text of the components of a force (3,) [N], or of a force and a moment (6,) [N, N m], that are not 0, such as
    "fx = 39.3, fz = -180 kN, my = 3 N m"; of a load that has not begun "0 N"."""
    parts = [_components(load[:3], "f", ""), _components(load[3:], "m", " m")]
    return ", ".join(filter(None, parts)) or "0 N"


def _components(values, letter, times):
    largest = np.abs(values).max(initial=0.0)
    scale, unit = force_unit(largest)
    shown = [f"{letter}{axis} = {value / scale:.3g}" for axis, value in zip("xyz", values) if abs(value) > 1e-6 * largest]
    return f"{', '.join(shown)} {unit}{times}" if shown else ""
