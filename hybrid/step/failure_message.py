"""Message of a step that failed: place, value and limit, then causes and remedies (`hybrid.monitors.failure_hints`)."""

from hybrid.monitors.failure_hints import accuracy_remedies, advice, either


def not_converged(step, outcome, finest, smallest):
    """Text for an increment without a solution that cannot be halved any more; finest: [s] limit of the step, `smallest` of
    the scene or less in an impact."""
    history = " ".join(f"{error:.1e}" for error in outcome.errors[-6:])
    residuals = f"Last relative residuals: {history}. " if history else ""
    return (f"{_where(step)}: {outcome.reason}; half of it is below the limit of {_limit(finest, smallest)}. "
            f"{advice(step, outcome, step.model.solver)}. {residuals}All accepted steps are kept")


def not_accurate(step, error, allowed, accuracy, finest, smallest):
    """Text for an increment that is not accurate at the `finest` length [s], as in `not_converged`.

    error: LocalError; allowed: [m] share of the increment in the `accuracy` [m] of the outer step.
    """
    return (f"{_where(step)}: it adds {error.length:.3g} m to the error of {error.of}, limit {allowed:.3g} m, its "
            f"share of {accuracy:.3g} m a step (time.accuracy times the smallest cell), and it cannot be shorter than "
            f"{_limit(finest, smallest)}. Use {either(accuracy_remedies(step.model))}. All accepted steps are "
            "kept")


def _limit(finest, smallest):
    of = "time.smallest" if finest == smallest else "a small share of what the impact of the bodies needs"
    return f"{finest:.3g} s ({of})"


def _where(step):
    return f"step {step.state.step + 1} failed at t = {step.state.time:.6g} s with an increment of {step.dt:.3g} s"
