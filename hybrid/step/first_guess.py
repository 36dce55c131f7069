"""Where Newton's method starts from in an increment: DESIGN, "First guess of a step".

    at constant velocities              where there is inertia, unless that opens the soil; else soil at rest
    soil at rest                        with inertia, in long steps where that leads nowhere and soil yields
    bodies put down on the soil         without inertia, where free bodies touch nothing, or hardly
    the best of these                   without inertia, if it leaves less of the residual than soil at rest
        soil that follows the bodies        where these leave points that touched before
        the last increment extrapolated     where soil yields
        both
"""

from contextlib import ExitStack
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from hybrid.runtime.comm import anywhere
from hybrid.runtime.errors import StepError
from hybrid.soil.model import Refusal
from hybrid.step.iteration import elastic_share

# Share of the points that touched from which on a body leaves the soil behind in the first guess of a quasi-static
# increment.
SEPARATED = 0.1
# A body is put down to FINE cells; its contact is looked for at PACES of a cell.
FINE, PACES = 1e-12, 16
# Share of the soil at the apex, from which the predictor is no good start. Sand that opens everywhere has no tangent:
# a block that its own weight throws up takes 3 iterations from rest, and 5 to 15 from the predictor if it converges at
# all (share 0.15 to 0.92). In front of an anchor the share is 0.02; 60 steps from rest take a third more iterations.
OPENED = 0.1
# Share of the error of soil at rest below which another start is better (0.8 to 0.95 take as many iterations, within
# what they scatter by), and error from which on it is looked for.
LESS, NEAR = 0.9, 0.05
# Cells that a wave crosses in a step in which inertia hardly counts: that of a cell is a two-thousandth of its stiffness.
LONG = 50.0


def first_evaluation(step):
    """Evaluation to start from, or a Refusal: at constant velocities, or with soil at rest where those open it."""
    moving = step.evaluate(step.predictor())
    if isinstance(moving, Refusal) or not step.model.scheme.inertia:
        return moving
    opened = step.apex_fraction(moving)
    if opened < OPENED:
        return moving
    resting = step.evaluate(step.driven(), keep=moving)
    if isinstance(resting, Refusal) or step.apex_fraction(resting) >= opened - OPENED:
        return moving
    return resting


def lowered_to_contact(step, evaluation):
    """Evaluation with free bodies that touch nothing, or hardly, put down on soil that does not move: their weight, which
    no contact resists yet, would press them into it by a part of a cell."""
    unsupported = [number for number, terms in enumerate(evaluation.bodies) if terms.unsupported and terms.residual.any()]
    if not unsupported:
        return evaluation
    unknowns = evaluation.unknowns
    for number in unsupported:
        unknowns = _lowered(step, unknowns, number)
    return step.evaluate(unknowns)


def _lowered(step, unknowns, number):
    """Unknowns after a body has gone the way that what is out of balance pushes it, by a cell at most, until contact bears
    that; as they are where nothing does."""
    free, nodes = step.bodies[number].free[:3], unknowns.displacement

    def moved(way):
        poses = list(unknowns.poses)
        poses[number] = poses[number][0] + way, poses[number][1]
        return replace(unknowns, poses=tuple(poses))

    def unborne(way):
        at = moved(way)
        joints = step.joints and step.joints.evaluate(at.poses, at.multipliers)
        pairs = step.pairs and step.pairs.evaluate(at.poses)
        terms = step.bodies[number].evaluate(at, None if nodes is None else np.zeros_like(nodes), joints, pairs)
        return -np.where(free, terms.total[:3], 0.0)

    push, cell = unborne(np.zeros(3)), step.model.soil.grid.smallest_cell
    if not push.any():
        return unknowns
    push /= np.linalg.norm(push)

    def along(way):
        return unborne(way * push) @ push

    for way in np.linspace(0.0, cell, PACES + 1)[1:]:     # farther on, contact with its back may push it on
        if along(way) <= 0.0:
            return moved(brentq(along, way - cell / PACES, way, xtol=FINE * cell, rtol=FINE) * push)
    return unknowns


def starts(step, evaluation):
    """Evaluations to start from in turn, until one leads to the solution: without inertia the best of the `candidates`,
    where soil yields if it leaves less than LESS of the error; `evaluation`, the first guess; and with inertia soil at rest,
    where it yields, in a LONG step: soil that flows on is no guess there."""
    unknowns, error, yields = evaluation.unknowns, evaluation.error, step.model.soil.law.plastic
    resting = not step.model.scheme.inertia and step.soil is not None
    leave, far = resting and _separates(evaluation), resting and yields and error > NEAR
    if leave or far:
        left, best = min(candidates(step, evaluation, leave, far), key=lambda found: found[0], default=(np.inf, None))
        if best and (left < LESS * error or not yields):
            yield step.evaluate(best)
        evaluation = step.evaluate(unknowns)
    yield evaluation
    if step.model.scheme.inertia and step.soil is not None and yields and step.cells_crossed() > LONG and (
            anywhere(unknowns.displacement)):
        slow = step.evaluate(step.driven())
        if not isinstance(slow, Refusal):
            yield slow


def candidates(step, evaluation, leave, far):
    """(error, Unknowns) of states that may be nearer to the solution than `evaluation`, whose soil is at rest. leave:
    whether bodies leave points that touched; far: whether soil yields, and is far from the solution.

    Soil that yields is elastic at rest for the tangent, until an update has strained it too far; moved on as in the last
    increment, it flows from the first tangent on.
    """
    if leave and (found := followed(step, evaluation)):
        yield found.error, found.unknowns
    extrapolated = step.evaluate(step.extrapolated()) if far else None
    if far and not isinstance(extrapolated, Refusal):
        yield extrapolated.error, extrapolated.unknowns
        if found := followed(step, extrapolated):
            yield found.error, found.unknowns


def _separates(evaluation):
    """Whether SEPARATED or more of the points that touched before no longer touch."""
    before, separated = np.sum([terms.step.pair.separated(terms.contact) for terms in evaluation.bodies] or [(0, 0)], axis=0)
    return separated > SEPARATED * before


def followed(step, evaluation):
    """Evaluation where soil has followed bodies that leave it: an update from `evaluation` in which the points that touched
    pull. None where there is no such update.

    With the soil still where it was, a body leaves it as soon as it moves farther than its springs are pressed: Newton's
    method would start from soil that nothing supports, or from a body on one or two of eighty points, whose tangent
    throws it off. The points that carried it before are an active set near that of the solution.
    """
    unknowns = evaluation.unknowns
    with ExitStack() as contacts:
        for terms in evaluation.bodies:
            contacts.enter_context(terms.step.pair.bilateral())
        try:
            start = step.evaluate(unknowns)
            step.assemble(start, elastic=elastic_share(step, start.error))
            soil, body, _ = step.system.solve(start.soil, start.body, step.model.solver.linear_tolerance)
        except StepError:
            return None
    new = step.evaluate(step.moved(unknowns, soil, body))
    return None if isinstance(new, Refusal) else new
