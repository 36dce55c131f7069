"""Newton's method on the equations of one increment, with backtracking where full updates fail.

    first guess                                   `hybrid.step.first_guess`
    full updates, u <- u + δ with K δ = -R        `hybrid.step.iteration`
    the same, with a tangent that does not soften     where these make no progress
    backtracking, s δ with s = 1, 1/2, ... 1/16       where those make none either
    all of them, with the ramp of adhesion in K       where points are on it: a rod turned in clay without weight
    judged, or rejected                               what ends above the tolerance, and what a step must not accept

The residual of soil that rotates or yields rises or hardly falls before it falls: a line search from the start takes up
to four times the iterations. So full updates, s = 1, are taken as long as they make progress, and backtracking begins from
the best iterate after that (a watchdog: Chamberlain et al., Math. Program. Study 16 (1982) 1-17). In between, where a
body has convex edges, full updates with a tangent that does not soften (`hybrid.contact.assembly.Tangent`):
soil that slides off an edge has no equilibrium on the way. Without inertia all updates far from the solution are made with
that tangent (`hybrid.step.iteration.FAR`). Clay that flows around a pipe needs backtracking in every increment: where soil
yields, an increment that comes after such a one begins with it.
"""

from dataclasses import replace

from hybrid.contact.assembly import Tangent
from hybrid.runtime import comm
from hybrid.soil.model import Refusal
from hybrid.step import contacts
from hybrid.step.equations import Step
from hybrid.step.first_guess import first_evaluation, lowered_to_contact, starts
from hybrid.step.iteration import PATIENCE, Outcome, Updates, iterate
from hybrid.step.rejection import rejection, rotation_too_large

# Full updates are given up sooner than PATIENCE, because backtracking is tried then. Iterations of four collapses of
# clay: 3: 1014, 5: 620, 8: 593; of pipes pushed into clay, a fifth more with 5 than with backtracking from the start.
TRIAL = 5
# Errors accepted when progress has ended: RELAXED times the tolerance, or AT_ROUND_OFF where the residual is round-off.
RELAXED, AT_ROUND_OFF = 3.0, 1e-3
# A contact point may be carried by a facet whose overlap differs from that with the nearest one by this share (1e-5 to
# 1e-2 in spheres that roll over rows of points); it is tried with HOLDS sets of facets.
AMBIGUOUS, HOLDS = 0.05, 5
# The same share in short increments, which then count as judged. A point between two facets, of which the one
# that carries it is never the nearest, has no other solution at any length; it is one of hundreds (the anchor, step 124).
BETWEEN = 1.0
# Where points of clay come into contact or part in an increment, and the adhesion that those in contact bear changes by
# more than SHARED of it, it is shared among them anew and solved for again, once.
SHARED = 0.05
NOTHING = Outcome(None, 0, 0, ())   # tried yet


def solve(step: Step, short=False, backtrack=False):
    """Outcome of Newton's method on `step`. Never raises for lack of convergence. short: whether the increment is so short
    that a contact point may be carried BETWEEN facets; backtrack: whether to begin with backtracking."""
    if reason := rotation_too_large(step):
        return replace(NOTHING, reason=reason)
    if step.pairs and step.pairs.too_long:
        return replace(NOTHING, reason=step.pairs.too_long)
    evaluation = first_evaluation(step)
    if isinstance(evaluation, Refusal):
        return replace(NOTHING, reason=f"the first guess {evaluation.reason}")
    if not step.model.scheme.inertia:   # the first guess is then at rest
        evaluation = lowered_to_contact(step, evaluation)
        step = replace(step, reference=evaluation.internal)
    outcome, ambiguous = NOTHING, BETWEEN if short else AMBIGUOUS
    for start in starts(step, evaluation):
        outcome = outcome.followed_by(_solution(step, start, ambiguous, backtrack))
        if outcome.converged:
            break
        contacts.release_facets(step)
    if not outcome.converged and short and step.model.solver.line_search:
        start = step.evaluate(evaluation.unknowns)
        outcome = outcome.followed_by(iterate(step, start, Updates(PATIENCE, may_diverge=True)))
    if not outcome.converged:
        return outcome
    change = contacts.share_interface(outcome.evaluation)
    if change > SHARED:
        outcome = _shared(step, outcome, ambiguous)
    return replace(outcome, reason=rejection(step, outcome.evaluation, short)) if outcome.converged else outcome


