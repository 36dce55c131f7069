"""Newton's method on the equations of one increment, with a backtracking line search where whole updates fail.

    first guess                                   `hybrid.step.first_guess`
    whole updates, u <- u + δ with K δ = -R       `hybrid.step.iteration`
    the same, with a tangent that does not soften     where these make no progress
    shorter updates, s δ with s = 1, 1/2, ... 1/16    where those make none either
    judged, or rejected                               what ends above the tolerance, and what a step must not accept

The residual of soil that rotates or yields rises or hardly falls before it falls: a line search from the start takes up
to four times the iterations. So whole updates, s = 1, are taken as long as they make progress, and shorter ones from
the best iterate after that (a watchdog: Chamberlain et al., Math. Program. Study 16 (1982) 1-17). In between, where a
body has convex edges, whole updates with a tangent that does not soften (`hybrid.contact.assembly.without_softening`):
soil that slides off an edge has no equilibrium on the way. Without inertia all updates far from the solution are made with
that tangent (`hybrid.step.iteration.FAR`). Clay that flows around a pipe needs shorter updates in every
increment: where soil yields, an increment that comes after such a one begins with them.
"""

from dataclasses import replace

from hybrid.runtime import comm
from hybrid.soil.model import Refusal
from hybrid.step.equations import Step
from hybrid.step.first_guess import first_evaluation, landed, starts
from hybrid.step.iteration import PATIENCE, Outcome, Updates, iterate

# Whole updates are given up sooner than PATIENCE, because shorter ones are tried then. Iterations of four collapses of
# clay: 3: 1014, 5: 620, 8: 593; of pipes pushed into clay, a fifth more with 5 than with shorter updates from the
# start.
TRIAL = 5
# Errors that are accepted when progress has ended: HAIR times the tolerance, or ROUGH where the residual is round-off.
HAIR, ROUGH = 3.0, 1e-3
# A corner may be carried by a facet whose overlap differs from that with the nearest one by this share (1e-5 to 1e-2 in
# spheres that roll over rows of corners); it is tried with HOLDS sets of facets.
AMBIGUOUS, HOLDS = 0.05, 5
# The same share in short increments, which then count as judged. A corner between two facets, of which the one
# that carries it is never the nearest, has no other solution at any length; it is one of hundreds (the anchor, step 124).
BETWEEN = 1.0
# Where points of clay come into contact or part in an increment, and the adhesion that those in contact bear changes by
# more than SHARED of it, it is shared among them anew and solved for again, once.
SHARED = 0.05


def solve(step: Step, short=False, shorten=False):
    """Outcome of Newton's method on `step`. Never raises for lack of convergence. short: whether the increment is so short
    that a corner may be carried BETWEEN facets; shorten: whether to begin with shorter updates."""
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
    outcome = Outcome(None, 0, 0, ())
    for start in starts(step, evaluation):
        outcome = outcome.followed_by(_solution(step, solver, start, shorten, BETWEEN if short else AMBIGUOUS))
        if outcome.converged:
            break
    if not outcome.converged:
        return outcome
    if step.share_interface(outcome.evaluation) > SHARED:
        outcome = _shared(step, solver, outcome)
    return replace(outcome, reason=rejection(step, outcome.evaluation))


def _shared(step, solver, outcome):
    """`outcome` with the adhesion of clay shared among the points that touch in it; as it is where that has no solution."""
    again = _solution(step, solver, step.evaluate(outcome.evaluation.unknowns))
    if again.converged:
        return outcome.followed_by(again)
    step.restore_interface()
    return again.followed_by(replace(outcome, evaluation=step.evaluate(outcome.evaluation.unknowns)))


def _solution(step, solver, evaluation, shorten=False, ambiguous=AMBIGUOUS):
    """Outcome from an evaluation. Where corners jump between facets they are held (`hybrid.contact.held_facets`), and may be
    carried by one whose overlap differs from that with the nearest one by a share of `ambiguous`."""
    step.release_facets()
    outcome, held = _newton(step, solver, evaluation, shorten), None
    for _ in range(HOLDS):
        if outcome.converged and step.facet_error(outcome.evaluation) <= ambiguous or not (
                outcome.converged or outcome.jumping):
            break
        step.release_facets()
        before, held = held, step.hold_facets(step.evaluate(outcome.evaluation.unknowns))
        if not outcome.converged and before and not any(comm.anywhere(a != b) for a, b in zip(before, held)):
            break       # the same facets, with which there was no solution
        start = step.evaluate(outcome.evaluation.unknowns)
        outcome = outcome.followed_by(iterate(step, solver, start, Updates(PATIENCE, solver.line_search)))
    else:
        if outcome.converged and step.facet_error(outcome.evaluation) > ambiguous:
            return replace(outcome, reason=f"corners of the soil jump between facets of a body, {HOLDS} times")
    if outcome.converged:
        return replace(outcome, judged=outcome.judged or step.facet_error(outcome.evaluation) > AMBIGUOUS)
    return outcome if outcome.evaluation is None else _judge(step, solver, outcome)


def _judge(step, solver, outcome):
    """`outcome` of a solution that made no progress any more, converged where its residual is a hair above the
    tolerance, or within round-off of the soil's stiffness and small beside the forces acting."""
    best = step.evaluate(outcome.evaluation.unknowns)
    if step.facet_error(best) > AMBIGUOUS:
        return outcome
    if best.error <= HAIR * solver.tolerance or best.error <= ROUGH and step.within_rounding(best):
        return replace(outcome, evaluation=best, reason="", judged=True)
    return outcome


def _newton(step, solver, evaluation, shorten=False):
    """Outcome with whole updates; where they make no progress, from the best iterate with those of a tangent that does not
    soften where convex edges press the soil; and then with shorter ones. shorten: whether to try these first."""
    whole = TRIAL if solver.line_search else PATIENCE
    if shorten and solver.line_search:
        outcome = iterate(step, solver, evaluation, Updates(PATIENCE, shorten=True))
        if outcome.converged:
            return outcome
        return outcome.followed_by(_newton(step, solver, step.evaluate(evaluation.unknowns)))
    outcome = iterate(step, solver, evaluation, Updates(whole))
    for updates in (Updates(whole, softening=False), Updates(PATIENCE, shorten=True)):
        if outcome.converged:
            break
        near = outcome.evaluation.error <= HAIR * solver.tolerance      # accepted as it is, shorter updates gain nothing
        useful = solver.line_search and not near if updates.shorten else step.softened(outcome.evaluation)
        if useful:
            best = step.evaluate(outcome.evaluation.unknowns)
            outcome = outcome.followed_by(iterate(step, solver, best, updates))
    return outcome


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
