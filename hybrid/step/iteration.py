"""Updates of Newton's method on the equations of one increment, in one way, until they converge or make no progress.

    K δ = -R      u <- u + s δ      s = 1, or by backtracking 1, 1/2, ... 1/16 until |R| falls enough

K is the consistent tangent, without inertia with a share of the elastic one that vanishes with the residual (ELASTIC). The
first update is made with the tangent of the last increment while that serves (`CarriedTangent`). Where an update leaves
most of the residual in a few nodes, these are solved for by themselves before the next one (`hybrid.step.restriction`).
Contact points that such an update carries from slip in one direction to slip in the other are held in stick for the next one
(`hybrid.contact.reversals`). The linear systems K δ = -R are solved to FORMULATION (48).
The settings are those of the scene, `hybrid.scene.Solver`.
"""

from dataclasses import dataclass, replace

import numpy as np

from hybrid.contact import held_facets
from hybrid.contact.assembly import Tangent
from hybrid.runtime.errors import StepError
from hybrid.runtime.timing import phase
from hybrid.soil.model import Refusal
from hybrid.step import contacts, sticking
from hybrid.step.evaluation import Evaluation
from hybrid.step.restriction import restricted, rough_nodes

SHORTEST = 1 / 16  # of a Newton update, tried by the line search
# An update that leaves less than this share of the residual is taken as it is (anchor, 60 steps: 391 iterations and 402
# evaluations; with 0.7 they are 463 and 571, and Krylov iterations grow by a tenth).
ENOUGH = 0.8
# Stiff contact dominates the linear residual, so a loose Krylov tolerance leaves the soil unconverged and can open
# contacts spuriously: the tolerance is divided by (stiffness of contact) h / (STIFF E), but not below FINEST.
STIFF, FINEST = 80.0, 1e-12
# Share of the tolerance that a linear system may leave of the residual: it is not solved farther than that, near the
# end of an increment, but to COARSEST at least (anchor, 45 steps: 1 055 Krylov iterations instead of 1 257, 179
# Newton's instead of 178).
LEFT, COARSEST = 0.1, 0.1
# An increment is given up when the smallest error of the last PATIENCE iterations is not below FALL of the smallest one
# before; MOST is a guard only. In long steps of a collapse point after point yields, and the residual falls slowly.
PATIENCE, FALL, MOST = 10, 0.8, 100
# Full updates have diverged where the error is DIVERGED times the smallest one, and LOST or more: soil has opened
# that was not to open, and a tangent there takes a thousand Krylov iterations.
DIVERGED, LOST = 20.0, 0.3
# Share of the elastic tangent in that of soil that yields, times the error, without inertia: points change between no
# stiffness and their full one from one update to the next, and full updates go to and fro. With the factor of the error the
# end remains quadratic.
ELASTIC = 0.3
# Nodes that carry most of the residual are solved for by themselves where an update leaves more than SLOW of it, until
# SMOOTH of theirs is left or BRIEF iterations make no progress.
SLOW, SMOOTH, BRIEF = 0.5, 0.1, 4
# Without inertia the tangent of contact is definite (`hybrid.contact.assembly`) as long as the error is above FAR.
FAR = 0.05
# A tangent is used again where its update leaves less than this share of the residual: GOOD_YIELDING for soil that
# yields (anchor, 60 steps: 383 to 401 iterations with 0.15, 259 to 269 with 0.01), GOOD for elastic soil, which then
# assembles half as often.
GOOD, GOOD_YIELDING = 0.15, 0.01
# The next increment begins with the tangent of this one where the first update left less than SERVES and CALM updates were
# enough. One that is carried has failed where its update leaves more than is good for a second one.
SERVES, CALM = 0.3, 3


@dataclass(frozen=True)
class Updates:
    """How updates are made: until `patience` of them make no progress; backtrack: with a line search, else in full; smooth:
    with few rough nodes solved for by themselves; near, far: Tangent of contact near the solution and, without inertia, far
    from it (FAR); may_diverge: go on where they have DIVERGED."""

    patience: int
    backtrack: bool = False
    smooth: bool = True
    near: Tangent = Tangent.CONSISTENT
    far: Tangent = Tangent.DEFINITE
    may_diverge: bool = False


