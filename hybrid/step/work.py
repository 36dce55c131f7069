"""Work of one increment, by what does it: plastic flow, ghost penalty, friction, stops, drive, pull and load
(`hybrid.step.energy`)."""

from dataclasses import replace

import numpy as np

from hybrid.body import guides, rigid
from hybrid.body.rigid import FREEDOMS
from hybrid.runtime.comm import anywhere
from hybrid.step.energy import soil_energies
from hybrid.step.support import work_of_support


def work_after(step, evaluation, points, bodies, lost):
    """Work [J] done since the start of the run, {name: value}, at the end of an increment.

    evaluation: the accepted one; points, bodies: the new state; lost: where stops and lines of joints engage.
    """
    work = dict(step.state.work)

    def add(name, value):
        work[name] = work.get(name, 0.0) + value

    if step.soil is not None:
        add("plastic", step.model.soil.plastic_work(step.soil, evaluation.soil_trial))
        add("ghost", step.model.soil.ghost_work(step.soil, evaluation.unknowns.displacement))
        if step.model.soil.stray != "stop" and anywhere(points.active != step.state.points.active):
            add("left", _of_lost_points(step, points))
    for terms in evaluation.bodies:
        for name, done in _on_body(terms, step.state.bodies[terms.step.number], bodies[terms.step.number]):
            add(name, done)
    if evaluation.pairs:
        add("friction", evaluation.pairs.dissipated)
    if evaluation.joints:
        add("friction", evaluation.joints.dissipated())
        if step.model.joints:
            add("stop", lost)
        for guide, done in evaluation.joints.work_of_guides(step.state.joints.multipliers):
            add("drive", done)
            add(drive_name(step.model.bodies[guide.bodies[0]], guide.name), done)
    if not step.model.loads.gravity_alone:
        add("load", _of_loads(step, points, bodies))
    return work


def _of_lost_points(step, points):
    """Energy of the points that became inactive, which stay as they were."""
    before = step.state.points
    stay = replace(before, inactive=points.inactive)
    return sum(soil_energies(step.model, before).values()) - sum(soil_energies(step.model, stay).values())


def _on_body(terms, before, after):
    """(name, work [J]) that is done on a body between two BodyStates, the committed one and the new one."""
    own = terms.step
    if own.body.drive.any() or own.body.guides:
        mean, moved, by_impulse = _of_drive(terms, before)
        yield "drive", float(mean @ moved) + float(by_impulse.sum())
        yield from by_component(own.body, mean * moved + by_impulse)
    yield "friction", terms.contact.dissipated
    if own.body.line:
        yield "pull", _of_pull(terms, after)
    if own.support is not None:
        yield "load", work_of_support(own, before, after)
    if own.body.loads:
        done = guides.work_of_loads(own.body.loads, before, after, own.begin, own.dt)
        yield "load", done
        yield load_name(own.body), done


def drive_name(body, component):
    """Name of the work that guides of a component, such as "x", have done on a body."""
    return f"drive of {body.name} {component}"


def load_name(body):
    """Name of the work that loads of the stages have done on a body."""
    return f"load of {body.name}"


def by_component(body, values):
    """(name, work [J]) of the components of a body whose guides have done work, of their work `values` (6,) [J]."""
    for component, value in zip(FREEDOMS, values):
        if value:
            yield drive_name(body, component), float(value)


def _of_drive(terms, committed):
    """(6,) each: mean reaction of the guides, the displacement that they impose, and the work of the impulse by which they
    change the rates of a `committed` BodyState."""
    own = terms.step
    before, now = own.state.reaction, terms.reaction
    mean = now if before is None else 0.5 * (before + now)
    by_impulse = np.zeros(6)
    if own.body.guides and own.scheme.inertia:
        by_impulse = rigid.impulse_work(own.body, committed, own.state)
    return mean, own.dt * np.where(own.free, 0.0, own.body.drive), by_impulse


def _of_pull(terms, new):
    """Mean force of the line times the displacement of its far end; of a line that cuts through soil, which takes a part,
    times that of its point on the body. new: BodyState after the step."""
    force, line, old = -0.5 * (terms.step.line_force + terms.trial.line[:3]), terms.step.body.line, terms.step.state
    if line.soil is None:
        return float(force @ (terms.step.dt * line.velocity))
    return float(force @ (new.position - old.position + (new.rotation - old.rotation) @ line.attachment))


def _of_loads(step, points, bodies):
    """All loads but the whole of gravity, on points and bodies."""
    loads, begin, end, work = step.model.loads, step.state.time, step.state.time + step.dt, 0.0
    if step.soil is not None:
        soil = step.model.soil.constants
        work = loads.work(begin, end, soil.mass, soil.position, points.position - step.state.points.position)
    mean = 0.5 * (loads.on_bodies(begin) + loads.on_bodies(end)) - loads.gravity
    return work + sum(one.body.mass.mass * float(mean @ (bodies[one.number].position - one.state.position))
                      for one in step.bodies)
