"""Newton's method on the equations of one increment, with a backtracking line search where whole updates fail.

    K δ = -R      u <- u + s δ      s = 1, 1/2, ... 1/16, until |R| falls enough      while |R| > tolerance

The residual of soil that rotates or yields rises or hardly falls before it falls: a line search from the start takes up
to four times the iterations. So whole updates, s = 1, are taken as long as they make progress, and shorter ones from the
best iterate after that (a watchdog: Chamberlain et al., Math. Program. Study 16 (1982) 1-17). In between, where a body has
convex edges, whole updates with a tangent that does not soften (`hybrid.contact.assembly.without_softening`): soil that
slides off an edge has no equilibrium on the way. Where an update leaves most of the residual in a few nodes, these are
solved for by themselves before the next one (`hybrid.step.restriction`). Contact points that an update carries from slip in
one direction to slip in the other are held in stick for the next one (`hybrid.contact.reversals`).

The linear systems K δ = -R are solved to FORMULATION (48). The settings are those of the scene, `hybrid.scene.Solver`.
"""

from contextlib import ExitStack
from dataclasses import dataclass, replace

import numpy as np

from hybrid.contact import held_facets
from hybrid.runtime import comm
from hybrid.runtime.errors import StepError
from hybrid.runtime.timing import phase
from hybrid.soil.model import Refusal
from hybrid.step.equations import Evaluation, Step
from hybrid.step.restriction import restricted, rough_nodes, with_bodies_alone

SHORTEST = 1 / 16  # of a Newton update, tried by the line search
# Share of the points that touched from which on a body leaves the soil behind in the first guess of a quasi-static increment.
PARTED = 0.1
# An update that leaves less than this share of the residual is taken as it is (anchor, 60 steps: 391 iterations and 402
# evaluations; with 0.7 they are 463 and 571, and Krylov iterations grow by a tenth).
ENOUGH = 0.8
# Share of the soil at the apex, from which the predictor is no good start. Sand that opens everywhere has no tangent:
# a block that its own weight throws up takes 3 iterations from rest, and 5 to 15 from the predictor if it converges at
# all (share 0.15 to 0.92). In front of an anchor the share is 0.02; 60 steps from rest take a third more iterations.
OPENED = 0.1
# Stiff contact dominates the linear residual, so a loose Krylov tolerance leaves the soil unconverged and can open
# contacts spuriously: the tolerance is divided by (stiffness of contact) h / (STIFF E), but not below FINEST.
STIFF, FINEST = 80.0, 1e-12
# Share of the tolerance that a linear system may leave of the residual: it is not solved farther than that, near the end of an
# increment, but to COARSEST at least (anchor, 45 steps: 1 055 Krylov iterations instead of 1 257, 179 Newton's instead of 178).
LEFT, COARSEST = 0.1, 0.1
# An increment is given up when the smallest error of the last PATIENCE iterations is not below FALL of the smallest one
# before; MOST is a guard only. In long steps of a collapse point after point yields, and the residual falls slowly.
PATIENCE, FALL, MOST = 10, 0.8, 100
# The same for whole updates, before shorter ones are tried. Iterations of four collapses of clay: 3: 1014, 5: 620, 8: 593;
# of pipes pushed into clay, a fifth more with 5 than with shorter updates from the start.
TRIAL = 5
# A whole update has gone astray that makes the error ASTRAY times the smallest one, and LOST or more: soil has opened that was
# not to open, and a tangent there takes a thousand Krylov iterations.
ASTRAY, LOST = 20.0, 0.3
# Errors that are accepted when progress has ended: HAIR times the tolerance, or ROUGH where the residual is round-off.
HAIR, ROUGH = 3.0, 1e-3
# Nodes that carry most of the residual are solved for by themselves where an update leaves more than SLOW of it, until
# SMOOTH of theirs is left or BRIEF iterations make no progress.
SLOW, SMOOTH, BRIEF = 0.5, 0.1, 4
# A corner may be carried by a facet whose overlap differs from that with the nearest one by this share (1e-5 to 1e-2 in
# spheres that roll over rows of corners); it is tried with HOLDS sets of facets.
AMBIGUOUS, HOLDS = 0.05, 5
# Where points of clay come into contact or part in an increment, and the adhesion that those in contact bear changes by more than
# SHARED of it, it is shared among them anew and solved for again, once.
SHARED = 0.05
# A tangent is used again where its update leaves less than this share of the residual: GOOD_YIELDING for soil that
# yields (anchor, 60 steps: 383 to 401 iterations with 0.15, 259 to 269 with 0.01), GOOD for elastic soil, which then
# assembles half as often.
GOOD, GOOD_YIELDING = 0.15, 0.01


