"""Wall time by phase. Phases do not nest; the simulation reads and resets the totals after each step."""

import time
from collections import defaultdict
from contextlib import contextmanager

PHASES = ("transfer", "contact search", "soil", "contact", "assemble", "factor", "solve", "update", "energy")    # of a step
seconds = defaultdict(float)


@contextmanager
def phase(name):
    """Add the wall time of the enclosed block to `seconds[name]`."""
    begin = time.perf_counter()
    try:
        yield
    finally:
        seconds[name] += time.perf_counter() - begin


def collect():
    """Totals [s] by phase since the last call."""
    totals = dict(seconds)
    seconds.clear()
    return totals
