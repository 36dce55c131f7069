"""Newton's method with a backtracking line search on the equations of one increment."""

from dataclasses import dataclass, replace

from hybrid.runtime.errors import StepError
from hybrid.runtime.timing import phase
from hybrid.step.equations import Evaluation, Step

SHORTEST = 1 / 16  # of a Newton update, tried by the line search
# Of the residual, left by an update that is taken as it is (anchor, 60 steps: 391 and 402 evaluations, with 0.7 463 and
# 571 and a tenth more iterations).
ENOUGH = 0.8
# Of the soil, that may lose its stiffness if everything keeps its velocity. Sand that opens everywhere has no tangent
# to find the way with: a block that its own weight throws up takes 3 iterations from rest and 5 to 15 from there, or
# finds nothing (at 0.15 to 0.92). Before an anchor it is 0.02, and 60 steps from rest take a third more iterations.
OPENED = 0.1
# Springs far stiffer than cells hide what is left in the soil, and a corner that a poor solution lifts off is found
# wrong next time: linear systems are solved as much more tightly as contact is stiffer than STIFF cells, E h.
STIFF, FINEST = 20.0, 1e-12
# An update that leaves less than this of the residual earns its tangent another use; of soil that yields it must be all
# but exact (anchor, 60 steps: 383 to 401 iterations with 0.15, 259 to 269 with 0.01; an elastic block assembles half as
# often with 0.15).
GOOD, GOOD_YIELDING = 0.15, 0.01


@dataclass(frozen=True)
class Settings:
    """tolerance: relative residual; iterations: limit; line_search: shorten updates that do not help; augmentations:
    limit, augmentation_tolerance: relative residual that an update may leave, of the updates of contact multipliers;
    linear_tolerance, loosest_tolerance: of the Krylov method, near the solution and far from it."""

    tolerance: float = 1e-6
    iterations: int = 15
    line_search: bool = True
    augmentations: int = 5
    augmentation_tolerance: float = 1e-3
    linear_tolerance: float = 1e-3
    loosest_tolerance: float = 1e-3


@dataclass(frozen=True)
class Outcome:
    """evaluation: the last one, None when none exists; reason: empty when converged, else what went wrong."""

    evaluation: Evaluation | None
    iterations: int
    krylov: int
    errors: tuple[float, ...]
    reason: str = ""

    @property
    def converged(self):
        return not self.reason


def solve(step: Step, settings: Settings):
    """Outcome of Newton's method on `step`. Never raises for lack of convergence.

    With contact multipliers it is repeated while they change, as often as the settings allow: every one of these
    solutions is in equilibrium, and what overlap the last one leaves the next step goes on with.
    """
    if reason := step.rotation_too_large():
        return Outcome(None, 0, 0, (), reason)
    evaluation = _start(step)
    if evaluation is None:
        return Outcome(None, 0, 0, (), f"the first guess {step.model.soil.refusal}")
    outcome = _newton(step, settings, evaluation)
    for _ in range(settings.augmentations):
        if not outcome.converged or not step.augment(outcome.evaluation):
            break
        again = _newton(step, settings, step.evaluate(outcome.evaluation.unknowns))
        outcome = replace(again, iterations=outcome.iterations + again.iterations,
                          krylov=outcome.krylov + again.krylov, errors=outcome.errors + again.errors)
        if again.errors and again.errors[0] <= settings.augmentation_tolerance:
            break
    return replace(outcome, reason=rejection(step, outcome.evaluation)) if outcome.converged else outcome


def _start(step):
    """First evaluation: everything keeps its velocity, or where that opens the soil, stays; None where it cannot be."""
    evaluation = step.evaluate(step.predictor())
    if evaluation is None or not step.model.scheme.inertia or (opened := step.apex_fraction(evaluation)) < OPENED:
        return evaluation
    still = step.evaluate(step.at_rest())
    if still is not None and step.apex_fraction(still) < opened - OPENED:
        return still
    return step.evaluate(evaluation.unknowns)