@dataclass(frozen=True)
class Updates:
    """How updates are made: until `patience` of them make no progress; shorten: with a line search, else whole; smooth: with
    few rough nodes solved for by themselves; softening: by the tangent with the softening of contact at convex edges."""

    patience: int
    shorten: bool = False
    smooth: bool = True
    softening: bool = True


@dataclass(frozen=True)
class Outcome:
    """evaluation: of the smallest error, None when none exists; reason: empty when converged, else why there is no
    solution; judged: whether it converged to a bound beyond the tolerance (`_judge`); jumping: whether corners went to
    and fro between facets when progress ended."""

    evaluation: Evaluation | None
    iterations: int
    krylov: int
    errors: tuple[float, ...]
    reason: str = ""
    judged: bool = False
    jumping: bool = False

    @property
    def converged(self):
        return not self.reason

    def followed_by(self, other):
        """Outcome of two solutions of an increment, the `other` one the later."""
        return replace(other, iterations=self.iterations + other.iterations, krylov=self.krylov + other.krylov,
                       errors=self.errors + other.errors, judged=self.judged or other.judged)


def solve(step: Step, follow=False):
    """Outcome of Newton's method on `step`. Never raises for lack of convergence. follow: whether to try soil that has followed
    bodies (`followed`) where the first guess fails."""
    solver = step.model.solver
    if reason := step.rotation_too_large():
        return Outcome(None, 0, 0, (), reason)
    if step.pairs and step.pairs.hasty:
        return Outcome(None, 0, 0, (), step.pairs.hasty)
    evaluation = first_evaluation(step)
    if isinstance(evaluation, Refusal):
        return Outcome(None, 0, 0, (), f"the first guess {evaluation.reason}")
    if not step.model.scheme.inertia:   # the first guess is then at rest
        evaluation = landed(step, evaluation)
        step = replace(step, reference=evaluation.internal)
    start = evaluation.unknowns
    outcome = _solution(step, solver, evaluation)
    if follow and not outcome.converged and not step.model.scheme.inertia and (evaluation := followed(step, start)):
        outcome = outcome.followed_by(_solution(step, solver, evaluation))
    if outcome.converged and step.share_interface(outcome.evaluation) > SHARED:
        again = _solution(step, solver, step.evaluate(outcome.evaluation.unknowns))
        if again.converged:
            outcome = outcome.followed_by(again)
        else:
            step.restore_interface()
            outcome = again.followed_by(replace(outcome, evaluation=step.evaluate(outcome.evaluation.unknowns)))
    return replace(outcome, reason=rejection(step, outcome.evaluation)) if outcome.converged else outcome


def first_evaluation(step):
    """Evaluation to start from, or a Refusal: at constant velocities, or at rest where those open the soil."""
    moving = step.evaluate(step.predictor())
    if isinstance(moving, Refusal) or not step.model.scheme.inertia:
        return moving
    opened = step.apex_fraction(moving)
    if opened < OPENED:
        return moving
    resting = step.evaluate(step.at_rest(), keep=moving)
    if isinstance(resting, Refusal) or step.apex_fraction(resting) >= opened - OPENED:
        return moving
    return resting


def landed(step, evaluation):
    """Evaluation with free bodies that touch nothing put down on soil that does not move: their weight, which no contact resists
    yet, would press them into it by a part of a cell."""
    if not any(not comm.anywhere([len(terms.contact)]) and terms.residual.any() for terms in evaluation.bodies):
        return evaluation
    part = with_bodies_alone(step)
    try:
        outcome = _iterate(part, step.model.solver, part.evaluate(evaluation.unknowns), Updates(PATIENCE, smooth=False))
    finally:
        part.system.destroy()
    return step.evaluate((outcome.evaluation if outcome.converged else evaluation).unknowns)