@dataclass(frozen=True)
class Outcome:
    """evaluation: of the smallest error, None when none exists; reason: empty when converged, else why there is no
    solution; judged: whether it converged to a bound beyond the tolerance (`_judge`), or with a contact point carried by a
    facet that is not the nearest (`AMBIGUOUS`); jumping: whether contact points jumped back and forth between facets when
    progress ended; backtracked: whether the line search took less than a full update."""

    evaluation: Evaluation | None
    iterations: int
    krylov: int
    errors: tuple[float, ...]
    reason: str = ""
    judged: bool = False
    jumping: bool = False
    backtracked: bool = False

    @property
    def converged(self):
        return not self.reason

    def followed_by(self, other):
        """Outcome of two solutions of an increment, the `other` one the later."""
        return replace(other, iterations=self.iterations + other.iterations, krylov=self.krylov + other.krylov,
                       errors=self.errors + other.errors, judged=self.judged or other.judged)


def iterate(step, evaluation, updates):
    """Outcome of `updates` from an evaluation."""
    safeguards, errors, krylov, best, backtracked = Safeguards(step, updates), [], 0, evaluation, False
    solver = step.model.solver

    def ended(evaluation, reason, **how):
        return Outcome(evaluation, len(errors) - 1, krylov, tuple(errors), reason, **how)

    while True:
        errors.append(evaluation.error)
        best = evaluation if evaluation.error < best.error else best
        if evaluation.error <= solver.tolerance:
            safeguards.keep_tangent(len(errors) - 1)
            return ended(evaluation, "", backtracked=backtracked)
        if len(errors) > MOST or not progressing(errors, updates.patience) or _diverged(evaluation, best, solver, updates):
            return ended(best, _no_progress(best, errors, solver, updates), jumping=safeguards.jumping())
        try:
            soil, body, count = safeguards.solve(evaluation)
        except StepError as failure:
            return ended(best, str(failure))
        krylov += count
        trial, scale = line_search(step, evaluation, soil, body, updates.backtrack)
        if safeguards.misled(evaluation, trial):
            evaluation = step.evaluate(evaluation.unknowns)
            continue
        if isinstance(trial, Refusal):
            return ended(best, f"the update {trial.reason}")
        backtracked = backtracked or scale < 1.0
        evaluation = safeguards.follow(evaluation, trial)


class Safeguards:
    """What helps updates along: the last tangent used again, also that of the last increment, contact points held in stick
    for an update, few rough nodes solved for by themselves; and whether contact points jump between facets."""

    def __init__(self, step, updates):
        self.step, self.updates, solver = step, updates, step.model.solver
        self.finest = max(solver.linear_tolerance / max(1.0, contacts.stiffness_ratio(step) / STIFF), FINEST)
        self.stick = None       # contact points held in stick in the next update
        self.reuse = False      # of the tangent in the next update
        self.carried = False    # whether the update is made with the tangent of the last increment
        self.first = None       # whether the tangent of the first update may serve the next increment
        self.jumps = []         # whether contact points jumped, for each update

    def solve(self, evaluation):
        """Update of soil (n,) and bodies (m,) by the linear equations at an evaluation, and its Krylov iterations. Raises
        StepError."""
        step = self.step
        self.stick = self.stick or sticking.drifting(step, evaluation)
        held = sticking.held_in_stick(step, evaluation, self.stick) if self.stick else evaluation
        ready = self.first is None and not self.stick and not self.updates.backtrack and step.system.soil_unknowns
        self.carried = bool(ready) and step.carried.take(step.dt)
        if self.stick or not (self.reuse or self.carried):
            near = step.model.scheme.inertia or held.error <= FAR
            step.assemble(held, self.updates.near if near else self.updates.far, elastic_share(step, held.error))
        with phase("solve"):
            return step.system.solve(held.soil, held.body, linear_tolerance(step.model.solver, self.finest, held.error))

    def misled(self, before, trial):
        """Whether the first update, from `before` to `trial`, was made with a tangent that no longer serves and is not to be
        taken."""
        if self.first is not None:
            return False
        left = np.inf if isinstance(trial, Refusal) else trial.error / before.error
        self.first = left < SERVES
        if self.carried and left >= _good(self.step):
            self.step.carried.fail()
        return self.carried and left > SLOW

    def keep_tangent(self, updates):
        """Let the next increment begin with the tangent of this one, which has converged in so many `updates`."""
        if self.first and updates <= CALM:
            self.step.carried.keep(self.step.dt)

    def follow(self, before, trial):
        """Evaluation to go on from after an update from `before` to `trial`."""
        after, updates = trial, self.updates
        if updates.smooth and trial.error > max(SLOW * before.error, self.step.model.solver.tolerance):
            after = smoothed(self.step, trial, updates)
        poor = after.error > SLOW * before.error        # near the solution slip turns round without harm
        self.stick = sticking.reversing(before, after, self.stick) if poor else None
        # points sent to another facet by the update and back by what smooths it jump as well
        self.jumps.append(jumped(before, trial) or after is not trial and jumped(before, after))
        self.reuse = _tangent_serves(self.step, before, after)
        return after

    def jumping(self):
        """Whether contact points have jumped between facets in more than one of the last updates."""
        return sum(self.jumps[-self.updates.patience:]) > 1


