"""Which records are worth their cost: none else of the same problem is both cheaper and nearer."""

import math


def front(records, error, cost="time"):
    """Records on the Pareto front of a problem's `error`, the cheapest first. cost: "time" or "work"."""
    done = [r for r in records if not r.failed and not r.source and math.isfinite(r.errors.get(error, math.nan))]
    best, smallest = [], math.inf
    for record in sorted(done, key=lambda r: (getattr(r, cost), r.errors[error])):
        if record.errors[error] < smallest:
            best.append(record)
            smallest = record.errors[error]
    return best


def excess(record, records, error, cost="time"):
    """How many times the cost of the front a record takes for its error, 1 on it; inf where it failed or has none."""
    if record.failed or not math.isfinite(record.errors.get(error, math.nan)):
        return math.inf
    reached = [r for r in front(records, error, cost) if r.errors[error] <= record.errors[error]]
    return getattr(record, cost) / min(getattr(r, cost) for r in reached)


def cheapest(records, error, target):
    """The cheapest record whose error is no larger than `target`; None where no record is that near."""
    return next((r for r in front(records, error) if r.errors[error] <= target), None)