def followed(step, unknowns):
    """Evaluation where soil has followed bodies that are drawn back from it: an update from `unknowns` in which the points that
    touched pull. None where hardly any of them part, or there is no such update.

    With the soil still where it was, a body leaves it as soon as it moves farther than its springs are pressed, and Newton's
    method starts from soil that nothing supports.
    """
    evaluation = step.evaluate(unknowns)
    before, parted = np.sum([terms.step.pair.parted(terms.contact) for terms in evaluation.bodies] or [(0, 0)], axis=0)
    if parted <= PARTED * before:
        return None
    with ExitStack() as bonds:
        for terms in evaluation.bodies:
            bonds.enter_context(terms.step.pair.bonded())
        try:
            start = step.evaluate(unknowns)
            step.assemble(start)
            soil, body, _ = step.system.solve(start.soil, start.body, step.model.solver.linear_tolerance)
        except StepError:
            return None
    new = step.evaluate(step.moved(unknowns, soil, body))
    return None if isinstance(new, Refusal) else new


def _solution(step, solver, evaluation):
    """Outcome from an evaluation. Where corners jump between facets they are held (`hybrid.contact.held_facets`)."""
    step.release_facets()
    outcome, held = _newton(step, solver, evaluation), None
    for _ in range(HOLDS):
        if outcome.converged and step.facet_error(outcome.evaluation) <= AMBIGUOUS or not (
                outcome.converged or outcome.jumping):
            break
        step.release_facets()
        before, held = held, step.hold_facets(step.evaluate(outcome.evaluation.unknowns))
        if not outcome.converged and before and not any(comm.anywhere(a != b) for a, b in zip(before, held)):
            break       # the same facets, with which there was no solution
        start = step.evaluate(outcome.evaluation.unknowns)
        outcome = outcome.followed_by(_iterate(step, solver, start, Updates(PATIENCE, solver.line_search)))
    else:
        if outcome.converged and step.facet_error(outcome.evaluation) > AMBIGUOUS:
            return replace(outcome, reason=f"corners of the soil jump between facets of a body, {HOLDS} times")
    return outcome if outcome.converged or outcome.evaluation is None else _judge(step, solver, outcome)


def _judge(step, solver, outcome):
    """`outcome` of a solution that made no progress any more, converged where its residual is a hair above the
    tolerance, or within round-off of the soil's stiffness and small beside the forces acting."""
    best = step.evaluate(outcome.evaluation.unknowns)
    if step.facet_error(best) > AMBIGUOUS:
        return outcome
    if best.error <= HAIR * solver.tolerance or best.error <= ROUGH and step.within_rounding(best):
        return replace(outcome, evaluation=best, reason="", judged=True)
    return outcome


def progressing(errors, patience=PATIENCE):
    """Whether the smallest of the `errors` has fallen below FALL of itself within the last `patience` iterations."""
    return len(errors) <= patience or min(errors[-patience:]) < FALL * min(errors[:-patience])


def _newton(step, solver, evaluation):
    """Outcome with whole updates; where they make no progress, from the best iterate with those of a tangent that does not
    soften where convex edges press the soil; and then with shorter ones."""
    whole = TRIAL if solver.line_search else PATIENCE
    outcome = _iterate(step, solver, evaluation, Updates(whole))
    for updates in (Updates(whole, softening=False), Updates(PATIENCE, shorten=True)):
        if outcome.converged:
            break
        near = outcome.evaluation.error <= HAIR * solver.tolerance      # accepted as it is; shorter updates gain nothing there
        useful = solver.line_search and not near if updates.shorten else step.softened(outcome.evaluation)
        if useful:
            best = step.evaluate(outcome.evaluation.unknowns)
            outcome = outcome.followed_by(_iterate(step, solver, best, updates))
    return outcome


def _iterate(step, solver, evaluation, updates):
    errors, krylov, current, jumps = [], 0, False, []
    forcing = max(solver.linear_tolerance / max(1.0, step.contrast() / STIFF), FINEST)
    good = GOOD_YIELDING if step.model.soil.law.plastic else GOOD
    best, turned = evaluation, None
    while True:
        iteration = len(errors)
        errors.append(evaluation.error)
        best = evaluation if evaluation.error < best.error else best
        if evaluation.error <= solver.tolerance:
            return Outcome(evaluation, iteration, krylov, tuple(errors))
        astray = not updates.shorten and solver.line_search and evaluation.error > max(ASTRAY * best.error, LOST)
        if iteration == MOST or astray or not progressing(errors, updates.patience):
            break
        try:
            held = step.held_in_stick(evaluation, turned) if turned else evaluation
            if turned or not current:
                step.assemble(held, updates.softening)
            with phase("solve"):
                soil, body, count = step.system.solve(held.soil, held.body, linear_tolerance(solver, forcing, held.error))
        except StepError as failure:
            return Outcome(best, iteration, krylov, tuple(errors), str(failure))
        krylov += count
        before, trial = evaluation, line_search(step, evaluation, soil, body, updates.shorten)
        evaluation = trial
        if isinstance(evaluation, Refusal):
            return Outcome(best, iteration, krylov, tuple(errors), f"the update {evaluation.reason}")
        if updates.smooth and evaluation.error > max(SLOW * errors[-1], solver.tolerance):
            evaluation = smoothed(step, solver, evaluation, updates.softening)
        turned = step.reversals(before, evaluation, turned)
        # corners sent to another facet by the update and back by what smooths it jump as well
        jumps.append(jumped(before, trial) or evaluation is not trial and jumped(before, evaluation))
        # assembling and factoring the soil block costs several solutions; the bodies' few unknowns cost nothing
        current = bool(step.system.soil_unknowns) and evaluation.error < good * errors[-1]
    return Outcome(best, iteration, krylov, tuple(errors),
                   f"residual {best.error:.2e} after {iteration} iterations"
                   f"{'' if progressing(errors, updates.patience) else f' without progress in the last {updates.patience}'}, "
                   f"tolerance {solver.tolerance:.0e} ({_with_units(best.norms)})",
                   jumping=sum(jumps[-updates.patience:]) > 1)


