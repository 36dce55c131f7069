"""Stamp of a measurement: machine, versions, commit, threads."""

import os
import platform
import subprocess
from pathlib import Path

from hybrid.output.summary import machine, versions


def stamp():
    """Dict of the machine, the versions of the libraries, git's commit (None outside a repository) and threads."""
    import numba

    return {
        "machine": {**machine(), "cpu": _cpu(), "memory_GiB": _memory()},
        "versions": versions(),
        "commit": commit(Path(__file__).parent),
        "numba_threads": numba.get_num_threads(),
    }


def commit(folder):
    """Hash of the commit that `folder` is at, "+" appended if files differ from it; None if git does not track the
    folder."""
    def git(*arguments):
        return subprocess.run(["git", "-C", str(folder), *arguments], capture_output=True, text=True, check=True).stdout

    try:
        git("ls-files", "--error-unmatch", ".")    # an installed package may lie in somebody else's repository
        head = git("rev-parse", "HEAD").strip()
        return head + ("+" if git("status", "--porcelain", "--untracked-files=no").strip() else "")
    except (OSError, subprocess.CalledProcessError):
        return None


def forget_peak():
    """Reset the peak memory of this process, if the system allows it."""
    try:
        with open("/proc/self/clear_refs", "w", encoding="ascii") as file:
            file.write("5")
    except OSError:
        pass


def _cpu():
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            return next(line.split(":", 1)[1].strip() for line in file if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or None


def _memory():
    try:
        return round(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30, 1)
    except (OSError, ValueError):
        return None
