"""The only place for sums, counts, extremes, norms and numbering over points, nodes, contact points or unknowns, and for
exchanging arrays between processes.

In a run by several processes each holds its own points and nodes (`hybrid.step.processes`). No other module may assume that
one process holds all of them: a number over all points is computed by a function of this module, from the values that this
process holds (tests/unit/test_comm.py lists the exceptions). All processes get the same number, bit for bit, because each
combines the same values in the same order; so all of them take the same decisions.

Before the soil is laid out, and in a run by one process, every process holds all values, and nothing is exchanged.
"""

from contextlib import contextmanager
from functools import reduce

import numpy as np

from hybrid.runtime.ranks import rank, world

_split = False      # whether each process holds only its share


def split():
    """From now on every process holds only its share of all values."""
    global _split
    _split = world() is not None


@contextmanager
def alone():
    """Context in which this process holds all values that it counts or adds up."""
    global _split
    before, _split = _split, False
    try:
        yield
    finally:
        _split = before


def _over_processes(local, combine):
    """Result over all processes from the `local` one of each; combine: function of two results."""
    return reduce(combine, world().allgather(local)) if _split else local


def total(values, axis=0):
    """Sum of an array along an axis, the first unless given, over all processes."""
    return _over_processes(np.sum(values, axis=axis), np.add)


def count(chosen):
    """Number of entries that are true or not zero, over all processes."""
    return int(_over_processes(np.count_nonzero(chosen), np.add))


def number(items):
    """Number of points, corners or other items that all processes hold."""
    return int(_over_processes(len(items), np.add))


def largest(values):
    """Largest of non-negative values, 0 of none, over all processes."""
    return float(_over_processes(np.max(values, initial=0.0), np.maximum))


def maximum(values, empty=0.0):
    """Largest of values of any sign, over all processes; `empty` if there is no value."""
    found = float(_over_processes(np.max(np.asarray(values, float), initial=-np.inf), np.maximum))
    return empty if found == -np.inf else found


def minimum(values, empty=0.0):
    """Smallest of values of any sign, over all processes; `empty` if there is no value."""
    found = float(_over_processes(np.min(np.asarray(values, float), initial=np.inf), np.minimum))
    return empty if found == np.inf else found


def anywhere(chosen):
    """Whether an entry is true or not zero in any process."""
    return bool(_over_processes(np.any(chosen), np.logical_or))


def norm(vector):
    """Euclidean norm of a vector that is distributed over all processes."""
    return float(_over_processes(np.linalg.norm(vector), np.hypot))


# ------------------------------------------------------------------ exchange of arrays


def gathered(values):
    """The entries of all processes, one process after the other, in every process: for few entries."""
    return np.concatenate(world().allgather(np.asarray(values))) if _split else values


def counts(numbers):
    """Sums of integers (...) over all processes, of each place by itself."""
    return world().allreduce(numbers) if _split else numbers


def offset(own):
    """Sum of `own` over the processes before this one."""
    return int(sum(world().allgather(own)[:rank()])) if _split else 0


def from_first(values):
    """Array of the first process, in every process."""
    return world().bcast(values)


def to_each(parcels):
    """parcels: one for each process; returns the parcels for this one, by sender. Its own, mostly the largest, stays as it
    is instead of being packed and unpacked."""
    here = rank()
    arrived = world().alltoall([*parcels[:here], None, *parcels[here + 1:]])
    return [*arrived[:here], parcels[here], *arrived[here + 1:]]


def to_first(parcel):
    """List of the parcels of all processes in the first one, None in the others."""
    return world().gather(parcel)


def neighbours(send, receive, width, kind):
    """Exchange arrays with other processes. send: {rank: array}; receive: {rank: length}; width: shape of an entry; kind:
    its dtype. Returns {rank: array (length, *width)}."""
    arrived = {other: np.empty((length, *width), kind) for other, length in receive.items()}
    kept = {other: np.ascontiguousarray(array) for other, array in send.items()}    # until they are sent
    requests = [world().Irecv(array, other) for other, array in arrived.items()]
    requests += [world().Isend(array, other) for other, array in kept.items()]
    for request in requests:
        request.Wait()
    return arrived
