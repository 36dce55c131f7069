"""What libraries expect of the process they run in and may not find there: a home, PATH, standard streams.

ffcx, the compiler of forms, matplotlib and pyvista read or make folders in the home of the user and end the program
where they may not. A user without a home gets a folder for temporary files in its place, for this process and those
that it starts. PETSc would end the program at a signal that it is able to handle, such as that of a pipe nobody reads.
"""

import atexit
import contextlib
import os
import shutil
import stat
import sys
import tempfile
from pathlib import Path

PETSC = "-no_signal_handler"
FOLDERS = {"XDG_CACHE_HOME": ".cache", "XDG_CONFIG_HOME": ".config"}


def prepare():
    """Give this process PATH, and a home that can be written, where it has none, and the signals. Never fails."""
    if not os.environ.get("PATH"):
        os.environ["PATH"] = os.defpath
    given = os.environ.get("PETSC_OPTIONS", "")
    if PETSC not in given:
        os.environ["PETSC_OPTIONS"] = f"{given} {PETSC}".strip()
    if not _usable_home():
        folder = private_folder()
        if folder is not None:
            os.environ["HOME"] = str(folder)
            os.environ.update({name: str(folder / place) for name, place in FOLDERS.items()})


def open_streams():
    """Give a process that was started with closed standard streams ones that lead nowhere: files that are opened later
    would take their numbers, and get what a library writes to them."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            silence(number)
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))


def silence(number):
    """Lead a standard stream of this process nowhere."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    if nowhere != number:
        os.dup2(nowhere, number)
        os.close(nowhere)


def private_folder():
    """Folder for temporary files that nobody else can write to, the same in each run; None where there can be none."""
    try:
        folder = Path(tempfile.gettempdir()) / f"hybrid-{os.getuid()}"
        with contextlib.suppress(FileExistsError):
            folder.mkdir(mode=0o700)
        if _mine(folder):
            return folder
        folder = tempfile.mkdtemp(prefix="hybrid-")     # somebody else has made the other one
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        return Path(folder)
    except OSError:
        return None


def _mine(folder):
    found = folder.lstat()
    others = found.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    return stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid() and not others and os.access(folder, os.W_OK)


def _usable_home():
    """Whether the folders of FOLDERS can be written, or made."""
    home = os.environ.get("HOME")
    if home is None:
        try:
            home = Path.home()
        except RuntimeError:    # no such user
            return False
    return all(_can_write(Path(os.environ.get(name) or Path(home) / place)) for name, place in FOLDERS.items())


def _can_write(folder):
    """Whether a folder is one that can be written, or can be made."""
    if not folder.is_absolute():
        return False
    try:
        while not os.path.lexists(folder):
            folder = folder.parent
    except OSError:
        return False
    return folder.is_dir() and os.access(folder, os.R_OK | os.W_OK | os.X_OK)