def jumped(before, after):
    """Whether corners have left or reached plane facets between two evaluations of a step."""
    return any(held_facets.switched(a, b, terms.step.body.surface)
               for terms, a, b in zip(before.bodies, before.contacts, after.contacts))


def linear_tolerance(solver, finest, error):
    """Relative tolerance of a linear system whose right-hand side is the residual of this `error`: `finest`, as a rule, or
    in the same proportion what leaves LEFT of the tolerance."""
    enough = LEFT * solver.tolerance / error
    return max(finest, min(COARSEST, finest / solver.linear_tolerance * enough))


def smoothed(step, solver, evaluation, softening=True):
    """Evaluation after the few nodes that carry most of its residual, and the bodies, have been solved for by themselves
    (`hybrid.step.restriction`); `evaluation` itself where they are not few, or have no better solution."""
    nodes = rough_nodes(step, evaluation)
    if nodes is None:
        return evaluation
    part = restricted(step, nodes, evaluation)
    try:
        start = part.evaluate(evaluation.unknowns)
        aim = max(SMOOTH * start.error, solver.tolerance)
        outcome = _iterate(part, replace(solver, tolerance=aim), start, Updates(BRIEF, True, False, softening))
    finally:
        part.system.destroy()
    new = step.evaluate(outcome.evaluation.unknowns)
    return new if not isinstance(new, Refusal) else step.evaluate(evaluation.unknowns)


def _with_units(norms):
    """Text such as "soil 0.879 N, anchor 12 N m" from norms {"soil [N]": 0.879, "anchor [N m]": 12}."""
    parts = ((*key.removesuffix("]").rsplit(" [", 1), value) for key, value in norms.items())
    return ", ".join(f"{name} {value:.3g} {unit}" for name, unit, value in parts)


def rejection(step, evaluation):
    """Why a converged increment must not be accepted: it is too long for its rotations or its contact search to be
    right. Empty if it may be."""
    if reason := step.rotation_too_large(evaluation.unknowns):
        return reason
    ratio = step.search_radius_ratio(evaluation.unknowns)
    if ratio > 1:
        return f"soil and body moved {ratio:.1f} times farther than the contact search allows for"
    if reason := step.pairs and step.pairs.rejection(evaluation.pairs, step.bodies):
        return reason
    count = step.tunnelled(evaluation)
    return f"{count} corners of the soil passed through a body" if count else ""


def line_search(step, old, soil, body, shorten):
    """First evaluation along the update (soil, body) that lowers the error by enough, else the best of those tried; a
    Refusal where none exists. shorten: False takes the full update if it has an evaluation.

    Where sand opens and closes, full updates overshoot the solution alternately: each lowers the error a little, half
    of one by a lot. So an update that gains little is tried shorter.
    """
    scale, best, refusal = 1.0, None, Refusal("gives no finite residual")
    while scale >= SHORTEST:
        new = step.evaluate(step.moved(old.unknowns, soil, body, scale), keep=best)
        if isinstance(new, Refusal):
            refusal, error = new, float("inf")
        elif not shorten or new.error < ENOUGH * old.error:
            return new
        else:
            error = new.error
        if best is not None and best.error < min(error, old.error):     # the minimum has been passed
            break
        if error < (float("inf") if best is None else best.error):
            best = new
        scale /= 2
    return refusal if best is None else best
