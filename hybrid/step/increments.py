"""The outer step: increments that are accepted, or rejected and halved, until its end is reached.

    committed state -> Step (frozen) -> Newton on trial values -> converged?  yes: new committed state
                                                                              no:  halve the increment, try again

Where the scene asks for accuracy, a converged increment has to be accurate too, and its error sets the length of the
next one (`hybrid.step.error_estimate`).
"""

from dataclasses import dataclass

from hybrid.monitors.failure_hints import accuracy_remedies, advice, either
from hybrid.monitors.plastic_increment import largest_increment
from hybrid.runtime.errors import StepError
from hybrid.step import newton
from hybrid.step.equations import Evaluation, Step
from hybrid.step.error_estimate import even, following, local_error, shorter

EASY = 6  # Newton iterations up to which the next increment may be twice as long


@dataclass
class Control:
    """Increment control: `dt` is what the next increment tries [s], `smallest` the floor [s], `accuracy` the error of
    positions that an outer step may add [m], None where only convergence is asked for."""

    dt: float
    smallest: float
    accuracy: float | None = None
    _rejected: bool = False     # the last trial

    def increment(self, rest):
        """What to try [s] with `rest` [s] of the outer step left."""
        dt = min(self.dt, rest)
        return even(dt, rest) if self.accuracy else dt

    def rejected(self, dt):
        """After a trial of `dt` [s] that gave no state."""
        self.dt, self._rejected = dt, True

    def accepted(self, dt, ratio, easy, length):
        """After an increment `dt` [s] of an outer step of `length` [s]. ratio: of its error to what it may be, None
        without accuracy; easy: Newton's method took it easily."""
        if ratio is not None:
            dt = following(dt, ratio, easy and not self._rejected)
            self.dt = min(max(dt, self.smallest), length)
        elif easy:
            self.dt = min(2 * self.dt, length)
        self._rejected = False


@dataclass(frozen=True)
class Report:
    """What an outer step took. dt: its smallest increment [s]; evaluation: the last converged one; error: sum of the
    local errors of its increments [m], None without time.accuracy; plastic_increment: largest plastic strain [-] that an
    increment added to a point, 0 with inertia."""

    dt: float
    increments: int
    iterations: int
    krylov: int
    rejections: int
    evaluation: Evaluation
    error: float | None = None
    plastic_increment: float = 0.0


def outer_step(model, systems, state, length, pulling, control, settings):
    """Advance `state` by `length` [s]; returns (new state, Report).

    Raises StepError when the increment would fall below control.smallest; the committed state is untouched.
    """
    end, reached = state.time + length, state
    control.dt = min(control.dt, length)
    smallest, increments, iterations, krylov, rejections = length, 0, 0, 0, 0
    ratio, added, plastic = None, 0.0 if control.accuracy else None, 0.0
    while end - reached.time > 1e-9 * length:
        dt = control.increment(end - reached.time)
        step = outcome = None   # the last one's arrays go before the next one's come
        step = Step(model, reached, dt, pulling, systems)
        outcome = newton.solve(step, settings)
        iterations, krylov = iterations + outcome.iterations, krylov + outcome.krylov
        if not outcome.converged:
            rejections += 1
            control.rejected(dt / 2)
            if control.dt < control.smallest:
                raise StepError(_failure(step, reached, dt, control, outcome, settings))
            continue
        if control.accuracy:
            error = local_error(step, outcome.evaluation)
            ratio = error.length / (control.accuracy * dt / length)
            if ratio > 1:
                rejections += 1
                if dt <= control.smallest * (1 + 1e-9):
                    raise StepError(_inaccurate(model, reached, dt, control, error, length))
                control.rejected(max(shorter(dt, ratio), control.smallest))
                continue
            added += error.length
        before, reached = reached, step.accept(outcome.evaluation)
        if not model.scheme.inertia:
            plastic = max(plastic, largest_increment(before.points, reached.points))
        increments, smallest = increments + 1, min(smallest, dt)
        control.accepted(dt, ratio, outcome.iterations <= EASY, length)
    reached.time, reached.step = end, state.step + 1
    return reached, Report(smallest, increments, iterations, krylov, rejections, outcome.evaluation, added,
                           plastic)


def _failure(step, state, dt, control, outcome, settings):
    history = " ".join(f"{e:.1e}" for e in outcome.errors[-6:])
    residuals = f"Last relative residuals: {history}. " if history else ""
    return (f"step {state.step + 1} failed at t = {state.time:.6g} s with an increment of {dt:.3g} s: {outcome.reason}; "
            f"half of it is below the limit of {control.smallest:.3g} s (time.smallest). "
            f"{advice(step, outcome, settings)}. {residuals}All accepted steps are kept")


def _inaccurate(model, state, dt, control, error, length):
    return (f"step {state.step + 1} failed at t = {state.time:.6g} s with an increment of {dt:.3g} s: it adds "
            f"{error.length:.3g} m to the error of {error.of}, limit {control.accuracy * dt / length:.3g} m, its share "
            f"of {control.accuracy:.3g} m a step (time.accuracy times the smallest cell), and it cannot be shorter than "
            f"{control.smallest:.3g} s (time.smallest). Use {either(accuracy_remedies(model))}. All accepted steps are "
            "kept")
