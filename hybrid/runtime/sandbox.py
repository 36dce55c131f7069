"""Confine a process that reads files from strangers: no programs, no network, no files but those it was given.

On Linux two barriers of the kernel hold for the process and for all that it might start; neither can be lifted again.
Landlock refuses every file outside the given folder, and to execute any. Seccomp (on x86-64) lets only the system calls
pass that computing and reading need: none of them starts a process, opens a file for writing, changes a folder or opens
a connection. What is open already can still be written. Where the kernel has neither, the limits of processor time,
memory and size of files remain. See landlock(7), seccomp(2), and audit.h and landlock.h of the kernel.
"""

import ctypes
import errno
import os
import platform
import signal
import struct
import sys

SET_PDEATHSIG, GET_SECCOMP, SET_NO_NEW_PRIVS = 1, 21, 38           # of prctl
CREATE_RULESET, ADD_RULE, RESTRICT_SELF = 444, 445, 446            # Landlock's calls, on all machines
SECCOMP, SET_FILTER, ALL_THREADS = 317, 1, 1
X86_64 = 0xC000003E
EXECUTE, WRITE_FILE, READ_FILE, READ_DIR = 1, 2, 4, 8              # rights of Landlock
ALLOW, KILL, ERROR = 0x7FFF0000, 0x80000000, 0x00050000            # answers of a filter
LOAD, EQUAL, ANY_BIT, ANSWER = 0x20, 0x15, 0x45, 0x06              # instructions of a filter
NUMBER, MACHINE, ARGUMENT = 0, 4, 16                               # where a filter finds them; arguments have 8 bytes
WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC
THREAD = 0x10000                                                   # flag of clone: no process of its own
# Calls of x86-64 without effect outside the process: read, write, close, stat, fstat, lstat, poll, lseek, mmap,
# mprotect, munmap, brk, rt_sigaction, rt_sigprocmask, rt_sigreturn, pread64, pwrite64, readv, writev, access,
# sched_yield, mremap, mincore, madvise, nanosleep, getpid, exit, uname, getcwd, readlink, gettimeofday, getrlimit,
# getrusage, sysinfo, times, getuid, getgid, geteuid, getegid, getppid, sigaltstack, gettid, time, futex,
# sched_getaffinity, getdents64, clock_gettime, clock_getres, clock_nanosleep, exit_group, newfstatat, readlinkat,
# faccessat, set_robust_list, getcpu, getrandom, membarrier, statx, rseq, faccessat2
HARMLESS = (0, 1, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 17, 18, 19, 20, 21, 24, 25, 27, 28, 35, 39, 60, 63, 79,
            89, 96, 97, 98, 99, 100, 102, 104, 107, 108, 110, 131, 186, 201, 202, 204, 217, 228, 229, 230, 231, 262,
            267, 269, 273, 309, 318, 324, 332, 334, 439)
OPEN, CLONE, TGKILL, OPENAT, CLONE3 = 2, 56, 234, 257, 435


def offered():
    """Names of the barriers that this system has, "landlock" and "seccomp"; asks without changing anything."""
    names = []
    if sys.platform == "linux":
        if _landlock_version() > 0:
            names.append("landlock")
        if platform.machine() == "x86_64" and sys.maxsize > 2**32 and _libc().prctl(GET_SECCOMP, 0, 0, 0, 0) >= 0:
            names.append("seccomp")
    return names


def shortcoming():
    """What is not prevented on this system, as a text; empty if all is."""
    names = offered()
    if not names:
        return "not confined: this system has neither Landlock nor seccomp; only the text of the geometry is checked"
    if "landlock" not in names:
        return "may read files of this user: this system has no Landlock; the text of the geometry is checked"
    if "seccomp" not in names:
        return "confined by Landlock alone: seccomp is used on x86-64 only; the text of the geometry is checked"
    return ""


def confine(folder):
    """Confine this process for the rest of its life; it may read the files of `folder` and use what is open already.

    Raises OSError when a barrier that the system offers cannot be put up.
    """
    names = offered()
    if names:
        _checked(_libc().prctl(SET_NO_NEW_PRIVS, 1, 0, 0, 0))
    if "landlock" in names:
        _landlock(folder)
    if "seccomp" in names:
        _seccomp()
    if not names:
        _limit("NPROC", 0)      # keeps all but root from starting processes, and threads too


