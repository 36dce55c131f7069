"""Message of a step that failed: place, value and limit, then causes and remedies (`hybrid.monitors.failure_hints`)."""

from hybrid.monitors.failure_hints import accuracy_remedies, advice, either


def not_converged(step, outcome, smallest):
    """Text for an increment without a solution that cannot be halved any more; smallest: [s] limit."""
    history = " ".join(f"{error:.1e}" for error in outcome.errors[-6:])
    residuals = f"Last relative residuals: {history}. " if history else ""
    return (f"{_where(step)}: {outcome.reason}; half of it is below the limit of {smallest:.3g} s (time.smallest). "
            f"{advice(step, outcome, step.model.solver)}. {residuals}All accepted steps are kept")


def not_accurate(step, error, allowed, accuracy, smallest):
    """Text for an increment that is not accurate at the `smallest` length [s].

    error: LocalError; allowed: [m] share of the increment in the `accuracy` [m] of the outer step.
    """
    return (f"{_where(step)}: it adds {error.length:.3g} m to the error of {error.of}, limit {allowed:.3g} m, its "
            f"share of {accuracy:.3g} m a step (time.accuracy times the smallest cell), and it cannot be shorter than "
            f"{smallest:.3g} s (time.smallest). Use {either(accuracy_remedies(step.model))}. All accepted steps are "
            "kept")


def _where(step):
    return f"step {step.state.step + 1} failed at t = {step.state.time:.6g} s with an increment of {step.dt:.3g} s"
