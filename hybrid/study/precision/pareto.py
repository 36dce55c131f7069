"""The Pareto front of records: those that no other record of the same problem beats in both cost and error."""

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
    """Cost of a record over the least cost on the front at an error as small; inf if it failed or has no such error."""
    if record.failed or not math.isfinite(record.errors.get(error, math.nan)):
        return math.inf
    as_accurate = [r for r in front(records, error, cost) if r.errors[error] <= record.errors[error]]
    return getattr(record, cost) / min(getattr(r, cost) for r in as_accurate)