def _newton(step, settings, evaluation):
    errors, krylov, current, forcing = [], 0, False, settings.loosest_tolerance
    finer = max(1.0, step.contrast() / STIFF)
    good = GOOD_YIELDING if step.model.soil.law.plastic else GOOD
    for iteration in range(settings.iterations + 1):
        errors.append(evaluation.error)
        if evaluation.error <= settings.tolerance:
            return Outcome(evaluation, iteration, krylov, tuple(errors))
        if iteration == settings.iterations:
            break
        try:
            if not current:
                step.assemble(evaluation)
            forcing = _forcing(settings, errors, forcing)
            with phase("solve"):
                soil, body, count = step.system.solve(
                    evaluation.soil, evaluation.body, max(forcing / finer, FINEST))
        except StepError as failure:
            return Outcome(evaluation, iteration, krylov, tuple(errors), str(failure))
        krylov += count
        evaluation = _search(step, evaluation, soil, body, settings.line_search)
        # assembling and factoring the soil block costs several solutions; a body's few unknowns cost nothing
        current = bool(step.pattern.size and evaluation and evaluation.error < good * errors[-1])
        if evaluation is None:
            return Outcome(None, iteration, krylov, tuple(errors), f"the update {step.model.soil.refusal}")
    norms = ", ".join(f"{value:.3g} {name}" for name, value in evaluation.norms.items())
    return Outcome(evaluation, settings.iterations, krylov, tuple(errors),
                   f"residual {evaluation.error:.2e} after {settings.iterations} iterations, "
                   f"tolerance {settings.tolerance:.0e} ({norms})")


def _forcing(settings, errors, last):
    """Tolerance of the Krylov method: no tighter than Newton's progress is worth (Eisenstat & Walker, SIAM J. Sci.
    Comput. 17 (1996) 16-32, choice 2 with its safeguards), nor than what is left to the tolerance."""
    loosest, tightest = settings.loosest_tolerance, settings.linear_tolerance
    if len(errors) == 1 or loosest <= tightest:
        return max(loosest, tightest)
    forcing = 0.9 * (errors[-1] / errors[-2]) ** 2
    if 0.9 * last**2 > 0.1:
        forcing = max(forcing, 0.9 * last**2)
    return min(loosest, max(forcing, tightest, 0.5 * settings.tolerance / errors[-1]))


def rejection(step, evaluation):
    """Why a converged increment must not be accepted: it is too long for turns or contact to have been seen rightly."""
    if reason := step.rotation_too_large(evaluation.unknowns):
        return reason
    ratio = step.search_radius_ratio(evaluation.unknowns)
    if ratio > 1:
        return f"soil and body moved {ratio:.1f} times the reach of the contact search"
    count = step.tunnelled(evaluation)
    return f"{count} corners of the soil passed through a body" if count else ""


def _search(step, old, soil, body, shorten):
    """First evaluation along the update that lowers the error by enough; else the best of those tried.

    Soil that opens under one update and closes under the next lowers the error a little by every whole update, and by
    a lot by half of one, so an update that gains little is not left at that.
    The evaluation returned is always the last one made: trial strains live in buffers that the next one overwrites.
    """
    scale, best, best_scale, tried = 1.0, float("inf"), 0.0, 0.0
    while scale >= SHORTEST:
        new = step.evaluate(step.moved(old.unknowns, soil, body, scale))
        error, tried = float("inf") if new is None else new.error, scale
        if new is not None and (not shorten or error < ENOUGH * old.error):
            return new
        if error > best and best < old.error:   # beyond the valley
            break
        if error < best:
            best, best_scale = error, scale
        scale /= 2
    if best == float("inf"):
        return None
    return new if tried == best_scale else step.evaluate(step.moved(old.unknowns, soil, body, best_scale))
