"""Observers of a run: they read the simulation after each accepted step and write files, and never change it.

An observer has three methods, called by the simulation:

    start(simulation)              before the first step of this session, also when a run is resumed
    accepted(record, simulation)   after every accepted outer step; record is a `hybrid.output.record.Record`
    finish(summary, simulation)    once at the end; summary["outcome"] is completed, failed or interrupted

Of several processes all have the same observers and call them together (`hybrid.output.first`).

An OSError of an observer stops the run, which can then be resumed: the step whose results could not be written is not
in the checkpoint, and is computed again.
"""

import os
from contextlib import contextmanager
from pathlib import Path

from hybrid.runtime import ranks
from hybrid.runtime.errors import OutputError


@contextmanager
def atomic(path):
    """Give a temporary name beside `path` and move it into place only if the block succeeds.

    A reader therefore finds the old file or the new one, also after an interrupted run or a power cut, and never a part
    of one.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = partial_name(path)
    try:
        yield partial
        sync(partial)
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)


def partial_name(path):
    """Temporary name of a file that is being written."""
    return path.with_name(f".{path.name}.partial")


def sync(path):
    """Wait until a file, or the names in a folder, are on disk."""
    number = os.open(path, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)


@contextmanager
def output_errors(place):
    """Context in which an OSError becomes an OutputError with the file, or else `place`, and the remedy."""
    try:
        yield
    except OSError as error:
        name = error.filename if error.filename is not None else place
        raise OutputError(f"{name}: cannot be written ({error.strerror or error}); make room for the results, or make "
                          "their folder writable, and continue by --resume") from error


def errors_of(observer):
    """Context in which an OSError becomes an OutputError with the file, or the folder, of the observer."""
    return output_errors(getattr(observer, "path", None) or getattr(observer, "folder", None) or "the results")


def standard(folder, progress=True, run=""):
    """The observers of `hybrid run`, in the order in which they must be called; they write all files of a run.

    folder: of the results (made if missing). progress: report it on stderr. run: identity of the run
    (`hybrid.output.run_folder`).
    """
    from hybrid.output.checkpoint import Checkpoints
    from hybrid.output.history import History
    from hybrid.output.pictures import Pictures
    from hybrid.output.progress import Progress
    from hybrid.output.summary import Summary
    from hybrid.output.vtk import Frames

    if ranks.started() > 1:
        return _of_several(folder, progress, run)
    # A checkpoint has all results up to its step beside it, so History and Frames come before Checkpoints. Summary and
    # Pictures read history.csv. Pictures take seconds at the end, by when all else is on disk; Progress has the last
    # word.
    observers = [History(folder), Frames(folder), Checkpoints(folder, run), Summary(folder, run), Pictures(folder)]
    return observers + [Progress(folder=folder)] * progress


def _of_several(folder, progress, run):
    """The same, for each of several processes."""
    from hybrid.output.checkpoint import PartCheckpoints
    from hybrid.output.first import First
    from hybrid.output.history import History
    from hybrid.output.pictures import Pictures, with_points_if_drawn
    from hybrid.output.pieces import Pieces
    from hybrid.output.progress import Progress
    from hybrid.output.summary import Summary
    from hybrid.output.vtk import Frames, with_forces_if_drawn

    observers = [First(lambda: History(folder)), Pieces(folder),
                 First(lambda: Frames(folder, soil=False), with_forces_if_drawn, alone=False),
                 PartCheckpoints(folder, run), First(lambda: Summary(folder, run)),
                 First(lambda: Pictures(folder), with_points_if_drawn)]
    return observers + [First(lambda: Progress(folder=folder))] * progress
