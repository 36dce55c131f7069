"""Work of one increment, by what does it: plastic flow, ghost penalty, friction, drive, pull and load (`hybrid.step.energy`)."""


def work_after(step, evaluation, points, bodies):
    """Work [J] done since the start of the run, {name: value}, at the end of an increment.

    evaluation: the accepted one; points, bodies: the new state.
    """
    work = dict(step.state.work)

    def add(name, value):
        work[name] = work.get(name, 0.0) + value

    if step.soil is not None:
        add("plastic", step.model.soil.plastic_work(step.soil, evaluation.soil_trial))
        add("ghost", step.model.soil.ghost_work(step.soil, evaluation.unknowns.displacement))
    for terms in evaluation.bodies:
        if terms.step.body.drive.any():
            add("drive", _of_drive(terms))
    for terms in evaluation.bodies:
        add("friction", terms.contact.dissipated)
    for terms in evaluation.bodies:
        if terms.step.body.line:
            add("pull", _of_pull(terms))
    if not step.model.loads.gravity_alone:
        add("load", _of_loads(step, points, bodies))
    return work


def _of_drive(terms):
    """Mean reaction of the guides times the displacement that they impose."""
    before, now = terms.step.state.reaction, terms.reaction
    mean = now if before is None else 0.5 * (before + now)
    return float(mean @ (terms.step.dt * terms.step.body.drive))


def _of_pull(terms):
    """Mean force of the line times the displacement of its far end."""
    force = -0.5 * (terms.step.line_force + terms.trial.line[:3])
    return float(force @ (terms.step.dt * terms.step.body.line.velocity))


def _of_loads(step, points, bodies):
    """All loads but the whole of gravity, on points and bodies."""
    loads, begin, end, work = step.model.loads, step.state.time, step.state.time + step.dt, 0.0
    if step.soil is not None:
        soil = step.model.soil.constants
        work = loads.work(begin, end, soil.mass, soil.position, points.position - step.state.points.position)
    mean = 0.5 * (loads.on_bodies(begin) + loads.on_bodies(end)) - loads.gravity
    return work + sum(one.body.mass.mass * float(mean @ (bodies[one.number].position - one.state.position))
                      for one in step.bodies)