def limit(seconds, memory, file_size):
    """Limits of processor time [s], address space and size of each file [bytes]; the process ends with its parent."""
    for name, value in (("CPU", seconds), ("AS", memory), ("FSIZE", file_size), ("CORE", 0)):
        _limit(name, int(value))
    if sys.platform == "linux":
        _checked(_libc().prctl(SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0))


def _limit(name, value):
    import resource  # late: not on every system

    kind = getattr(resource, f"RLIMIT_{name}")
    hard = resource.getrlimit(kind)[1]
    value = value if hard == resource.RLIM_INFINITY else min(value, hard)
    resource.setrlimit(kind, (value, value + 1 if name == "CPU" and hard == resource.RLIM_INFINITY else value))


def _libc():
    return ctypes.CDLL(None, use_errno=True)


def _checked(result):
    if result < 0:
        code = ctypes.get_errno()
        raise OSError(code, os.strerror(code))
    return result


def _call(number, *arguments):
    """A system call that the C library has no function for."""
    plain = (ctypes.c_long(a) if isinstance(a, int) else a for a in arguments)
    return _libc().syscall(ctypes.c_long(number), *plain)


def _landlock_version():
    return _call(CREATE_RULESET, None, 0, 1)


def _landlock(folder):
    """Refuse all of the file system but to read the files of `folder`; TCP and signals too, where it knows them."""
    version = _landlock_version()
    rights = (1 << 13 + (version >= 2) + (version >= 3) + (version >= 5)) - 1
    handled = struct.pack("=QQQ", rights, 3 * (version >= 4), 3 * (version >= 6))
    rules = _checked(_call(CREATE_RULESET, handled, len(handled), 0))
    place = os.open(folder, os.O_PATH | os.O_CLOEXEC)
    try:
        _checked(_call(ADD_RULE, rules, 1, struct.pack("=Qi", READ_FILE | READ_DIR, place), 0))
        _checked(_call(RESTRICT_SELF, rules, 0))
    finally:
        os.close(place)
        os.close(rules)


def _seccomp():
    program = b"".join(struct.pack("=HBBI", *instruction) for instruction in _filter(os.getpid()))
    buffer = ctypes.create_string_buffer(program, len(program))
    header = struct.pack("HP", len(program) // 8, ctypes.addressof(buffer))
    failed = _checked(_call(SECCOMP, SET_FILTER, ALL_THREADS, header))
    if failed:
        raise OSError(errno.EPERM, f"thread {failed} cannot be confined")


def _filter(process):
    """Instructions (code, steps if true, steps if false, value) of the filter of this process."""
    refuse = (ANSWER, 0, 0, ERROR | errno.EPERM)
    program = [(LOAD, 0, 0, MACHINE), (EQUAL, 1, 0, X86_64), (ANSWER, 0, 0, KILL), (LOAD, 0, 0, NUMBER)]
    for number in HARMLESS:
        program += [(EQUAL, 0, 1, number), (ANSWER, 0, 0, ALLOW)]
    program += [(EQUAL, 0, 1, CLONE3), (ANSWER, 0, 0, ERROR | errno.ENOSYS)]   # the C library then takes clone
    for number, argument, test, value, answers in (
            (OPEN, 1, ANY_BIT, WRITING, (refuse[3], ALLOW)), (OPENAT, 2, ANY_BIT, WRITING, (refuse[3], ALLOW)),
            (CLONE, 0, ANY_BIT, THREAD, (ALLOW, refuse[3])), (TGKILL, 0, EQUAL, process, (ALLOW, refuse[3]))):
        program += [(EQUAL, 0, 4, number), (LOAD, 0, 0, ARGUMENT + 8 * argument), (test, 0, 1, value),
                    (ANSWER, 0, 0, answers[0]), (ANSWER, 0, 0, answers[1])]
    return [*program, refuse]
