"""Memory of this process: the most it has held, and that what is freed goes back to the system.

A library that PETSc may be linked with, SuperLU_DIST, tells glibc when it is loaded never to map a large array by
itself and never to give memory back (mallopt M_MMAP_MAX = 0, M_TRIM_THRESHOLD = -1). Matrices whose pattern changes
then leave holes that no later one quite fits: a drag of 60 000 unknowns held 2.6 GiB after seven steps, and 1.9 GiB
with large arrays mapped again.
"""

import ctypes
import resource

M_MMAP_THRESHOLD, M_MMAP_MAX = -3, -4   # of malloc.h
LARGE = 32 * 2**20  # bytes; glibc takes no more, and what an iteration needs and frees again is smaller
MAPPED = 65536      # arrays at once, glibc's default


def map_large_arrays():
    """Give each large array pages of its own, which go back when it is freed. Nothing where the C library has no
    mallopt."""
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt:
        mallopt(M_MMAP_THRESHOLD, LARGE)
        mallopt(M_MMAP_MAX, MAPPED)


def peak_memory():
    """Most memory [bytes] that this process has held; what a parent held does not count where Linux tells."""
    try:
        with open("/proc/self/status", encoding="ascii") as file:
            return 1024 * next(int(line.split()[1]) for line in file if line.startswith("VmHWM"))
    except (OSError, StopIteration):
        return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