def elastic_share(step, error):
    """Share [-] of the elastic tangent in that of soil that yields, at an evaluation of this `error`; none with inertia,
    which is stiffness where soil has opened."""
    return 0.0 if step.model.scheme.inertia else ELASTIC * min(error, 1.0)


def _tangent_serves(step, before, after):
    """Whether the tangent of the update between two evaluations is used for the next one. Assembling and factoring the soil
    block costs several solutions; the bodies' few unknowns cost nothing."""
    return bool(step.system.soil_unknowns) and after.error < _good(step) * before.error


def _good(step):
    """Share of the residual that the update of a tangent leaves which is used again."""
    return GOOD_YIELDING if step.model.soil.law.plastic else GOOD


def _diverged(evaluation, best, solver, updates):
    """Whether full updates have led away from the `best` evaluation, where backtracking can be tried from."""
    given_up = solver.line_search and not (updates.backtrack or updates.may_diverge)
    return given_up and evaluation.error > max(DIVERGED * best.error, LOST)


def _no_progress(best, errors, solver, updates):
    """Why updates with these `errors` were given up."""
    stuck = "" if progressing(errors, updates.patience) else f" without progress in the last {updates.patience}"
    return (f"residual {best.error:.2e} after {len(errors) - 1} iterations{stuck}, "
            f"tolerance {solver.tolerance:.0e} ({_with_units(best.norms)})")


def jumped(before, after):
    """Whether contact points have left or reached plane facets between two evaluations of a step."""
    return any(held_facets.switched(a, b, terms.step.body.surface)
               for terms, a, b in zip(before.bodies, before.contacts, after.contacts))


def linear_tolerance(solver, finest, error):
    """Relative tolerance of a linear system whose right-hand side is the residual of this `error`: `finest`, as a rule, or
    in the same proportion what leaves LEFT of the tolerance."""
    enough = LEFT * solver.tolerance / max(error, solver.tolerance)     # in stick it may be none
    return max(finest, min(COARSEST, finest / solver.linear_tolerance * enough))


def smoothed(step, evaluation, updates):
    """Evaluation after the few nodes that carry most of its residual, and the bodies, have been solved for by themselves
    (`hybrid.step.restriction`); `evaluation` itself where they are not few, or have no better solution."""
    nodes = rough_nodes(step, evaluation)
    if nodes is None:
        return evaluation
    part = restricted(step, nodes, evaluation)
    try:
        start = part.evaluate(evaluation.unknowns)
        part = part.solved_to(max(SMOOTH * start.error, step.model.solver.tolerance))
        outcome = iterate(part, start, replace(updates, patience=BRIEF, backtrack=True, smooth=False))
    finally:
        part.system.destroy()
    new = step.evaluate(outcome.evaluation.unknowns)
    return new if not isinstance(new, Refusal) else step.evaluate(evaluation.unknowns)


def _with_units(norms):
    """Text such as "soil 0.879 N, anchor 12 N m" from norms {"soil [N]": 0.879, "anchor [N m]": 12}."""
    parts = ((*key.removesuffix("]").rsplit(" [", 1), value) for key, value in norms.items())
    return ", ".join(f"{name} {value:.3g} {unit}" for name, unit, value in parts)


def progressing(errors, patience=PATIENCE):
    """Whether the smallest of the `errors` has fallen below FALL of itself within the last `patience` iterations."""
    return len(errors) <= patience or min(errors[-patience:]) < FALL * min(errors[:-patience])


def line_search(step, old, soil, body, backtrack):
    """First evaluation along the update (soil, body) that lowers the error by enough, else the best of those tried; a
    Refusal where none exists; and the share of the update that it took. backtrack: False takes the full update if it has
    an evaluation.

    Where sand opens and closes, full updates overshoot the solution alternately: each lowers the error a little, half
    of one by a lot.
    """
    scale, best, taken, refusal = 1.0, None, 1.0, Refusal("gives no finite residual")
    while scale >= SHORTEST:
        new = step.evaluate(step.moved(old.unknowns, soil, body, scale), keep=best)
        if isinstance(new, Refusal):
            refusal, error = new, float("inf")
        elif not backtrack or new.error < ENOUGH * old.error:
            return new, scale
        else:
            error = new.error
        if best is not None and best.error < min(error, old.error):     # the minimum has been passed
            break
        if error < (float("inf") if best is None else best.error):
            best, taken = new, scale
        scale /= 2
    return (refusal if best is None else best), taken
