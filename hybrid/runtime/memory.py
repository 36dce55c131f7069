"""Memory of this process: its peak, what the machine has left, what a direct factor needs, and the return of freed
arrays to the system.

PETSc may be linked with SuperLU_DIST, which, when it is loaded, sets glibc never to map a large array by itself and
never to return memory to the system (mallopt M_MMAP_MAX = 0, M_TRIM_THRESHOLD = -1). Matrices whose pattern changes
then fragment the heap: a drag of 60 000 unknowns held 2.6 GiB after seven steps, and 1.9 GiB with large arrays mapped
again.
"""

import ctypes
import math
import resource

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
    """Memory [bytes] that the machine has left; infinite where the system does not report it."""
    try:
        with open("/proc/meminfo", encoding="ascii") as file:
            return 1024 * next(int(line.split()[1]) for line in file if line.startswith("MemAvailable"))
    except (OSError, StopIteration):
        return math.inf


def direct_factor_memory(unknowns, plane=False):
    """Estimated memory [bytes] of a direct factor of so many unknowns, in space or in a plane."""
    if plane:
        return BYTES_OF_PLANE_FILL * unknowns * math.log2(max(unknowns, 2))
    return BYTES_OF_FILL * unknowns ** (4 / 3)
