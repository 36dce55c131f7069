"""The outer step: increments that are accepted, or rejected and halved, until its end is reached.

    committed state -> Step (frozen) -> Newton on trial values -> converged?  yes: new committed state
                                                                              no:  halve the increment, try again

Where the scene asks for accuracy, a converged increment has to be accurate too, and its error sets the length of the
next one (`hybrid.step.error_estimate`).
"""

from dataclasses import dataclass

from hybrid.monitors.failure_hints import likely
from hybrid.monitors.plastic_increment import flowed
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
    local errors of its increments [m], None where nobody asked; flow: the most that an increment added to the plastic
    strain of a point, 0 with inertia."""

    dt: float
    increments: int
    iterations: int
    krylov: int
    rejections: int
    evaluation: Evaluation
    error: float | None = None
    flow: float = 0.0


def outer_step(model, systems, state, length, pulling, control, settings):
    """Advance `state` by `length` [s]; returns (new state, Report).

    Raises StepError when the increment would fall below control.smallest; the committed state is untouched.
    """
    end, reached = state.time + length, state
    control.dt = min(control.dt, length)
    smallest, increments, iterations, krylov, rejections = length, 0, 0, 0, 0
    ratio, added, flow = None, 0.0 if control.accuracy else None, 0.0
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
                raise StepError(_failure(model, reached, dt, control, outcome) + likely(step, outcome.evaluation))
            continue
        if control.accuracy:
            error = local_error(step, outcome.evaluation)
            ratio = error.length / (control.accuracy * dt / length)
            if ratio > 1:
                rejections += 1
                if dt <= control.smallest * (1 + 1e-9):
                    raise StepError(_inaccurate(reached, dt, control, error, length))
                control.rejected(max(shorter(dt, ratio), control.smallest))
                continue
            added += error.length
        before, reached = reached, step.accept(outcome.evaluation)
        if not model.scheme.inertia:
            flow = max(flow, flowed(before.points, reached.points))
        increments, smallest = increments + 1, min(smallest, dt)
        control.accepted(dt, ratio, outcome.iterations <= EASY, length)
    reached.time, reached.step = end, state.step + 1
    return reached, Report(smallest, increments, iterations, krylov, rejections, outcome.evaluation, added,
                           flow)


def _failure(model, state, dt, control, outcome):
    history = " ".join(f"{e:.1e}" for e in outcome.errors[-6:])
    return (f"step {state.step + 1} failed at t = {state.time:.6g} s with increment {dt:.3g} s: {outcome.reason}; "
            f"half of it is below the floor of {control.smallest:.3g} s (time.smallest). "
            f"Last relative residuals: {history}. All accepted steps are kept. Try a smaller time.step, "
            "a lower body.penalty, more solver.iterations, or a looser solver.tolerance")


def _inaccurate(state, dt, control, error, length):
    return (f"step {state.step + 1} failed at t = {state.time:.6g} s with increment {dt:.3g} s: it adds "
            f"{error.length:.3g} m to the error of {error.of}, more than its share, "
            f"{control.accuracy * dt / length:.3g} m of {control.accuracy:.3g} m a step (time.accuracy times the "
            f"smallest cell), and it is at the floor of {control.smallest:.3g} s (time.smallest). All accepted steps "
            "are kept. Try a larger time.accuracy, a smaller time.smallest, a lower body.penalty, or a scheme that "
            "damps")
