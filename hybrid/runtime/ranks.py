"""The processes of a run: how many there are, which one this is, and how they end together.

The only module that gives the communicator of all of them, through which `hybrid.runtime.comm` exchanges data. dolfinx
starts MPI in every run with a body.

One process is the rule; several are started by mpirun (`hybrid run --ranks`). A fault that all of them find, such as a
mistake in the scene, is reported once and ends them all; one that a single process meets ends the others, which would
wait for it forever.
"""

import logging
import os
import subprocess
import sys
import time
from functools import cache

from hybrid.runtime.errors import HybridError

# Set by mpirun of Open MPI, MPICH and Intel MPI, and by srun --mpi
STARTED = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "MPI_LOCALNRANKS", "PMIX_RANK")

# Open MPI refuses to run as root, and more processes than cores, unless a variable allows it; 4 and 5 have a variable
# each for the latter. About every fault 4 prints a page of its own unless it is quiet; 5 always does, and refuses
# mpirun's -q. 5 complains when a machine's IPv4 and IPv6 addresses do not reach one another; processes of one machine
# need lo only.
OPEN_MPI = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMPI_MCA_orte_execute_quiet": "1",
            "OMPI_MCA_rmaps_base_oversubscribe": "1", "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
            "OMPI_MCA_hwloc_base_binding_policy": "none", "OMPI_MCA_btl_tcp_if_include": "lo",
            "OMPI_MCA_mpi_yield_when_idle": "1"}     # a rank that waits leaves its core to others


@cache
def world():
    """Communicator of all processes, None where one was started."""
    if not any(name in os.environ for name in STARTED):
        return None
    from mpi4py import MPI  # its import starts MPI, which one process needs for dolfinx only

    return MPI.COMM_WORLD if MPI.COMM_WORLD.size > 1 else None


def launch(number, program):
    """(command, environment) that start a Python `program`, a list of arguments, in so many processes of this machine. What
    the environment has already takes precedence."""
    threads = max(1, (os.cpu_count() or 1) // number)
    environment = OPEN_MPI | {"NUMBA_NUM_THREADS": str(threads)} | os.environ
    return ["mpirun", "-n", str(number), sys.executable, *map(str, program)], environment


def may_start():
    """Whether this process may become several: it was not started as one of some, and nobody has set its number of
    threads."""
    return not any(name in os.environ for name in (*STARTED, "NUMBA_NUM_THREADS"))


def can_start(number, seconds=60.0):
    """Whether mpirun can start so many processes here that know of one another; tried within some `seconds`."""
    command, environment = launch(number, ["-c", "from mpi4py import MPI; raise SystemExit(MPI.COMM_WORLD.size != "
                                                 f"{number})"])
    try:
        return subprocess.run(command, env=environment, capture_output=True, stdin=subprocess.DEVNULL,
                              timeout=seconds).returncode == 0
    except (OSError, subprocess.TimeoutExpired):
        return False


def started():
    """Number of processes that run this program together."""
    return world().size if world() else 1


def rank():
    """Number of this process, from 0."""
    return world().rank if world() else 0


@cache
def _last_words():
    """A communicator of its own, so that nothing else is mistaken for the end."""
    return world().Dup()


@cache
def _roll_call():
    """Another one, for the end of a run that may go on elsewhere."""
    return world().Dup()


def prepare():
    """To be called by all processes, before anything can fail; again it does nothing. Only the first one logs, and what
    ends one process by an exception that nobody catches ends all of them."""
    if world():
        _last_words()
        _roll_call()
        if not isinstance(sys.excepthook, _EndAll):
            sys.excepthook = _EndAll(sys.excepthook)
    if rank():
        logging.getLogger("hybrid").setLevel(logging.CRITICAL)


class _EndAll:
    """As sys.excepthook: ends the other processes, which would wait forever for one that ends by itself. before: the hook
    that reports the fault."""

    def __init__(self, before):
        self._before = before

    def __call__(self, *fault):
        alone = not end_together()
        if alone or rank() == 0:
            self._before(*fault)
        if alone:
            print(f"hybrid: this happened on rank {rank()} of {started()}; the others are ended", file=sys.stderr)
            sys.stderr.flush()
            abort(1)


def same_fault(error):
    """Raise the `error` of the first process, unless it is None, in all of them."""
    error = same(error)
    if error is not None:
        raise error


def in_first(function):
    """Result of a function that only the first process calls, None in the others; a HybridError or OSError is raised in
    all."""
    result = fault = None
    if rank() == 0:
        try:
            result = function()
        except (HybridError, OSError) as error:
            fault = error
    same_fault(fault)
    return result


def same(value):
    """The value of the first process, in all of them."""
    return world().bcast(value) if world() else value


def together(function):
    """Result of a function that every process calls. An OSError or HybridError of one is raised in all of them, and names
    it."""
    result = fault = None
    try:
        result = function()
    except (HybridError, OSError) as error:
        fault = error
    for number, error in enumerate(world().allgather(fault) if world() else [fault]):
        if isinstance(error, OSError) and world():
            raise OSError(error.errno, f"{error.strerror}; process {number}", error.filename)
        if error is not None:
            raise error
    return result


def all_here(seconds=10.0):
    """Whether all processes ask this within some `seconds`: none has ended or waits elsewhere."""
    return not world() or _all_come(_roll_call().Ibarrier(), seconds)


def end_together(seconds=10.0):
    """Whether all other processes end as well within some `seconds`; to be asked by one that has failed. A signal ends the
    wait."""
    try:
        return _all_come(_last_words().Ibarrier(), seconds)
    except KeyboardInterrupt:
        return False


def _all_come(request, seconds):
    """Whether a `request` of all processes is met within some `seconds`."""
    end = time.monotonic() + seconds
    while not request.Test():
        if time.monotonic() > end:
            return False
        time.sleep(0.01)
    return True


def abort(code):
    """End all processes at once."""
    world().Abort(code)
