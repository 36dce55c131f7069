"""Memory of this process: its peak, what is left to it, what a direct factor needs, and the return of freed arrays to
the system.

What is left is the least of what the machine has, what the control groups of the process allow (those of a container
or a batch job) and what its own limits do (`ulimit -v`).

PETSc may be linked with SuperLU_DIST, which, when it is loaded, sets glibc never to map a large array by itself and
never to return memory to the system (mallopt M_MMAP_MAX = 0, M_TRIM_THRESHOLD = -1). Matrices whose pattern changes
then fragment the heap: a drag of 60 000 unknowns held 2.6 GiB after seven steps, and 1.9 GiB with large arrays mapped
again.
"""

import ctypes
import math
import resource
from pathlib import Path

M_MMAP_THRESHOLD, M_MMAP_MAX = -3, -4   # of malloc.h
BYTES_OF_FILL = 1200        # [bytes] of a direct factor, times n^(4/3) for nested dissection of n unknowns in space,
BYTES_OF_PLANE_FILL = 300   # and times n log2(n) in a plane
LARGE = 32 * 2**20  # bytes, the largest threshold of glibc; the arrays of an iteration are smaller
MAPPED = 65536      # arrays at once, glibc's default


def map_large_arrays():
    """Give each large array pages of its own, which return to the system when it is freed. No effect where the C
    library has no mallopt."""
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt:
        mallopt(M_MMAP_THRESHOLD, LARGE)
        mallopt(M_MMAP_MAX, MAPPED)


def peak_memory():
    """Largest memory [bytes] that this process has held; on Linux without that of its parent."""
    try:
        with open("/proc/self/status", encoding="ascii") as file:
            return 1024 * next(int(line.split()[1]) for line in file if line.startswith("VmHWM"))
    except (OSError, StopIteration):
        return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def available_memory():
    """Memory [bytes] that this process can still get; infinite where the system does not report it."""
    return max(0, min(_machine_memory(), _group_memory(), _own_memory()))


def _machine_memory():
    """Memory [bytes] that the machine has left."""
    try:
        with open("/proc/meminfo", encoding="ascii") as file:
            return 1024 * next(int(line.split()[1]) for line in file if line.startswith("MemAvailable"))
    except (OSError, StopIteration):
        return math.inf


def _group_memory(root="/sys/fs/cgroup", own="/proc/self/cgroup"):
    """Memory [bytes] that the control groups of the process have left, of version 1 or 2. Files that the system keeps
    in memory and nobody reads do not count as used."""
    left = math.inf
    try:
        groups = [line.strip().split(":", 2) for line in Path(own).read_text(encoding="ascii").splitlines()]
    except (OSError, ValueError):
        return left
    for number, controllers, path in groups:
        if number == "0":
            base, limit, used = Path(root), "memory.max", "memory.current"
        elif "memory" in controllers.split(","):
            base, limit, used = Path(root) / "memory", "memory.limit_in_bytes", "memory.usage_in_bytes"
        else:
            continue
        place = base / path.lstrip("/")
        for folder in (place, *place.parents):
            left = min(left, _left_in(folder, limit, used))
            if folder == base:
                break
    return left


def _left_in(folder, limit, used):
    try:
        stat, limit, used = ((folder / name).read_text(encoding="ascii") for name in ("memory.stat", limit, used))
        idle = {name: int(value) for name, value in (line.split() for line in stat.splitlines())}
        return int(limit) - int(used) + idle.get("total_inactive_file", idle.get("inactive_file", 0))
    except (OSError, ValueError):   # no such group in this name space; "max"
        return math.inf


def _own_memory():
    """Address space [bytes] that the limit of the process leaves."""
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    if limit == resource.RLIM_INFINITY:
        return math.inf
    try:
        with open("/proc/self/statm", encoding="ascii") as file:
            return limit - resource.getpagesize() * int(file.read().split()[0])
    except OSError:
        return limit


def direct_factor_memory(unknowns, plane=False):
    """Estimated memory [bytes] of a direct factor of so many unknowns, in space or in a plane."""
    if plane:
        return BYTES_OF_PLANE_FILL * unknowns * math.log2(max(unknowns, 2))
    return BYTES_OF_FILL * unknowns ** (4 / 3)