def _shared(step, outcome, ambiguous):
    """`outcome` with the adhesion of clay shared among the points that touch in it; as it is where that has no solution.
    ambiguous: as in `_solution`."""
    unknowns, error = outcome.evaluation.unknowns, outcome.evaluation.error
    contacts.release_facets(step)
    again = _solution(step, step.evaluate(unknowns), ambiguous)
    if again.converged:
        return outcome.followed_by(again)
    contacts.restore_interface(step)
    before = step.evaluate(unknowns)
    if before.error > max(error, step.model.solver.tolerance):     # with other facets than those with which it converged
        return outcome.followed_by(again)
    return again.followed_by(replace(outcome, evaluation=before))


def _solution(step, evaluation, ambiguous, backtrack=False):
    """Outcome from an evaluation. Where contact points jump between facets they are held (`hybrid.contact.held_facets`), and
    may be carried by one whose overlap differs from that with the nearest one by a share of `ambiguous`."""
    contacts.release_facets(step)
    outcome, held = _newton(step, evaluation, backtrack), None
    for _ in range(HOLDS):
        if outcome.converged and contacts.facet_error(outcome.evaluation) <= ambiguous:
            break
        if not outcome.converged and not outcome.jumping:
            break
        contacts.release_facets(step)
        before, held = held, contacts.hold_facets(step.evaluate(outcome.evaluation.unknowns))
        if not outcome.converged and before and not any(comm.anywhere(a != b) for a, b in zip(before, held)):
            break       # the same facets, with which there was no solution
        start = step.evaluate(outcome.evaluation.unknowns)
        outcome = outcome.followed_by(iterate(step, start, Updates(PATIENCE, step.model.solver.line_search)))
    else:
        if outcome.converged and contacts.facet_error(outcome.evaluation) > ambiguous:
            return replace(outcome, reason=f"contact points jump between facets of a body, {HOLDS} times")
    if outcome.converged:
        return replace(outcome, judged=outcome.judged or contacts.facet_error(outcome.evaluation) > AMBIGUOUS)
    return outcome if outcome.evaluation is None else _judge(step, outcome)


def _judge(step, outcome):
    """`outcome` of a solution that made no progress any more, converged where its residual is a hair above the
    tolerance, or within round-off of the soil's stiffness and small beside the forces acting."""
    best = step.evaluate(outcome.evaluation.unknowns)
    if contacts.facet_error(best) > AMBIGUOUS:
        return outcome
    if best.error <= RELAXED * step.model.solver.tolerance or best.error <= AT_ROUND_OFF and step.within_rounding(best):
        return replace(outcome, evaluation=best, reason="", judged=True)
    return outcome


def _newton(step, evaluation, backtrack=False):
    """Outcome of `_updates` without the ramp of adhesion in the tangent; where these have no solution and contact points are
    on it, with it, from the start again."""
    outcome = _updates(step, evaluation, backtrack)
    if outcome.converged or not contacts.on_adhesion_ramp(step, outcome.evaluation):
        return outcome
    again = _updates(step, step.evaluate(evaluation.unknowns), backtrack, Tangent.UNSOFTENED)
    return outcome.followed_by(again)


def _updates(step, evaluation, backtrack, far=Tangent.DEFINITE):
    """Outcome with full updates; where they make no progress, from the best iterate with those of a tangent that does not
    soften where convex edges press the soil; and then with backtracking. backtrack: whether to try this first; far: of
    Updates."""
    solver, yields = step.model.solver, step.model.soil.law.plastic
    search = solver.line_search
    full = Updates(TRIAL if search and yields else PATIENCE, far=far, may_diverge=not yields)
    careful, outcome = Updates(PATIENCE, backtrack=True, far=far), NOTHING
    if backtrack and search:
        outcome = iterate(step, evaluation, careful)
        if outcome.converged:
            return outcome
        evaluation = step.evaluate(evaluation.unknowns)
    outcome = outcome.followed_by(iterate(step, evaluation, full))
    if not outcome.converged and contacts.has_convex_contact(outcome.evaluation):
        outcome = _from_best(step, outcome, replace(full, near=far))
    if not outcome.converged and search and outcome.evaluation.error > RELAXED * solver.tolerance:   # else accepted
        outcome = _from_best(step, outcome, careful)
    return outcome


def _from_best(step, outcome, updates):
    """`outcome` followed by `updates` from its best iterate."""
    return outcome.followed_by(iterate(step, step.evaluate(outcome.evaluation.unknowns), updates))
