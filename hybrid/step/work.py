"""Work of one increment, by what does it: plastic flow, ghost penalty, friction, stops, drive, pull and load
(`hybrid.step.energy`)."""

import numpy as np

from hybrid.body import guides, rigid
from hybrid.body.rigid import FREEDOMS
from hybrid.step.support import work_of_support


def work_after(step, evaluation, points, bodies, lost=0.0):
    """Work [J] done since the start of the run, {name: value}, at the end of an increment.

    evaluation: the accepted one; points, bodies: the new state; lost: where stops and lines of joints engage.
    """
    work = dict(step.state.work)

    def add(name, value):
        work[name] = work.get(name, 0.0) + value

    if step.soil is not None:
        add("plastic", step.model.soil.plastic_work(step.soil, evaluation.soil_trial))
        add("ghost", step.model.soil.ghost_work(step.soil, evaluation.unknowns.displacement))
    for terms in evaluation.bodies:
        if terms.step.body.drive.any() or terms.step.body.guides:
            mean, moved, jolt = _of_drive(terms, step.state.bodies[terms.step.number])
            add("drive", float(mean @ moved) + float(jolt.sum()))
            add_by_component(work, terms.step.body, mean * moved + jolt)
    for terms in evaluation.bodies:
        add("friction", terms.contact.dissipated)
    if evaluation.pairs:
        add("friction", evaluation.pairs.dissipated)
    if evaluation.joints:
        add("friction", evaluation.joints.dissipated())
        if step.model.joints:
            add("stop", lost)
        for guide, done in evaluation.joints.work_of_guides(step.state.joints.multipliers):
            add("drive", done)
            add(drive_name(step.model.bodies[guide.bodies[0]], guide.name), done)
    for terms in evaluation.bodies:
        if terms.step.body.line:
            add("pull", _of_pull(terms, bodies[terms.step.number]))
    for terms in evaluation.bodies:
        if terms.step.support is not None:
            add("load", work_of_support(terms.step, step.state.bodies[terms.step.number], bodies[terms.step.number]))
        if own := terms.step.body.loads:
            done = guides.work_of_loads(own, step.state.bodies[terms.step.number], bodies[terms.step.number],
                                        step.state.time, step.dt)
            add("load", done)
            add(load_name(terms.step.body), done)
    if not step.model.loads.gravity_alone:
        add("load", _of_loads(step, points, bodies))
    return work


def drive_name(body, component):
    """Name of the work that guides of a component, such as "x", have done on a body."""
    return f"drive of {body.name} {component}"


def load_name(body):
    """Name of the work that loads of the stages have done on a body."""
    return f"load of {body.name}"


def add_by_component(work, body, values):
    """Add the work (6,) [J] of a body's guides to {name: [J]} by component."""
    for component, value in zip(FREEDOMS, values):
        if value:
            name = drive_name(body, component)
            work[name] = work.get(name, 0.0) + float(value)


def _of_drive(terms, committed):
    """(6,) each: mean reaction of the guides, the displacement that they impose, and the work of the impulse by which they
    change the rates of a `committed` BodyState."""
    own = terms.step
    before, now = own.state.reaction, terms.reaction
    mean = now if before is None else 0.5 * (before + now)
    jolt = rigid.jolt(own.body, committed, own.state) if own.body.guides and own.scheme.inertia else np.zeros(6)
    return mean, own.dt * own.body.drive, jolt


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
