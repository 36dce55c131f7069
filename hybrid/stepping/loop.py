"""The outer step: increments that are accepted, or rejected and halved, until its end is reached.

    committed state -> Step (frozen) -> Newton on trial values -> converged?  yes: new committed state
                                                                              no:  halve the increment, try again
"""

from dataclasses import dataclass

from hybrid.errors import StepError
from hybrid.stepping import newton
from hybrid.system.equations import Evaluation, Step

EASY = 6  # Newton iterations up to which the next increment may be twice as long


@dataclass
class Control:
    """Increment control: `dt` is what the next increment tries [s], `smallest` the floor [s]."""

    dt: float
    smallest: float


@dataclass(frozen=True)
class Report:
    """What an outer step took. dt: its smallest increment [s]; evaluation: the last converged one."""

    dt: float
    increments: int
    iterations: int
    krylov: int
    rejections: int
    evaluation: Evaluation


def outer_step(model, systems, state, length, pulling, control, settings):
    """Advance `state` by `length` [s]; returns (new state, Report).

    Raises StepError when the increment would fall below control.smallest; the committed state is untouched.
    """
    end, reached = state.time + length, state
    control.dt = min(control.dt, length)
    smallest, increments, iterations, krylov, rejections = length, 0, 0, 0, 0
    while end - reached.time > 1e-9 * length:
        dt = min(control.dt, end - reached.time)
        step = Step(model, reached, dt, pulling, systems)
        outcome = newton.solve(step, settings)
        iterations, krylov = iterations + outcome.iterations, krylov + outcome.krylov
        if not outcome.converged:
            rejections += 1
            control.dt = dt / 2
            if control.dt < control.smallest:
                raise StepError(_failure(model, reached, dt, control, outcome))
            continue
        reached = step.accept(outcome.evaluation)
        increments, smallest = increments + 1, min(smallest, dt)
        if outcome.iterations <= EASY:
            control.dt = min(2 * control.dt, length)
    reached.time, reached.step = end, state.step + 1
    return reached, Report(smallest, increments, iterations, krylov, rejections, outcome.evaluation)


def _failure(model, state, dt, control, outcome):
    history = " ".join(f"{e:.1e}" for e in outcome.errors[-6:])
    return (f"step {state.step + 1} failed at t = {state.time:.6g} s with increment {dt:.3g} s: {outcome.reason}; "
            f"half of it is below the floor of {control.smallest:.3g} s (time.smallest). "
            f"Last relative residuals: {history}. All accepted steps are kept. Try a smaller time.step, "
            "a lower body.penalty, more solver.iterations, or a looser solver.tolerance"
            + (". Without inertia, this is also how soil ends that cannot carry its load" if not model.scheme.inertia
               else ""))
